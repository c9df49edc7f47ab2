#include "solvers/serial/spherical_wrist.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double same =
    1e-9;  // of the arm's length, and of sines: makers' figures are exact or off by far more
constexpr double reachRounding = 1e-9;  // a cosine may exceed 1 by this and still mean a stretched arm

Matrix3d aboutX(double cosine, double sine) {
  Matrix3d R;
  R << 1, 0, 0, 0, cosine, -sine, 0, sine, cosine;
  return R;
}
Matrix3d aboutZ(double angle) { return Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix(); }
Matrix3d tilt(const ChainConstants& C, int i) { return aboutX(C.cosAlpha[i], C.sinAlpha[i]); }

/// L_i with the joint turned by `turned` = theta_i + q_i.
Isometry3d link(const ChainConstants& C, int i, double turned) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = tilt(C, i);
  T.translation() = Vector3d(C.a[i], 0, 0) + T.linear().col(2) * C.d[i];
  T.linear() = T.linear() * aboutZ(turned);
  return T;
}

/// acos of a value that should lie in [-1, 1]; exact turns false where it does not.
double arcCosine(double value, bool& exact) {
  if (std::abs(value) > 1.0 + reachRounding) exact = false;
  return std::acos(std::clamp(value, -1.0, 1.0));
}
double arcSine(double value, bool& exact) {
  if (std::abs(value) > 1.0 + reachRounding) exact = false;
  return std::asin(std::clamp(value, -1.0, 1.0));
}

/// The point turned about axis 2 (parallel to 3) has a constant height along it: that alone gives q_1, in two
/// ways.
///     u . (Rz(-q_1) p) = height + u . (a_2, 0, 0),   u = (0, -sin alpha_2, cos alpha_2)
struct Shoulder {
  double q1;
  bool exact;
};
std::vector<Shoulder> shoulders(const ChainConstants& C, const Vector3d& p, double height, double reference) {
  const double radius = std::hypot(p.x(), p.y()), azimuth = std::atan2(p.y(), p.x());
  if (radius < 1e-12) return {{reference, std::abs(C.cosAlpha[1] * p.z() - height) < same}};
  bool exact = true;
  const double angle = arcSine((C.cosAlpha[1] * p.z() - height) / (C.sinAlpha[1] * radius), exact);
  return {{azimuth - angle, exact}, {azimuth - (M_PI - angle), exact}};
}

/// Two links in a plane: the first of length a along x, then the vector w, reach the point p.
struct Elbow {
  double first, second;  ///< angles of the first link and of w's frame against it
  bool exact;
};
std::vector<Elbow> elbows(double a, const Vector2d& w, const Vector2d& p) {
  bool exact = true;
  const double cosine = (p.squaredNorm() - a * a - w.squaredNorm()) / (2.0 * a * w.norm());
  const double bend = arcCosine(cosine, exact), own = std::atan2(w.y(), w.x());
  std::vector<Elbow> both;
  for (const double sign : {1.0, -1.0}) {
    const double second = sign * bend - own;  // of the frame in which w is given
    const Vector2d tip = Vector2d(a, 0) + Eigen::Rotation2Dd(second) * w;
    both.push_back({std::atan2(p.y(), p.x()) - std::atan2(tip.y(), tip.x()), second, exact});
  }
  return both;
}

/// Angle by whole turns into [lower, upper], nearest to the reference; clamped and false where there is none.
bool intoLimits(double& angle, double lower, double upper, double reference) {
  const double turn = 2.0 * M_PI;
  angle -= turn * std::nearbyint((angle - reference) / turn);
  if (angle < lower) angle += turn * std::ceil((lower - angle - 1e-9) / turn);
  if (angle > upper) angle -= turn * std::ceil((angle - upper - 1e-9) / turn);
  const bool inside = angle >= lower - 1e-9 && angle <= upper + 1e-9;
  if (inside) angle = std::clamp(angle, lower, upper);
  return inside;
}

void addBranch(const SerialChain& chain, const Vector6d& turned, const Vector6d& reference, bool exact,
               std::vector<ArmBranch>& branches) {
  ArmBranch branch{.q = turned, .exact = exact, .withinLimits = true};
  for (int i = 0; i < 6; ++i) {
    branch.q[i] -= chain.constants.theta[i];
    branch.withinLimits &= intoLimits(branch.q[i], chain.lower[i], chain.upper[i], reference[i]);
  }
  branches.push_back(branch);
}

/// M = Rz(a) Rx(alpha_5) Rz(b) Rx(alpha_6) Rz(c): two solutions (a, b, c).
std::vector<Vector3d> wristAngles(const ChainConstants& C, const Matrix3d& M, double referenceA,
                                  bool& exact) {
  const double c5 = C.cosAlpha[4], s5 = C.sinAlpha[4], c6 = C.cosAlpha[5], s6 = C.sinAlpha[5];
  const double bend = arcCosine((c5 * c6 - M(2, 2)) / (s5 * s6), exact);
  std::vector<Vector3d> both;
  for (const double b : {bend, -bend}) {
    const Matrix3d N = tilt(C, 4) * aboutZ(b) * tilt(C, 5);
    const bool inLine = std::hypot(N(0, 2), N(1, 2)) < 1e-9;
    const double a = inLine ? referenceA : std::atan2(M(1, 2), M(0, 2)) - std::atan2(N(1, 2), N(0, 2));
    const Matrix3d last = N.transpose() * aboutZ(-a) * M;
    both.push_back({a, b, std::atan2(last(1, 0), last(0, 0))});
  }
  return both;
}

