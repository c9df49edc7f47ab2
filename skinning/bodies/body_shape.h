#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <vector>

namespace gelenk {

/// A value with its gradient in space. Both are uninitialised by default: evaluation keeps many of them on
/// the stack.
struct FieldSample {
  double value;
  Eigen::Vector3d gradient;
};

/// A cross-section of a generalised cylinder: the polar curve radius(theta) = r0 (1 + S), or r0 / sqrt(1 +
/// S), around its centre, with S = sum over n = 2..5 of cosine[n-2] cos(n theta) + sine[n-2] sin(n theta);
/// theta = 0 along v, 90 degrees along u.
struct Section {
  double at = 0.0;          ///< position along the axis, fraction of its length
  double u = 0.0, v = 0.0;  ///< centre, metres
  double radius = 0.0;      ///< r0, metres
  std::array<double, 4> cosine{}, sine{};
};

/// One part of a body. Negative inside; near the surface its value is close to the distance.
struct BodyPart {
  enum class Form {
    Polar,     ///< generalised cylinder, radius = r0 (1 + S): round sections
    Inverse,   ///< generalised cylinder, radius = r0 / sqrt(1 + S): exact ellipses, flat sections
    RoundCone  ///< the hull of a ball of radiusA around A and one of radiusB around B
  };
  Form form = Form::RoundCone;
  int parent = -1;            ///< the part it blends with, smaller than its own index; -1 for the first
  double blend = 0.0;         ///< radius of the smooth union with the parent
  double siblingBlend = 0.0;  ///< upper bound of the radius between children of one parent
  bool carved = false;        ///< taken away from its parent alone, not from what else joins it there
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::UnitZ();  ///< ends of the axis
  bool mirrored = false;                                                      ///< evaluated at (-x, y, z)

  // Generalised cylinders
  Eigen::Vector3d sectionUp = Eigen::Vector3d::UnitZ();  ///< v of the sections, as nearly as the axis allows
  std::vector<Section> sections = {};                    ///< ascending, at least two
  double capA = 0.0, capB = 0.0;  ///< lengths of the elliptical caps beyond the end sections

  // Round cones
  double radiusA = 0.0, radiusB = 0.0;
  double flatness = 1.0;  ///< thickness along `flat` relative to the width
  Eigen::Vector3d flat = Eigen::Vector3d::UnitZ();
};

/// A body as an implicit surface, F < 0 inside: a tree of parts, each blended smoothly with its parent only,
/// so that fingers or thighs that come near each other do not fuse.
///
/// smin_k(a, b) = min(a, b) - k h^3 / 4 with h = max(1 - |a - b| / (1.5 k), 0): curvature has no steps, which
/// would show as bands of light, and where both agree k / 4 is added. A part with own value f0 and children
/// c:
///     v_c = smin(f0, value(c), k_c); of those below f0, in ascending order, total = smin(total, v_c,
///     min(ksib, 1.5 (f0 - v_c))).
/// A carved part leaves max(f0, -its own value), rounded likewise, of its parent before all that.
/// Sorting makes the result independent of the children's order; the last factor ends the blend between
/// siblings where a child adds nothing. Dividing each part's value by an estimate of its slope makes radii
/// mean lengths.
class BodyShape {
 public:
  /// Throws std::invalid_argument: no part, a parent that does not come earlier, too few or unordered
  /// sections, a size that is not positive.
  explicit BodyShape(std::vector<BodyPart> parts);

  /// The parts that matter within a ball around the centre, where the surface is near. Evaluating a region
  /// costs as much as it has parts.
  class Region {
    friend class BodyShape;
    struct Node {
      int part;
      bool evaluated;  ///< otherwise far away: only its children matter
      int firstChild, childCount;
    };
    std::vector<Node> nodes_;    // parents first
    std::vector<int> children_;  // indices into nodes_
  };
  Region region(const Eigen::Vector3d& centre, double radius) const;
  Region everywhere() const;

  double value(const Eigen::Vector3d& p, const Region& region) const;
  /// The gradient leaves out the change of the slope estimate: exact on each part's own surface, a few per
  /// cent off elsewhere.
  FieldSample sample(const Eigen::Vector3d& p, const Region& region) const;

  const std::vector<BodyPart>& parts() const { return parts_; }
  /// A box that holds every part; blends may bulge out of it by some of their width.
  Eigen::AlignedBox3d bounds() const { return bounds_; }

 private:
  /// A part made ready: columns as cubic polynomials between the sections.
  struct Prepared;

  template <bool withGradient>
  FieldSample evaluate(const Eigen::Vector3d& p, const Region& region) const;
  Region regionOf(const std::vector<char>& evaluated) const;

  std::vector<BodyPart> parts_;
  std::shared_ptr<const std::vector<Prepared>> prepared_;
  std::vector<double> reach_;  // how near the surface a part must be to matter
  Eigen::AlignedBox3d bounds_;
};

}  // namespace gelenk
