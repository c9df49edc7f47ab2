#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <string>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// Where the target lies in the reachable annulus |l1 - l2| <= r <= l1 + l2 (lecture 10.1.3, reachable
/// workspace; the slide prints the lower end as l1 - l2, which holds for l1 >= l2).
enum class TwoLinkCase {
  TwoElbows,     ///< inside: both elbow branches reach the target
  Straight,      ///< r = l1 + l2: the branches meet, phi_2 = 0
  Folded,        ///< r = |l1 - l2|: the branches meet, phi_2 = pi
  AnyDirection,  ///< target at the base with l1 = l2: phi_2 = pi and every phi_1 reaches it; phi_1 = 0 is
                 ///< given
  TooFar,        ///< outside: the straight arm points at the target
  TooNear,  ///< in the hole: the folded arm points at the target (phi_1 as if it lay along x where it is at
            ///< the base)
};
const char* toString(TwoLinkCase kind);

struct TwoLinkBranch {
  double phi1 = 0.0, phi2 = 0.0;  ///< radians; phi_2 in [-pi, pi], phi_1 not wrapped
  bool exact = false;             ///< false: the nearest point of the workspace
};

struct TwoLinkSolution {
  TwoLinkCase kind = TwoLinkCase::TwoElbows;
  std::array<TwoLinkBranch, 2> branch = {};  ///< [0] phi_2 >= 0, [1] phi_2 <= 0
  int count = 0;                             ///< 2 inside the annulus, else 1
  double gap = 0.0;                          ///< distance from the target to the nearest reachable point

  std::span<const TwoLinkBranch> branches() const& {
    return {branch.data(), static_cast<std::size_t>(count)};
  }
  std::span<const TwoLinkBranch> branches() const&& = delete;  ///< the span would outlive the solution
};

/// All solutions of X = P_1 + l_1 (cos, sin)(phi_1) + l_2 (cos, sin)(phi_1 + phi_2). Lecture 10.1.3, analytic
/// solution:
///     cos phi_2 = (r^2 - l1^2 - l2^2) / (2 l1 l2),   tan phi_1 = (dy (l1 + l2 c2) - dx l2 s2) / (dx (l1 + l2
///     c2) + dy l2 s2)
/// in the half-angle form tan^2(phi_2 / 2) = ((l1 + l2)^2 - r^2) / (r^2 - (l1 - l2)^2), whose factors stay
/// accurate next to the straight and the folded arm, and with atan2 throughout. Inside the annulus the error
/// is below 1e-14 (l1 + l2). "exact" means a gap of at most 4 ulp of l1 + l2. Throws std::invalid_argument on
/// a length that is negative, or on anything not finite.
TwoLinkSolution solveTwoLink(const Eigen::Vector2d& P1, double l1, double l2, const Eigen::Vector2d& X);

/// The candidates of the slide, which takes arccos and arctan as they are: two for phi_2, and for each two
/// for phi_1, pi apart. Only forward kinematics (or atan2) tells which one holds. Lecture 10.1.3, numerical
/// example.
struct ArctangentCandidate {
  double phi1, phi2;  ///< radians
  double distance;    ///< from the end-effector that these angles give to the target: 0 for those that hold
};
std::array<ArctangentCandidate, 4> arctangentCandidates(const Eigen::Vector2d& P1, double l1, double l2,
                                                        const Eigen::Vector2d& X);

/// Where the elbow of a two-link arm in space goes.
struct Bend {
  Eigen::Vector3d elbow, end;  ///< end: the target, or the nearest reachable point
  bool exact = false;
};

/// The same closed form in space: the elbow lies in the plane through base, target and pole direction, on the
/// pole's side. pole: any direction; where it is parallel to base -> target, a perpendicular one is chosen.
/// Lecture 10.1.3 and 10.2.
Bend bendTowards(const Eigen::Vector3d& base, double l1, double l2, const Eigen::Vector3d& target,
                 const Eigen::Vector3d& pole);

/// The pole for the next frame: the side on which the elbow is, carried along with the target by the smallest
/// rotation, then turned towards the wanted pole by at most 2 |target step| / (elbow's distance from the line
/// base - target). A target that crosses the pole direction therefore never flips the elbow. All points in
/// world coordinates.
Eigen::Vector3d carriedPole(const Eigen::Vector3d& base, const Eigen::Vector3d& elbowBefore,
                            const Eigen::Vector3d& endBefore, const Eigen::Vector3d& target,
                            const Eigen::Vector3d& wantedPole);

/// The closed form as a solver: for every position (or pose) goal it turns the joint nearest above the goal
/// that can bend (elbow, knee: a hinge, or a ball) and the next one above that can aim (shoulder, hip: a ball
/// or three axes; in the plane a hinge parallel to the elbow's). Everything else stays. A pole goal on the
/// elbow says on which side it goes; without one the side is carried along. Limits of the elbow are kept
/// inside the solution, those of the shoulder by projection.
std::unique_ptr<IkSolver> makeTwoLink();

}  // namespace gelenk
