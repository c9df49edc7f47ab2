// The step of every rule against the expression of its paper. J (m x n) and r are written down here from the
// geometry of hinge arms, the expression is evaluated with other decompositions than the solver's, and the
// constants are literals: a changed constant or formula fails.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "kinematics/forward_kinematics.h"
#include "kinematics/rotation.h"
#include "solvers/problem/ik_solver.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// n unlimited hinges, about z, y, z, y, ..., and a tip; one metre in all. straight: all bones along z.
Skeleton spatialArm(int n, bool straight = false) {
  std::vector<Joint> joints;
  for (int i = 0; i <= n; ++i) {
    Joint joint{.name = "j" + std::to_string(i), .parent = i - 1};
    if (i > 0)
      joint.parentFromZero.translation() =
          (straight ? Vector3d(0.0, 0.0, 1.0) : Vector3d(0.3, 0.1 * (i % 2), 1.0)).normalized() / n;
    if (i < n)
      joint.axes = {
          {AxisDof::Kind::Rotation, i % 2 ? Vector3d::UnitY() : Vector3d::UnitZ(), -unlimited, unlimited}};
    joints.push_back(joint);
  }
  return Skeleton(joints);
}

/// Two hinges about z with unit links along x.
Skeleton planarArm() {
  std::vector<Joint> joints;
  for (int i = 0; i <= 2; ++i) {
    Joint joint{.name = "l" + std::to_string(i), .parent = i - 1};
    if (i > 0) joint.parentFromZero.translation().x() = 1.0;
    if (i < 2) joint.axes = {{AxisDof::Kind::Rotation, Vector3d::UnitZ(), -unlimited, unlimited}};
    joints.push_back(joint);
  }
  return Skeleton(joints);
}

/// Columns (axis x (tip - joint), axis) of the pose of the last joint, 6 x n.
MatrixXd poseJacobian(const Skeleton& arm, const VectorXd& q) {
  const Frames frames = forwardKinematics(arm, q);
  MatrixXd J(6, arm.nv());
  for (int k = 0; k < arm.nv(); ++k) {
    const Vector3d axis = frames[k].linear() * arm.joint(k).axes[0].axis;
    J.col(k) << axis.cross(frames.back().translation() - frames[k].translation()), axis;
  }
  return J;
}

/// A pose problem whose residual at q is r (6: metres, then the rotation vector in world axes).
IkProblem poseProblem(const Skeleton& arm, const VectorXd& q, const VectorXd& r) {
  const Eigen::Isometry3d tip = forwardKinematics(arm, q).back();
  IkProblem problem{.skeleton = &arm, .start = q};
  problem.goals = {{.kind = GoalKind::Pose,
                    .joint = arm.jointCount() - 1,
                    .target = tip.translation() + r.head<3>(),
                    .orientation = expRotation(r.tail<3>()) * Quaterniond(tip.linear())}};
  problem.positionTolerance = problem.orientationTolerance = 1e-13;
  return problem;
}

/// The residual of a pose problem's goal at another q.
VectorXd poseResidual(const IkProblem& problem, const VectorXd& q) {
  const Eigen::Isometry3d tip = forwardKinematics(*problem.skeleton, q).back();
  VectorXd r(6);
  r << problem.goals[0].target - tip.translation(),
      logRotation(problem.goals[0].orientation * Quaterniond(tip.linear()).conjugate());
  return r;
}

/// Where the solver stands after each of its first steps (the start first), and their dampings.
struct Steps {
  std::vector<VectorXd> q;
  std::vector<double> damping;
};
Steps steps(std::string_view solver, const IkProblem& problem, int count) {
  const IkReport report =
      makeSolver(solver)->solve(problem, {.maxIterations = count, .maxSeconds = 1e9}, TraceLevel::Full);
  Steps steps;
  for (const IterationRecord& record : report.trace) {
    steps.q.push_back(record.q);
    steps.damping.push_back(record.damping);
  }
  return steps;
}
VectorXd firstStep(std::string_view solver, const IkProblem& problem) {
  const Steps one = steps(solver, problem, 1);
  EXPECT_EQ(one.q.size(), 2u) << solver;
  return one.q.size() == 2 ? VectorXd(one.q[1] - one.q[0]) : VectorXd::Constant(problem.start.size(), NAN);
}

/// (J^T J + mu I)^-1 J^T r by elimination with full pivoting; the solver works on the smaller of J^T J, J
/// J^T.
VectorXd damped(const MatrixXd& J, double mu, const VectorXd& r) {
  if (mu == 0.0 && J.rows() < J.cols()) return J.transpose() * (J * J.transpose()).fullPivLu().solve(r);
  const MatrixXd A = J.transpose() * J + mu * MatrixXd::Identity(J.cols(), J.cols());
  return A.fullPivLu().solve(J.transpose() * r);
}

