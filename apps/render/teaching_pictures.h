#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/document/session.h"
#include "apps/render/overlay.h"
#include "apps/render/signs.h"

namespace gelenk {

struct Ghost;

/// Solves from one pose to a grid of targets in a plane.
struct ConvergenceMap {
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();                            ///< world
  Eigen::Vector3d u = Eigen::Vector3d::UnitX(), v = Eigen::Vector3d::UnitY();  ///< edges of the whole, world
  int cells = 0;                                                               ///< a side
  struct Cell {
    bool solved = false;       ///< looked at
    bool reached = false;      ///< by the judge
    bool otherBranch = false;  ///< the last bend of the path is of the other sign than at the start
    int iterations = 0;
  };
  std::vector<Cell> rows;                              ///< cells * cells, v outer
  int fewestIterations = 1 << 30, mostIterations = 1;  ///< among those that reached

  struct Shares {  ///< of the cells looked at; they add up to 1
    double sameBranch = 0.0, otherBranch = 0.0, notReached = 0.0;
  };
  Shares shares() const;
  /// What a cell is drawn in; 0: as few iterations as any that reached, 1: as many, on a logarithmic scale.
  Colour colour(const Cell& cell) const;
  static Colour reachedColour(double many, bool otherBranch);
  static Colour notReachedColour();
};

/// Pictures that explain an arm: ellipsoids of velocity and force, the set that can be reached, other
/// solutions of the same pose, the self-motion of a redundant arm, and where a solver converges. They stand
/// for the document's options (ViewOptions), about the effector of the selected goal, else of the first held
/// one, else of the first. What is costly is kept as long as it stands.
class TeachingPictures {
 public:
  struct Look {
    double size = 1.0;  ///< of the model, metres
    const MarkColours* colours = nullptr;
    std::optional<GoalId> selected = {};
    bool whole = false;  ///< a still picture: the map is finished at once
  };
  void add(const Session& session, const Frames& frames, const Look& look, Overlay& inScene, Overlay& onTop,
           std::vector<Ghost>& ghosts);

  /// Whole configurations of the other solutions that were drawn last, in their order.
  const std::vector<Eigen::VectorXd>& solutions() const { return solutions_; }
  /// Poses along the self-motion that was drawn last, and the one nearest to the present pose.
  const std::vector<Eigen::VectorXd>& selfMotion() const { return selfMotion_; }
  int selfMotionAt() const { return selfMotionAt_; }
  const ConvergenceMap& map() const { return map_; }
  /// Why the last picture that was asked for could not be drawn, a sentence each; empty: nothing amiss.
  const std::vector<std::string>& reasons() const { return reasons_; }
  /// Whether the map is still being computed.
  bool isWorking() const { return working_; }

  /// The point that is meant.
  struct Effector {
    int joint = 0;
    Eigen::Vector3d pointInJoint = Eigen::Vector3d::Zero();
  };
  static std::optional<Effector> effectorOf(const Session& session, std::optional<GoalId> selected);

  /// Why there is no such picture of an effector, in whatever pose; empty: there is one.
  static std::string whyNoSolutions(const Skeleton& skeleton, const Effector& at);
  static std::string whyNoSelfMotion(const Skeleton& skeleton, const Effector& at);
  static std::string whyNoMap(const Skeleton& skeleton, const Effector& at);

  /// Of the reachable set; empty where no point is meant.
  Eigen::AlignedBox3d reachableBox(const Session& session, std::optional<GoalId> selected);

 private:
  void ellipsoids(const Session& session, const Frames& frames, const Effector& at, const Look& look,
                  Overlay& overlay) const;
  void reach(const Session& session, const Effector& at, const Look& look, Overlay& overlay);
  void lookForReach(const Session& session, const Effector& at);
  void otherSolutions(const Session& session, const Frames& frames, const Effector& at,
                      std::vector<Ghost>& ghosts);
  void nullSpace(const Session& session, const Frames& frames, const Effector& at,
                 std::vector<Ghost>& ghosts);
  void convergence(const Session& session, const Frames& frames, const Effector& at, const Look& look,
                   Overlay& overlay);

  std::vector<Eigen::Vector3d> cloud_;
  std::vector<float> cloudValue_;
  std::string cloudKey_;
  std::vector<Eigen::VectorXd> solutions_, selfMotion_;
  int selfMotionAt_ = 0;
  std::string selfMotionKey_;
  ConvergenceMap map_;
  std::string mapKey_;
  int mapNext_ = 0, mapStride_ = 0;
  bool working_ = false;
  std::vector<std::string> reasons_;
};

}  // namespace gelenk
