#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solvers/serial/serial_chain.h"
#include "solvers/solutions/closed_loop.h"

namespace gelenk {

/// One solution of a pose.
struct ArmSolution {
  Vector6d q;  ///< radians (metres where a joint slides); of the images q + 2 pi k the one within limits and
               ///< nearest to the reference, where there is none within limits the nearest
  bool withinLimits = false;
  double error = 0.0;        ///< of the closed loop: metres over the arm's length, and radians
  unsigned char free = 0;    ///< bit i: joint i could take any value (a family of solutions); it took the
                             ///< reference's
  signed char shoulder = 0;  ///< +1, -1: side of the plane through axis 1 along axis 2 on which the wrist is
  signed char elbow = 0;     ///< +1, -1: sense of the bend at joint 3 about axis 2
  signed char wrist = 0;  ///< +1, -1: sign of sin of the bend at joint 5; all 0 where the class has no names
};

/// "shoulder +, elbow -, wrist +"; empty where the class has no names.
std::string branchName(const ArmSolution& solution);

/// All of them: at most sixteen.
struct ArmSolutions {
  static constexpr int most = LoopSolutions::most;
  int count = 0;
  std::array<ArmSolution, most> list;
  bool complete = true;  ///< false: an elimination was too noisy, a root led nowhere in every cut tried, or
                         ///< no two ways agreed
  double noise = 0.0;    ///< of the elimination (general class), of the resultant's largest value
  double raw = 0.0;      ///< largest error before polishing

  std::span<const ArmSolution> all() const { return {list.data(), static_cast<size_t>(count)}; }
};

/// Why some arms with joints that slide have no complete set here.
inline constexpr char slidingNeedsAWrist[] =
    "with a joint that slides, complete sets need three neighbouring turning joints whose axes meet in a "
    "point";

/// Every pose solution of six joints. The class is read off the axes:
/// three neighbours that meet in a point, three that are parallel, or none of these (general; two that meet
/// or are parallel need no method of their own: they only make one place to cut the loop better than
/// another). Joints that slide are solved where three that turn meet in a point; their q is in metres. Axes
/// that miss a class by up to 1e-5 of the arm's length (radians) are solved as if they did not and polished
/// on the true arm. Const methods may be called from several threads; they do not allocate.
class SixJointArm {
 public:
  /// Throws std::invalid_argument for a chain of other than six joints, and where one slides that does not
  /// fit.
  explicit SixJointArm(const SerialChain& chain);

  LoopClass kind() const { return decomposition_.kind; }
  const Decomposition& decomposition() const { return decomposition_; }
  std::string describe() const;  ///< "spherical wrist: axes 4, 5 and 6 meet in a point"
  const SerialChain& chain() const { return chain_; }

  /// reference: what joints that are free take, and to which images are near (6).
  void solve(const Eigen::Isometry3d& worldFromTip, const Vector6d& reference, ArmSolutions& out) const;

 private:
  /// A side of an arm: the sign of size cos(angle - phase).
  struct Side {
    double size = 0.0, phase = 0.0;
    Side() = default;
    Side(double cosine, double sine);
  };
  void place(const Eigen::Isometry3d& worldFromTip, const Cut& cut, Loop& loop) const;
  void solveGeneral(const Eigen::Isometry3d& worldFromTip, ArmSolutions& out,
                    const Vector6d& reference) const;
  bool balanced(const Eigen::Isometry3d& worldFromTip, const ArmSolutions& found) const;
  void insert(const Vector6d& u, double error, unsigned free, const Vector6d& reference,
              ArmSolutions& out) const;
  Eigen::Isometry3d baseFromLast(const Eigen::Isometry3d& worldFromTip) const;
  void toImages(const TripleSolutions& found, const Eigen::Isometry3d& last, const Vector6d& reference,
                ArmSolutions& out) const;
  bool isThere(const ArmSolutions& out, const Vector6d& q, double tolerance = 1e-7) const;
  bool hasFiniteSets() const;
  void rankCuts();
  void rankPairs();

  SerialChain chain_;
  Loop fixed_;          ///< link 5 is the identity: the goal goes there; lengths over scale_
  double reach_ = 0.0;  ///< from axis 1 to axis 6 at most, lengths over scale_
  double scale_ = 1.0;  ///< metres
  Eigen::Isometry3d baseFromWorld_, tipFromLast_;
  Decomposition decomposition_;
  std::optional<TripleLoop> triple_;  ///< fixed_ cut for the decomposition
  bool named_ = false;
  Side elbow_, wrist_;
  std::vector<Cut> ranked_;  ///< cuts for the general elimination, the best first
  std::vector<Loop> rankedLoop_;
  std::vector<Cut> rankedPairs_;  ///< cuts for the search beside two axes that meet
};

/// How many angles q + 2 pi k lie within the limits; 1 where these are not finite.
int imageCount(double q, double lower, double upper);

}  // namespace gelenk