void expectNear(const VectorXd& found, const VectorXd& expected, double relative, std::string_view what) {
  EXPECT_LE((found - expected).norm(), relative * expected.norm())
      << what << "\nfound    " << found.transpose() << "\nexpected " << expected.transpose();
}

const Skeleton seven = spatialArm(7), upright = spatialArm(7, true), four = spatialArm(4), two = planarArm();
VectorXd bent(int n) {
  VectorXd q(n);
  for (int i = 0; i < n; ++i) q[i] = 0.4 + 0.7 * std::sin(2.0 * i + 1.0);
  return q;
}
VectorXd six(double a, double b, double c, double d, double e, double f) {
  VectorXd r(6);
  r << a, b, c, d, e, f;
  return r;
}
const VectorXd smallError = six(0.03, -0.02, 0.01, 0.02, 0.03, -0.01);
const VectorXd largeError = six(0.9, -0.7, -0.8, 0.6, 0.5, -0.4);

/// Between the straight arm (measure 0) and a bent one: where measure(J) has the wanted value.
template <typename Measure>
VectorXd poseWhere(const Skeleton& arm, double wanted, Measure measure) {
  double low = 1e-9, high = 1.0;  // of the bend, logarithmic
  for (int i = 0; i < 200; ++i) {
    const double middle = std::sqrt(low * high);
    (measure(poseJacobian(arm, middle * bent(arm.nv()))) < wanted ? low : high) = middle;
  }
  return high * bent(arm.nv());
}
double conditionShare(const MatrixXd& J) {
  const VectorXd sigma = J.jacobiSvd().singularValues();
  return sigma[sigma.size() - 1] / sigma[0];
}

// ---- rules that take every step

TEST(StepRule, PseudoInverseIsTheShortestStepThatMeetsTheLinearisedGoal) {
  const VectorXd q = bent(7);
  const MatrixXd J = poseJacobian(seven, q);
  const VectorXd shortest = J.transpose() * (J * J.transpose()).fullPivLu().solve(smallError);
  expectNear(firstStep("pseudo-inverse", poseProblem(seven, q, smallError)), shortest, 1e-9, "wide");
  const MatrixXd tall = poseJacobian(four, bent(4));
  expectNear(firstStep("pseudo-inverse", poseProblem(four, bent(4), smallError)),
             (tall.transpose() * tall).fullPivLu().solve(tall.transpose() * smallError), 1e-9, "tall");
}

TEST(StepRule, PseudoInverseDropsSingularValuesBelowAHundredthOfTheLargest) {
  for (const double share : {0.0099, 0.0101}) {
    const VectorXd q = poseWhere(seven, share, conditionShare);
    const MatrixXd J = poseJacobian(seven, q);
    const Eigen::JacobiSVD<MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
    VectorXd expected = VectorXd::Zero(7);
    const VectorXd r = 1e-2 * smallError;
    for (int i = 0; i < (share < 0.01 ? 5 : 6); ++i)
      expected += svd.matrixU().col(i).dot(r) / svd.singularValues()[i] * svd.matrixV().col(i);
    expectNear(firstStep("pseudo-inverse", poseProblem(seven, q, r)), expected, 1e-6,
               "share " + std::to_string(share));
  }
}

TEST(StepRule, TransposeIsSteepestDescentToTheMinimumOfTheLinearModel) {
  const MatrixXd J = poseJacobian(seven, bent(7));
  const VectorXd g = J.transpose() * smallError;
  const double a = smallError.dot(J * g) / (J * g).squaredNorm();
  expectNear(firstStep("jacobian-transpose", poseProblem(seven, bent(7), smallError)), a * g, 1e-9, "");
}

TEST(StepRule, DampedLeastSquaresHasLambdaOfFiveHundredths) {
  for (const Skeleton* arm : {&seven, &four}) {
    const VectorXd q = bent(arm->nv());
    expectNear(firstStep("dls", poseProblem(*arm, q, smallError)),
               damped(poseJacobian(*arm, q), 0.05 * 0.05, smallError), 1e-9, "");
    expectNear(firstStep("dls[lambda=0.3]", poseProblem(*arm, q, smallError)),
               damped(poseJacobian(*arm, q), 0.3 * 0.3, smallError), 1e-9, "another lambda");
  }
}