std::vector<ArmBranch> sphericalWristBranches(const SerialChain& chain, const Isometry3d& target,
                                              const Vector6d& reference) {
  const ChainConstants& C = chain.constants;
  const Isometry3d fourth = link(C, 3, 0.0);
  const Vector3d wristInThird =
      fourth * (link(C, 4, 0.0) * link(C, 5, 0.0)).translation();  // on axis 4: no q_4 in it
  const double mirror = C.cosAlpha[2] > 0.0 ? 1.0 : -1.0;          // axis 3 along or against axis 2
  const Vector2d forearm(wristInThird.x(), mirror * wristInThird.y());
  const double height = C.d[1] + mirror * (C.d[2] + wristInThird.z());
  const Vector3d wrist = target.translation();
  std::vector<ArmBranch> branches;
  for (const Shoulder& shoulder : shoulders(C, wrist, height, reference[0])) {
    const Vector3d arm = tilt(C, 1).transpose() * (aboutZ(-shoulder.q1) * wrist - Vector3d(C.a[1], 0, 0));
    for (const Elbow& elbow : elbows(C.a[2], forearm, arm.head<2>())) {
      const double t2 = elbow.first, t3 = mirror * elbow.second;
      const Matrix3d third = aboutZ(shoulder.q1) * tilt(C, 1) * aboutZ(t2) * tilt(C, 2) * aboutZ(t3);
      bool wristExact = true;
      const Matrix3d M = tilt(C, 3).transpose() * third.transpose() * target.linear();
      for (const Vector3d& w : wristAngles(C, M, reference[3] + C.theta[3], wristExact)) {
        Vector6d turned;
        turned << shoulder.q1, t2, t3, w;
        addBranch(chain, turned, reference, shoulder.exact && elbow.exact && wristExact, branches);
      }
    }
  }
  return branches;
}

std::vector<ArmBranch> parallelBranches(const SerialChain& chain, const Isometry3d& target,
                                        const Vector6d& reference) {
  const ChainConstants& C = chain.constants;
  const double third = C.cosAlpha[2] > 0.0 ? 1.0 : -1.0,
               fourth = third * (C.cosAlpha[3] > 0.0 ? 1.0 : -1.0);                    // against axis 2
  const Vector3d meetingInFourth = (link(C, 4, 0.0) * link(C, 5, 0.0)).translation();  // of axes 5 and 6
  const double height = C.d[1] + third * C.d[2] + fourth * (C.d[3] + meetingInFourth.z());
  std::vector<ArmBranch> branches;
  for (const Shoulder& shoulder : shoulders(C, target.translation(), height, reference[0])) {
    // Seen in frame 1 tilted to axis 2, whose z is the common direction of the three.
    const Matrix3d view = tilt(C, 1).transpose() * aboutZ(-shoulder.q1);
    const Matrix3d wanted = view * target.linear();
    // Axis 4 is fourth * z there: z_4 . z_6 = c5 c6 - s5 s6 cos(b).
    bool exact = shoulder.exact;
    const double bend = arcCosine(
        (C.cosAlpha[4] * C.cosAlpha[5] - fourth * wanted(2, 2)) / (C.sinAlpha[4] * C.sinAlpha[5]), exact);
    for (const double b : {bend, -bend}) {
      const Matrix3d N = tilt(C, 4) * aboutZ(b) * tilt(C, 5);
      const Vector3d seen = fourth * wanted.row(2).transpose(),
                     own = N.row(2).transpose();  // axis 4 in frame 6, before and after q_6
      const bool inLine = std::hypot(own.x(), own.y()) < 1e-9;
      const double c =
          inLine ? reference[5] + C.theta[5] : std::atan2(own.y(), own.x()) - std::atan2(seen.y(), seen.x());
      Isometry3d goal = Isometry3d::Identity();
      goal.linear() = wanted;
      goal.translation() = view * target.translation() - tilt(C, 1).transpose() * Vector3d(C.a[1], 0, 0);
      const Isometry3d axisFour = goal * (link(C, 4, b) * link(C, 5, c)).inverse();  // frame 4, seen likewise
      const Vector2d elbowToFour(C.a[3], 0.0);
      for (const Elbow& elbow : elbows(C.a[2], elbowToFour, axisFour.translation().head<2>())) {
        const double t2 = elbow.first, t3 = third * elbow.second;
        const Matrix3d before = aboutZ(t2) * tilt(C, 2) * aboutZ(t3) * tilt(C, 3);
        const Matrix3d last = before.transpose() * axisFour.linear();
        Vector6d turned;
        turned << shoulder.q1, t2, t3, std::atan2(last(1, 0), last(0, 0)), b, c;
        addBranch(chain, turned, reference, exact && elbow.exact, branches);
      }
    }
  }
  return branches;
}

