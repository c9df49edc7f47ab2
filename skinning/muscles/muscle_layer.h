#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "skinning/muscles/ffd_lattice.h"

namespace gelenk {

// Muscle layers between skeleton and skin after Chadwick, Haumann and Parent 1989 (lecture 10.3), without any
// graphics and without a skeleton: a limb is a chain of links, each carrying two tri-cubic Bezier volumes
// that share a plane, so seven control planes a link:
//
//      o-----------------------------o           link i: origin at its joint, z along the bone, length L
//      |0   |1     |2 |3 |4     |5   |6          0, 1, 5, 6 connecting planes, 2, 3, 4 inner planes
//                                    |0' |1'     plane 6 of link i is plane 0 of link i + 1: the seam
//
// C1 everywhere: plane 3 is the midpoint of 2 and 4, a seam is the midpoint of 5 and 1'. The seam is primary
// and 5 and 1' follow from it (see seam rule in docs/muscles.md): the other way round shrinks the joint.
//
// The planes stand without the limb's twist, because a blend of turned planes shrinks. Each has an angle
// instead, and a point of the section is turned about the bone by the angles' blend before the planes move
// it.

/// Proportions of a limb; all that does not change while it moves. Metres.
struct LimbShape {
  struct Link {
    double length = 0.0;
    double middle = 0.0;  ///< distance of plane 3 from the link's origin
    double inner = 0.0;   ///< distance of planes 2 and 4 from plane 3
    double nearGap =
        0.0;  ///< distance between planes 0 and 1 of a straight link; equals farGap of the link before
    double farGap = 0.0;  ///< distance between planes 5 and 6 of a straight link
  };
  std::vector<Link> links;
  Eigen::Vector2d sectionLower = {
      -0.1, -0.1};  ///< one rectangle in x, y for the whole limb that contains all bound vertices
  Eigen::Vector2d sectionUpper = {0.1, 0.1};
  double wedge = 1.0 / 6.0;  ///< beta: planes 5 and 1' turn by (1/2 - beta) theta against their bones
  std::vector<double> seamTwistShare;  ///< of each seam, the part of the joint's twist that the link before
                                       ///< takes; 0 where not given: the link after spreads it all
};

/// The default proportions: joint gaps elbowGap min(L1, L2), inner planes L/10 around the middle, free ends
/// L/6. Throws std::invalid_argument for no link or a length that is not positive.
LimbShape defaultLimbShape(const std::vector<double>& lengths);

/// Gaps of the joints as a share of the shorter link, chosen with the bones drawn in. Larger: rounder, like a
/// hose. A smaller one brings upper and lower arm into contact before 130 degrees; the knee, with its thinner
/// hollow, bends sharper.
inline constexpr double elbowGap = 0.15, kneeGap = 0.08;
/// Sets the gaps on both sides of every joint to this share of the shorter link. validate() afterwards.
void setJointGap(LimbShape& shape, double share);
/// The share of the first joint.
double jointGap(const LimbShape& shape);

/// Throws std::invalid_argument, naming link and rule, unless 0 < nearGap < middle - inner and middle + inner
/// < length - farGap, gaps agree across every joint, the rectangle is not empty and 0 <= wedge < 1/2.
void validate(const LimbShape& shape);

/// Where the limb's bones are. Link i has its origin at joints[i] and runs along z of rotations[i] to
/// joints[i + 1].
struct LimbFrames {
  std::vector<Eigen::Vector3d> joints;     ///< one more than links, metres, world
  std::vector<Eigen::Matrix3d> rotations;  ///< worldFromLink
  double nearTwist = 0.0;  ///< twist about z of plane 0 against the first link, radians (the shoulder's own
                           ///< axial twist, undone)
  double farTwist = 0.0;   ///< twist of the last plane against the last link (what the hand adds)
  /// Of each joint between links, radians: whole turns beyond the (-pi, pi] that the rotations tell. Empty:
  /// none.
  std::vector<double> wholeTurns = {};
};

/// What the muscles do to planes 2 and 4 of a link: p -> stretch p + offset in section coordinates; the
/// identity at rest.
struct MusclePlane {
  Eigen::Matrix2d stretch = Eigen::Matrix2d::Identity();  ///< symmetric
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();       ///< metres
  /// Free displacement of the 16 control points in the link's frame, metres; empty: the plane stays affine.
  std::vector<Eigen::Vector3d> displacement = {};
};
struct MuscleState {
  MusclePlane plane2, plane4;
  double swell = 1.0;  ///< factor on x and y of the free displacements (volume rule)
};

/// The control planes of a posed limb: link i's seven planes are planes[6 i] ... planes[6 i + 6].
struct LimbPose {
  std::vector<FfdPlane> planes;  ///< world, the limb's twist taken out
  /// Of every plane, radians about the bone (right-handed along z): the section's turn at w is their blend
  /// sum_k B_k(w) turns_k.
  std::vector<double> turns;
  Eigen::Vector2d sectionLower = Eigen::Vector2d::Zero(), sectionSize = Eigen::Vector2d::Ones();  ///< metres
  /// Displacement of the control points beyond the affine planes, one lattice a volume, world; empty if none.
  std::vector<FfdLattice> displacement;
  /// What carries the free displacements of each link's planes 2 and 4 into the world: the section's turn,
  /// after the swell.
  std::vector<Eigen::Matrix3d> worldFromDisplacement;
  Eigen::Isometry3d worldFromNearEnd;  ///< frames of the first and last plane, which the body beyond the limb
                                       ///< continues rigidly
  Eigen::Isometry3d worldFromFarEnd;

  /// A plane with its turn: where the section's rectangle lies.
  FfdPlane turnedPlane(int plane) const;
  /// Its 4 x 4 control points (index 4 j + i), displacement included.
  std::array<Eigen::Vector3d, 16> controlPoints(int plane) const;
  int volumeCount() const { return static_cast<int>(planes.size() - 1) / 3; }
  /// (u, v, w) with u, v turned in the section by what the volume turns there, or back again (sign -1).
  /// Volume v = 2 i (planes 0-3 of link i) or 2 i + 1 (planes 3-6).
  Eigen::Vector3d turned(int volume, const Eigen::Vector3d& uvw, double sign = 1.0) const;
  Eigen::Vector3d position(int volume, const Eigen::Vector3d& uvw) const;
  FfdSample evaluate(int volume, const Eigen::Vector3d& uvw) const;
};

/// Seam and inner-plane rules. muscles: one a link, or empty for the limb without muscles.
LimbPose poseLimb(const LimbShape& shape, const LimbFrames& frames,
                  const std::vector<MuscleState>& muscles = {});

/// The free displacements of a link's muscles as a lattice of their own, in the frame they are given in: half
/// 0 planes 0-3, half 1 planes 3-6. Its sample at a vertex's (u, v, w), turned by worldFromDisplacement, is
/// what they add there.
FfdLattice displacementLattice(const MuscleState& muscle, int half);

/// Total bend and twist of a joint between two links, q = R_i^T R_{i+1} = swing * twist about z.
struct JointBend {
  double bend = 0.0;   ///< angle of the swing, [0, pi]
  double twist = 0.0;  ///< (-pi, pi]
  Eigen::Vector2d inside =
      Eigen::Vector2d::UnitX();  ///< unit, link i's section coordinates: the side the joint closes to
};
JointBend jointBend(const LimbFrames& frames, int joint);

}  // namespace gelenk