TEST(StepRule, NakamuraDampsByTheManipulabilityBelowItsThreshold) {
  const auto manipulability = [](const MatrixXd& J) {
    return std::sqrt(std::max(0.0, (J * J.transpose()).determinant())) / J.rowwise().norm().prod();
  };
  for (const double w : {0.002, 0.005, 0.009}) {
    const VectorXd q = poseWhere(seven, w, manipulability), r = 0.1 * smallError;
    const MatrixXd J = poseJacobian(seven, q);
    ASSERT_NEAR(manipulability(J), w, 1e-6);
    const double lambda = 0.1 * (1.0 - w / 0.02);
    expectNear(firstStep("nakamura", poseProblem(seven, q, r)), damped(J, lambda * lambda, r), 1e-6,
               "w = " + std::to_string(w));
    const double other = w < 0.006 ? 0.1 * (1.0 - w / 0.006) : 0.0;
    expectNear(firstStep("nakamura[threshold=0.006,largest-step=6]", poseProblem(seven, q, r)),
               damped(J, other * other, r), 1e-6, "another threshold, w = " + std::to_string(w));
  }
}

TEST(StepRule, ChiaveriniDampsOnlySingularValuesBelowFourHundredthsOfTheLargest) {
  for (const double share : {0.01, 0.03, 0.041}) {
    const VectorXd q = poseWhere(seven, share, conditionShare), r = 0.1 * smallError;
    const Eigen::JacobiSVD<MatrixXd> svd(poseJacobian(seven, q), Eigen::ComputeThinU | Eigen::ComputeThinV);
    const VectorXd& sigma = svd.singularValues();
    VectorXd expected = VectorXd::Zero(7);
    for (int i = 0; i < 6; ++i) {
      const double part = sigma[i] / (0.04 * sigma[0]), lambdaMax = 0.04 * sigma[0];
      const double lambda2 = part < 1.0 ? (1.0 - part * part) * lambdaMax * lambdaMax : 0.0;
      expected +=
          svd.matrixU().col(i).dot(r) * sigma[i] / (sigma[i] * sigma[i] + lambda2) * svd.matrixV().col(i);
    }
    expectNear(firstStep("chiaverini", poseProblem(seven, q, r)), expected, 1e-6,
               "share " + std::to_string(share));
  }
  // the two constants are two: a wider region with the old strength
  const VectorXd q = poseWhere(seven, 0.05, conditionShare), r = 0.1 * smallError;
  EXPECT_GT((firstStep("chiaverini[region=0.1]", poseProblem(seven, q, r)) -
             firstStep("chiaverini[region=0.1,largest-lambda=0.1]", poseProblem(seven, q, r)))
                .norm(),
            1e-6);
}

TEST(StepRule, SelectivelyDampedClampsEverySingularVectorByItsOwnMeasure) {
  for (const double length : {0.05, 0.5, 3.0}) {  // parts free, some clamped, the residual clamped to 0.7
    const VectorXd q = poseWhere(seven, 0.08, conditionShare);
    VectorXd r = six(0.8, -0.5, 0.3, 0.2, 0.7, -0.6);
    r.head<3>() *= length / r.head<3>().norm();
    r.tail<3>() *= std::min(length, 2.0) / r.tail<3>().norm();
    const MatrixXd J = poseJacobian(seven, q);
    VectorXd e = r;  // a position and an orientation are two effectors
    for (int part : {0, 3})
      if (e.segment<3>(part).norm() > 0.7) e.segment<3>(part) = 0.7 * e.segment<3>(part).normalized();
    const Eigen::JacobiSVD<MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
    VectorXd sum = VectorXd::Zero(7);
    for (int i = 0; i < 6; ++i) {
      const VectorXd u = svd.matrixU().col(i), v = svd.matrixV().col(i);
      const double N = u.head<3>().norm() + u.tail<3>().norm();
      double M = 0.0;
      for (int k = 0; k < 7; ++k)
        M += std::abs(v[k]) * (J.col(k).head<3>().norm() + J.col(k).tail<3>().norm()) /
             svd.singularValues()[i];
      const double gamma = M_PI / 4 * std::min(1.0, N / M);
      const VectorXd part = u.dot(e) / svd.singularValues()[i] * v;
      const double largest = part.cwiseAbs().maxCoeff();
      sum += largest > gamma ? VectorXd(gamma / largest * part) : part;
    }
    const double largest = sum.cwiseAbs().maxCoeff();
    if (largest > M_PI / 4) sum *= M_PI / 4 / largest;
    expectNear(firstStep("sdls", poseProblem(seven, q, r)), sum, 1e-6, "length " + std::to_string(length));
  }
}

TEST(StepRule, ChanAndSugiharaDampByTheSquaredError) {
  for (const VectorXd& r : {smallError, VectorXd(0.4 * largeError)}) {
    const MatrixXd J = poseJacobian(seven, bent(7));
    const double E = 0.5 * r.squaredNorm();
    expectNear(firstStep("lm-chan[largest-step=6]", poseProblem(seven, bent(7), r)), damped(J, 0.1 * E, r),
               1e-9, "Chan");
    expectNear(firstStep("lm-sugihara[largest-step=6]", poseProblem(seven, bent(7), r)),
               damped(J, E + 1e-3, r), 1e-9, "Sugihara");
  }
}