Isometry3d baseFromLast(const SerialChain& chain, const Isometry3d& worldFromTip) {
  return chain.worldFromBase.inverse() * worldFromTip * chain.lastFromTip.inverse();
}

class ClosedForm final : public IkSolver {
 public:
  std::string whyUnsupported(const IkProblem& problem) const override {
    if (problem.goals.size() != 1 || problem.goals[0].kind != GoalKind::Pose)
      return "solves exactly one pose goal";
    const SerialChainResult result = extractSerialChain(*problem.skeleton, problem.goals[0].joint);
    if (!result.whyNot.empty()) return result.whyNot;
    std::string whyNot;
    armFamily(result.chain, &whyNot);
    return whyNot;
  }

  void prepare(const Skeleton&) override {}

  IkReport solve(const IkProblem& problem, const Budget&, TraceLevel) const override {
    const auto begin = std::chrono::steady_clock::now();
    IkReport report;
    report.q = problem.start;
    report.why = Stop::Unsupported;
    if (!whyUnsupported(problem).empty()) return report;
    const Goal& goal = problem.goals[0];
    report.why = Stop::Failure;
    if (!problem.start.allFinite() || !goal.target.allFinite() || !goal.orientation.coeffs().allFinite())
      return report;
    const SerialChain chain = extractSerialChain(*problem.skeleton, goal.joint).chain;
    report.q = projectToLimits(*problem.skeleton, problem.start);
    Vector6d start;
    for (int i = 0; i < 6; ++i) start[i] = report.q[chain.qIndex[i]];
    const Isometry3d target = Isometry3d(Eigen::Translation3d(goal.target) * goal.orientation.normalized()) *
                              Eigen::Translation3d(-goal.pointInJoint);
    VectorXd best = report.q;
    double bestError = INFINITY, bestDistance = INFINITY;
    bool solved = false;
    for (const ArmBranch& branch : armBranches(chain, target, start)) {
      VectorXd q = report.q;
      for (int i = 0; i < 6; ++i) q[chain.qIndex[i]] = branch.q[i];
      q = projectToLimits(*problem.skeleton, q);
      const Judgement verdict = judge(problem, q);
      if (!verdict.finite || (solved && !verdict.solved)) continue;
      const double error = std::hypot(verdict.goals[0].position, verdict.goals[0].orientation),
                   distance = (branch.q - start).norm();
      if ((verdict.solved && !solved) || (verdict.solved ? distance < bestDistance : error < bestError)) {
        best = q;
        bestError = error;
        bestDistance = distance;
        solved = verdict.solved;
      }
      ++report.counters.forwardKinematics;
    }
    report.why = solved ? Stop::Converged : Stop::Stalled;
    if (std::isfinite(bestError)) report.q = best;
    const Judgement atBest = judge(problem, report.q);
    report.residual =
        std::sqrt(goal.weight) * std::hypot(atBest.goals[0].position, atBest.goals[0].orientation);
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
  }
};

}  // namespace

ArmFamily armFamily(const SerialChain& chain, std::string* whyNot) {
  const auto no = [&](const char* reason) {
    if (whyNot) *whyNot = reason;
    return ArmFamily::None;
  };
  if (whyNot) whyNot->clear();
  if (chain.n != 6 || chain.hasPrismatic) return no("closed forms are for six revolute joints");
  const ChainConstants& C = chain.constants;
  const auto parallel = [&](int i) { return std::abs(C.sinAlpha[i]) < same; };
  const auto meets = [&](int i) { return !parallel(i) && std::abs(C.a[i]) < same * chain.length; };
  if (parallel(1) || !parallel(2)) return no("axes 2 and 3 must be parallel, and not parallel to axis 1");
  if (C.a[2] < same * chain.length && -C.a[2] < same * chain.length) return no("axes 2 and 3 coincide");
  if (!meets(4) || !meets(5)) return no("axis 5 must meet axes 4 and 6");
  if (std::abs(C.d[4]) < same * chain.length && !parallel(3)) return ArmFamily::SphericalWrist;
  if (parallel(3) && std::abs(C.a[3]) >= same * chain.length) return ArmFamily::ThreeParallelAxes;
  return no("neither do axes 4, 5 and 6 meet in a point nor are axes 2, 3 and 4 parallel");
}

std::vector<ArmBranch> armBranches(const SerialChain& chain, const Isometry3d& worldFromTip,
                                   const Vector6d& reference) {
  const Isometry3d target = baseFromLast(chain, worldFromTip);
  switch (armFamily(chain)) {
    case ArmFamily::SphericalWrist: return sphericalWristBranches(chain, target, reference);
    case ArmFamily::ThreeParallelAxes: return parallelBranches(chain, target, reference);
    case ArmFamily::None: break;
  }
  return {};
}

std::unique_ptr<IkSolver> makeSphericalWrist() { return std::make_unique<ClosedForm>(); }

}  // namespace gelenk
