#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/document/session.h"
#include "apps/lecture/leg_animation.h"
#include "apps/lecture/newton_runs.h"
#include "apps/render/overlay.h"
#include "apps/render/scene_label.h"
#include "kinematics/notation/dh_table.h"
#include "kinematics/notation/euler.h"
#include "solvers/ceres/nearest_solution.h"
#include "solvers/methods/newton.h"
#include "solvers/methods/two_link.h"

namespace gelenk {

struct Ghost;

/// Colours that mean the same in every example.
struct LectureColours {
  Colour first, second, linear, truth, target, faint, text;
};
LectureColours lectureColours(Theme theme);

/// What an example draws on: the document it belongs to, and lists of the picture.
struct LectureCanvas {
  const Session& session;
  double size;  ///< of the model, metres
  Overlay& overlay;
  std::vector<Ghost>& ghosts;
  std::vector<SceneLabel>& labels;
};

/// What an example of the lecture shows beside its model. It follows from the document: the pose, the goals,
/// and a state of the example's own, which is a line of text there (LectureState).
class LectureDrawing {
 public:
  virtual ~LectureDrawing() = default;
  virtual void draw(const LectureCanvas&) {}
  virtual std::string save() const { return {}; }
  /// What save() returned; what cannot be read is left as it is.
  virtual void load(const Session&, const std::string&) {}
};

/// Of a topic of lectureTopics(); throws std::invalid_argument for another id.
std::unique_ptr<LectureDrawing> makeLectureDrawing(const std::string& topic);

// --- 10.1: in the plane

class PlanarDrawing : public LectureDrawing {
 public:
  explicit PlanarDrawing(PlanarChain c) : chain(std::move(c)) {}
  const PlanarChain chain;

 protected:
  /// The chain as thin links with dots at the joints.
  void links(Overlay& overlay, const Eigen::VectorXd& phi, const Colour& colour, float width = 2.5f) const;
  /// A cross at a target.
  void cross(const LectureCanvas& canvas, const Eigen::Vector2d& at, const std::string& text) const;
};

class ForwardDrawing final : public PlanarDrawing {
 public:
  ForwardDrawing();
  void draw(const LectureCanvas& canvas) override;
  std::string save() const override;
  void load(const Session&, const std::string& text) override;

  bool frames = true;  ///< K_i of the hierarchy
};

class TwoLinkDrawing final : public PlanarDrawing {
 public:
  TwoLinkDrawing();
  void draw(const LectureCanvas& canvas) override;
  std::string save() const override;
  void load(const Session&, const std::string& text) override;

  /// Where the end is held, or was last.
  Eigen::Vector2d target(const Session& session);
  TwoLinkSolution solve(const Session& session);

  Eigen::Vector2d lastTarget;
  bool candidates = true;  ///< of the arctangent, which miss
};

class OneDimensionDrawing final : public PlanarDrawing {
 public:
  OneDimensionDrawing();
  void draw(const LectureCanvas& canvas) override;
  std::string save() const override;
  void load(const Session&, const std::string& text) override;
  void restart();  ///< after a change of the first three

  double start, target = oneLinkTarget, delta = 1e-6;
  std::vector<NewtonStep1d> run;
  std::size_t at = 0;  ///< the iterate shown
};

enum class NewtonExample { Square, PseudoInverse, Shortest };

class NewtonDrawing final : public PlanarDrawing {
 public:
  explicit NewtonDrawing(NewtonExample example);
  void draw(const LectureCanvas& canvas) override;
  std::string save() const override;
  void load(const Session&, const std::string& text) override;

  void setSlide();  ///< start and target as on the slide
  void restart();   ///< after a change of start or target
  const NearestSolution& best();

  const NewtonExample example;
  Eigen::VectorXd start;
  Eigen::Vector2d target;
  NewtonRun run;
  std::size_t at = 0;  ///< the step shown

 private:
  void truePath(Overlay& overlay, std::size_t i, const Colour& colour, float width) const;
  std::optional<NearestSolution> best_;
};

// --- 10.1.1 and 10.2: in space

class RotationsDrawing final : public LectureDrawing {
 public:
  void draw(const LectureCanvas& canvas) override;
  std::string save() const override;
  void load(const Session&, const std::string& text) override;

  const EulerOrder& eulerOrder() const { return eulerOrders()[order]; }
  Eigen::Vector3d anglesOf(const Session& session, int joint);

  int joint = 0;
  std::size_t order = 0;
  /// Angles as they were set last: at a gimbal lock the rotation alone does not tell them.
  std::array<Eigen::Vector3d, 3> typed{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                       Eigen::Vector3d::Zero()};
};

class DhDrawing final : public LectureDrawing {
 public:
  void draw(const LectureCanvas& canvas) override;
  std::string save() const override;
  /// The table stands in the model's name.
  void load(const Session& session, const std::string& text) override;

  DhTable table;
  bool frames = true;
};

class LegDrawing final : public LectureDrawing {
 public:
  void draw(const LectureCanvas& canvas) override;
  std::string save() const override;
  void load(const Session& session, const std::string& text) override;
  void animate(const Skeleton& figure);  ///< once

  const LegAnimation& shown() const { return pins ? pinned : keyed; }
  const std::vector<std::array<FootMeasure, 2>>& feet() const { return pins ? pinnedFeet : keyedFeet; }
  int frame() const;

  LegAnimation keyed, pinned;
  std::vector<std::array<FootMeasure, 2>> keyedFeet, pinnedFeet;
  double time = 0.0;
  bool pins = true, ghost = true;

 private:
  const Eigen::Vector3d& trail(const Skeleton& figure, int side, std::size_t frame);
  std::array<std::array<std::vector<Eigen::Vector3d>, 2>, 2> trails_;
};

}  // namespace gelenk