TEST(StepRule, LongStepsAreShortenedAsAWholeToTheRulesLength) {
  const IkProblem far = poseProblem(seven, poseWhere(seven, 0.05, conditionShare), largeError);
  // Sugihara's damping, at least half the squared error, never lets a step be longer than 0.71
  const std::vector<std::pair<const char*, double>> lengths{{"pseudo-inverse", 0.5},
                                                            {"dls", 0.5},
                                                            {"nakamura", 0.5},
                                                            {"chiaverini", 0.5},
                                                            {"qp", 0.5},
                                                            {"task-priority", 0.5},
                                                            {"lm-chan[lambda=0.001]", 1.0},
                                                            {"lm-gain-ratio[tau=1e-9]", 1.5},
                                                            {"halley[tau=1e-9]", 1.5},
                                                            {"lm-sugihara[largest-step=0.2]", 0.2},
                                                            {"dls[largest-step=0.2]", 0.2}};
  for (const auto& [solver, length] : lengths)
    EXPECT_NEAR(firstStep(solver, far).cwiseAbs().maxCoeff(), length, 1e-12) << solver;
  const VectorXd free = firstStep("dls[largest-step=6]", far), capped = firstStep("dls", far);
  ASSERT_GT(free.cwiseAbs().maxCoeff(), 0.5);
  expectNear(capped, 0.5 / free.cwiseAbs().maxCoeff() * free, 1e-12, "same direction");
  // where steps are short by themselves: the straight arm, its target far to the side
  IkProblem aside = poseProblem(two, VectorXd::Zero(2), six(0.0, -8.0, 0.0, 0.0, 0.0, 0.0));
  aside.goals[0].kind = GoalKind::Position;
  EXPECT_NEAR(firstStep("jacobian-transpose", aside).cwiseAbs().maxCoeff(), 0.5, 1e-12);
  EXPECT_NEAR(firstStep("sdls[largest-error=100]", aside).cwiseAbs().maxCoeff(), M_PI / 4, 1e-12);
  EXPECT_NEAR(firstStep("exact-hessian[slope-shift=0]", aside).cwiseAbs().maxCoeff(), 1.5, 1e-12);
}

// ---- rules with a memory

/// Levenberg-Marquardt as Nielsen 1999 writes it: mu_0 = tau max (J^T J)_ii, tau = 1e-3; mu times
/// max(1/3, 1 - (2 rho - 1)^3) after success, times 2, 4, 8, ... after failure.
Steps nielsen(const IkProblem& problem, int count) {
  Steps out;
  VectorXd q = problem.start;
  double mu = -1.0, nu = 2.0;
  for (int i = 0; i < count; ++i) {
    const MatrixXd J = poseJacobian(*problem.skeleton, q);
    const VectorXd r = poseResidual(problem, q);
    if (mu < 0.0) mu = 1e-3 * (J.transpose() * J).diagonal().maxCoeff();
    VectorXd dq = damped(J, mu, r);
    if (dq.cwiseAbs().maxCoeff() > 1.5) dq *= 1.5 / dq.cwiseAbs().maxCoeff();
    out.q.push_back(q);
    out.damping.push_back(mu);
    const double fall = 0.5 * r.squaredNorm() - 0.5 * poseResidual(problem, q + dq).squaredNorm();
    const double promised = 0.5 * r.squaredNorm() - 0.5 * (r - J * dq).squaredNorm();
    if (fall > 0.0) {
      q += dq;
      mu *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * fall / promised - 1.0, 3));
      nu = 2.0;
    } else {
      mu *= nu;
      nu *= 2.0;
    }
  }
  return out;
}

TEST(StepRule, GainRatioSteersTheDampingAsNielsenWritesIt) {
  int failures = 0, flatGains = 0;
  for (const double scale : {0.3, 1.0, 2.0}) {
    const IkProblem problem = poseProblem(seven, poseWhere(seven, 0.02, conditionShare), scale * largeError);
    const Steps expected = nielsen(problem, 10), found = steps("lm-gain-ratio", problem, 10);
    ASSERT_GE(found.q.size(), 10u);
    for (int i = 0; i < 10; ++i) {
      EXPECT_NEAR(found.damping[i], expected.damping[i], 1e-6 * expected.damping[i])
          << scale << ", step " << i;
      EXPECT_LE((found.q[i] - expected.q[i]).norm(), 1e-6) << scale << ", step " << i;
      if (i == 0) continue;
      const double change = expected.damping[i] / expected.damping[i - 1];
      failures += change >= 2.0;
      flatGains += change > 0.34 && change < 1.99;
    }
  }
  EXPECT_GE(failures, 2);   // both branches were taken
  EXPECT_GE(flatGains, 2);  // and the cubic between them
}

TEST(StepRule, ExactHessianIsNewtonsStepOnTheCostOfTheTwoLinkArm) {
  // p = (c1 + c12, s1 + s12): H = J^T J - e . d2p with d2p/d1d1 = -p, all other second derivatives -(c12,
  // s12)
  const auto run = [](const IkProblem& problem, int count) {
    Steps out;
    VectorXd q = problem.start;
    double mu = 1e-6;
    const auto place = [](const VectorXd& at) {
      return Eigen::Vector2d(std::cos(at[0]) + std::cos(at[0] + at[1]),
                             std::sin(at[0]) + std::sin(at[0] + at[1]));
    };
    const Eigen::Vector2d target = problem.goals[0].target.head<2>();
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d p = place(q), outer(std::cos(q[0] + q[1]), std::sin(q[0] + q[1])), e = target - p;
      Eigen::Matrix2d J, H;
      J << -p.y(), -outer.y(), p.x(), outer.x();
      H = J.transpose() * J;
      H(0, 0) += e.dot(p);
      H(0, 1) += e.dot(outer);
      H(1, 0) += e.dot(outer);
      H(1, 1) += e.dot(outer);
      const Eigen::Vector2d g = J.transpose() * e;
      double shift = std::max(mu, 1e-3 * g.norm());
      while (
          (H + shift * Eigen::Matrix2d::Identity()).eval().selfadjointView<Eigen::Lower>().eigenvalues()[0] <=
          0.0)
        shift *= 4.0;
      VectorXd dq = (H + shift * Eigen::Matrix2d::Identity()).fullPivLu().solve(g);
      if (dq.cwiseAbs().maxCoeff() > 1.5) dq *= 1.5 / dq.cwiseAbs().maxCoeff();
      out.q.push_back(q);
      out.damping.push_back(mu);
      const double fall = 0.5 * e.squaredNorm() - 0.5 * (target - place(q + dq)).squaredNorm();
      const double promised = g.dot(dq) - 0.5 * dq.dot(H * dq);
      const double gain = promised > 0.0 ? fall / promised : 0.0;
      if (fall > 0.0) {
        q += dq;
        mu = std::max(1e-12, gain > 0.75 ? mu / 5.0 : gain < 0.25 ? 2.0 * std::max(mu, shift) : mu);
      } else {
        mu = 4.0 * std::max(mu, shift);
      }
    }
    return out;
  };
  const auto problem = [](double q1, double q2, double x, double y) {
    IkProblem one{.skeleton = &two, .start = Eigen::Vector2d(q1, q2)};
    one.goals = {{.joint = 2, .target = {x, y, 0.0}}};
    one.positionTolerance = 1e-13;
    return one;
  };
  // within reach, out of reach, past the base with a negative eigenvalue, and so close to a straight arm that
  // the first mu is what keeps the matrix definite
  const double bend = 1e-3, tip = 1.0 + std::cos(bend);
  for (const IkProblem& one :
       {problem(0.4, 0.9, 0.6, 1.3), problem(0.4, 0.9, 2.0, 2.0), problem(0.1, 0.2, -1.0, 0.3),
        problem(0.0, bend, tip - 1e-7, std::sin(bend) + 1e-7)}) {
    const Steps expected = run(one, 6), found = steps("exact-hessian", one, 6);
    for (std::size_t i = 0; i < std::min<std::size_t>(found.q.size(), 6); ++i) {
      if (i + 1 < found.q.size()) {  // the last record has no step
        EXPECT_NEAR(found.damping[i], expected.damping[i], 1e-6 * expected.damping[i]) << "step " << i;
      }
      EXPECT_LE((found.q[i] - expected.q[i]).norm(), 1e-7) << "step " << i;
    }
    EXPECT_GE(found.q.size(), 3u);
  }
}

/// The derivative of J along d, by central differences (error about 1e-9).
MatrixXd jacobianAlong(const Skeleton& arm, const VectorXd& q, const VectorXd& d) {
  const double h = 1e-5;
  return (poseJacobian(arm, q + h * d) - poseJacobian(arm, q - h * d)) / (2.0 * h);
}

TEST(StepRule, HalleyAndGeodesicAddTheSecondOrderWithinTheirGuards) {
  const VectorXd q = poseWhere(seven, 0.1, conditionShare);
  const MatrixXd J = poseJacobian(seven, q);
  const double mu = 1e-3 * (J.transpose() * J).diagonal().maxCoeff();
  struct Parts {
    VectorXd first, halley, second;
  };
  const auto parts = [&](double scale) {
    const VectorXd r = scale * largeError, d = damped(J, mu, r);
    const MatrixXd dJ = jacobianAlong(seven, q, d);
    return Parts{d, damped(J + 0.5 * dJ, mu, r), damped(J, mu, dJ * d)};
  };
  // scales at which a measure of the parts has just not, or just, crossed a bound
  const auto around = [&](double bound, auto measure) {
    double low = 1e-3, high = 3.0;
    EXPECT_LT(measure(parts(low)), bound);
    EXPECT_GT(measure(parts(high)), bound);
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (measure(parts(middle)) < bound ? low : high) = middle;
    }
    return std::array{0.99 * low, 1.01 * high};
  };
  const auto step = [&](const std::string& solver, double scale) {
    return firstStep(solver + "[largest-step=6]", poseProblem(seven, q, scale * largeError));
  };
  const auto halleyShare = [](const Parts& p) { return (p.halley - p.first).norm() / p.first.norm(); };
  const auto bendShare = [](const Parts& p) { return p.second.norm() / p.first.norm(); };
  const auto length = [](const Parts& p) { return p.first.norm(); };

  const Parts small = parts(0.02);
  ASSERT_GT(halleyShare(small), 1e-4);  // the correction is there to be seen
  expectNear(step("halley", 0.02), small.halley, 1e-7, "Halley");
  expectNear(step("geodesic", 0.02), small.first - 0.5 * small.second, 1e-7, "geodesic");

  const auto [below, above] = around(0.75, bendShare);
  expectNear(step("geodesic", below), parts(below).first - 0.5 * parts(below).second, 1e-6,
             "within the guard");
  expectNear(step("geodesic", above), parts(above).first, 1e-6, "beyond the guard");

  // Halley has two guards; each is met alone where the other is opened
  const auto [shorter, longer] = around(1.0, length);
  const auto open = [&](double scale) {
    return firstStep("halley[largest-step=6,guard=10]", poseProblem(seven, q, scale * largeError));
  };
  expectNear(open(shorter), parts(shorter).halley, 1e-6, "shorter than 1");
  expectNear(open(longer), parts(longer).first, 1e-6, "longer than 1");
  const auto [near, far] = around(0.5, halleyShare);
  const auto unbounded = [&](double scale) {
    return firstStep("halley[largest-step=6,longest=10]", poseProblem(seven, q, scale * largeError));
  };
  expectNear(unbounded(near), parts(near).halley, 1e-6, "within half");
  expectNear(unbounded(far), parts(far).first, 1e-6, "beyond half");
}

TEST(StepRule, HalleyAndGeodesicStartFromNielsensDamping) {
  for (const char* solver : {"halley", "geodesic"}) {
    const IkProblem problem = poseProblem(seven, poseWhere(seven, 0.02, conditionShare), 2.0 * largeError);
    const MatrixXd J = poseJacobian(seven, problem.start);
    const Steps found = steps(solver, problem, 6);
    EXPECT_NEAR(found.damping[0], 1e-3 * (J.transpose() * J).diagonal().maxCoeff(), 1e-12) << solver;
    EXPECT_LE((found.q[1] - found.q[0]).cwiseAbs().maxCoeff(), 1.5 + 1e-12) << solver;
  }
}

// ---- rules that keep limits or orders themselves

/// The gradient of half the squared pose error.
VectorXd gradientAt(const Skeleton& arm, const IkProblem& problem, const VectorXd& q) {
  return -poseJacobian(arm, q).transpose() * poseResidual(problem, q);
}

/// Nocedal and Wright 2006, equation 6.17, from last pairs to first: the inverse Hessian that is gamma I, and
/// then learns the pairs (s, y) one after another.
MatrixXd inverseHessian(const std::vector<VectorXd>& s, const std::vector<VectorXd>& y, double gamma) {
  const Eigen::Index n = s[0].size();
  MatrixXd H = gamma * MatrixXd::Identity(n, n);
  for (std::size_t k = 0; k < s.size(); ++k) {
    const double rho = 1.0 / y[k].dot(s[k]);
    const MatrixXd V = MatrixXd::Identity(n, n) - rho * y[k] * s[k].transpose();
    H = V.transpose() * H * V + rho * s[k] * s[k].transpose();
  }
  return H;
}

TEST(StepRule, QuasiNewtonBeginsWithTheBestSteepestDescentAndLearnsAsNocedalAndWrightWriteIt) {
  const VectorXd q = bent(7);
  const IkProblem problem = poseProblem(seven, q, 0.3 * smallError);
  for (const char* name : {"bfgs", "l-bfgs"}) {
    const Steps at = steps(name, problem, 5);
    ASSERT_EQ(at.q.size(), 6u) << name;
    const MatrixXd J = poseJacobian(seven, q);
    const VectorXd down = -gradientAt(seven, problem, q), moved = J * down;
    expectNear(at.q[1] - at.q[0], down * (poseResidual(problem, q).dot(moved) / moved.squaredNorm()), 1e-7,
               name);
    std::vector<VectorXd> s, y;
    for (std::size_t k = 1; k + 1 < at.q.size(); ++k) {
      s.push_back(at.q[k] - at.q[k - 1]);
      y.push_back(gradientAt(seven, problem, at.q[k]) - gradientAt(seven, problem, at.q[k - 1]));
      // The full matrix is scaled once, by the first pair (6.20); the limited one anew each time (7.20).
      const std::size_t scale = std::string_view(name) == "bfgs" ? 0 : s.size() - 1;
      const double gamma = s[scale].dot(y[scale]) / y[scale].squaredNorm();
      expectNear(at.q[k + 1] - at.q[k], -inverseHessian(s, y, gamma) * gradientAt(seven, problem, at.q[k]),
                 1e-6, name);
    }
  }
}

TEST(StepRule, LimitedMemoryForgetsTheOldestPairs) {
  const VectorXd q = bent(7);
  const IkProblem problem = poseProblem(seven, q, 0.3 * smallError);
  const Steps at = steps("l-bfgs[memory=2]", problem, 5);
  ASSERT_EQ(at.q.size(), 6u);
  std::vector<VectorXd> s, y;
  for (int k = 3; k < 5; ++k) {
    s.push_back(at.q[k] - at.q[k - 1]);
    y.push_back(gradientAt(seven, problem, at.q[k]) - gradientAt(seven, problem, at.q[k - 1]));
  }
  expectNear(at.q[5] - at.q[4],
             -inverseHessian(s, y, s[1].dot(y[1]) / y[1].squaredNorm()) * gradientAt(seven, problem, at.q[4]),
             1e-6, "two pairs");
}

TEST(StepRule, TheProgramsStepIsItsMinimumWithinTheBounds) {
  // free: the damped step; bounded: the best of all choices of active bounds that is feasible
  const MatrixXd J = poseJacobian(seven, bent(7));
  expectNear(firstStep("qp", poseProblem(seven, bent(7), smallError)),
             damped(J, 1e-3 * smallError.squaredNorm() + 1e-9, smallError), 1e-9, "free");
  const VectorXd q = poseWhere(four, 0.05, conditionShare);
  const MatrixXd K = poseJacobian(four, q);
  const VectorXd r = largeError;
  const double mu = 1e-3 * r.squaredNorm() + 1e-9;
  double best = std::numeric_limits<double>::infinity();
  VectorXd expected;
  for (int choice = 0; choice < 81; ++choice) {  // each coordinate free, at -0.5 or at 0.5
    VectorXd x = VectorXd::Zero(4);
    std::vector<int> open;
    for (int k = 0, rest = choice; k < 4; ++k, rest /= 3) {
      if (rest % 3 == 0)
        open.push_back(k);
      else
        x[k] = rest % 3 == 1 ? -0.5 : 0.5;
    }
    if (!open.empty()) {
      const MatrixXd some = K(Eigen::all, open);
      const VectorXd y = damped(some, mu, r - K * x);
      for (std::size_t k = 0; k < open.size(); ++k) x[open[k]] = y[static_cast<Eigen::Index>(k)];
    }
    if (x.cwiseAbs().maxCoeff() > 0.5 + 1e-12) continue;
    const double value = (K * x - r).squaredNorm() + mu * x.squaredNorm();
    if (value < best) best = value, expected = x;
  }
  ASSERT_NEAR(expected.cwiseAbs().maxCoeff(), 0.5, 1e-12);
  expectNear(firstStep("qp", poseProblem(four, q, r)), expected, 1e-8, "bounded");
}

TEST(StepRule, TheProgramsDampingIsABillionthWhereTheErrorVanishes) {
  const VectorXd q = Eigen::Vector2d(0.0, 3e-5);  // nearly straight: sigma_min is about 2e-5
  VectorXd r = VectorXd::Zero(6);
  r[0] = 1e-6;
  IkProblem problem = poseProblem(two, q, r);
  problem.goals[0].kind = GoalKind::Position;
  const MatrixXd J = poseJacobian(two, q).topRows(3);
  const VectorXd expected = damped(J, 1e-9, r.head(3));
  ASSERT_GT((expected - damped(J, 2e-9, r.head(3))).norm(), 0.1 * expected.norm());  // it decides
  expectNear(firstStep("qp", problem), expected, 1e-3, "");
}

/// dq = sum over levels, each in the null space of those before: Siciliano, Slotine 1991, with damped
/// inverses.
VectorXd priorities(const std::vector<std::pair<MatrixXd, VectorXd>>& levels, double truncation) {
  const Eigen::Index n = levels[0].first.cols();
  VectorXd dq = VectorXd::Zero(n);
  MatrixXd N = MatrixXd::Identity(n, n);
  for (const auto& [J, r] : levels) {
    const MatrixXd restricted = J * N;
    dq += damped(restricted, 1e-2 * r.squaredNorm() + 1e-12, r - J * dq);
    const Eigen::JacobiSVD<MatrixXd> svd(restricted, Eigen::ComputeThinU | Eigen::ComputeThinV);
    for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i)
      if (svd.singularValues()[i] > truncation * svd.singularValues()[0])
        N -= svd.matrixV().col(i) * svd.matrixV().col(i).transpose();
  }
  return dq;
}

IkProblem twoLevels(const Skeleton& arm, const VectorXd& q, const VectorXd& r) {
  IkProblem problem = poseProblem(arm, q, r);
  Goal orientation = problem.goals[0];
  problem.goals[0].kind = GoalKind::Position;
  problem.goals[0].priority = 0;
  orientation.kind = GoalKind::Orientation;
  orientation.priority = 1;
  problem.goals.push_back(orientation);
  return problem;
}

TEST(StepRule, TaskPriorityServesTheSecondGoalInTheNullSpaceOfTheFirst) {
  const MatrixXd J = poseJacobian(seven, bent(7));
  const VectorXd r = smallError;
  const VectorXd expected = priorities({{J.topRows(3), r.head(3)}, {J.bottomRows(3), r.tail(3)}}, 1e-3);
  expectNear(firstStep("task-priority", twoLevels(seven, bent(7), r)), expected, 1e-8, "");
  ASSERT_GT((expected - damped(J, 1e-2 * r.squaredNorm(), r)).norm(), 1e-4);  // not the stacked step
  // what the first goal's damped inverse does, the second does not undo
  expectNear(J.topRows(3) * firstStep("task-priority", twoLevels(seven, bent(7), r)),
             J.topRows(3) * damped(J.topRows(3), 1e-2 * r.head(3).squaredNorm() + 1e-12, r.head(3)), 1e-8,
             "first");
}

TEST(StepRule, TaskPriorityLeavesDirectionsBelowAThousandthToTheNextGoal) {
  const auto share = [](const MatrixXd& J) { return conditionShare(J.topRows(3)); };
  for (const double wanted : {0.00099, 0.00101}) {
    const VectorXd q = poseWhere(upright, wanted, share), r = 1e-3 * smallError;
    const MatrixXd J = poseJacobian(upright, q);
    ASSERT_NEAR(share(J), wanted, 1e-7);
    const auto levels =
        std::vector<std::pair<MatrixXd, VectorXd>>{{J.topRows(3), r.head(3)}, {J.bottomRows(3), r.tail(3)}};
    const VectorXd expected = priorities(levels, 1e-3);
    ASSERT_GT((expected - priorities(levels, wanted < 1e-3 ? 0.5e-3 : 2e-3)).norm(), 1e-4 * expected.norm());
    expectNear(firstStep("task-priority", twoLevels(upright, q, r)), expected, 1e-4,
               "share " + std::to_string(wanted));
  }
}

TEST(StepRule, TaskPrioritysDampingIsAMillionthOfAMetreWhereTheErrorVanishes) {
  const VectorXd q = poseWhere(upright, 3e-6, [](const MatrixXd& J) { return conditionShare(J.topRows(3)); });
  const MatrixXd J = poseJacobian(upright, q);
  const Eigen::JacobiSVD<MatrixXd> svd(J.topRows(3), Eigen::ComputeThinU | Eigen::ComputeThinV);
  VectorXd r = VectorXd::Zero(6);
  r.head(3) = 1e-8 * svd.matrixU().col(2);  // along the weakest direction
  const VectorXd expected = priorities({{J.topRows(3), r.head(3)}, {J.bottomRows(3), r.tail(3)}}, 1e-3);
  const double sigma = svd.singularValues()[2];
  ASSERT_GT(2e-12 / (sigma * sigma), 0.1);  // it decides
  IkProblem problem = twoLevels(upright, q, r);
  problem.goals.pop_back();
  expectNear(firstStep("task-priority", problem), damped(J.topRows(3), 1e-12, r.head(3)), 2e-2, "");
}

}  // namespace
}  // namespace gelenk
