#include "solvers/peers/kdl_peer.h"

#ifdef GELENK_HAS_KDL

#include <cmath>
#include <ctime>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/chainiksolvervel_wdls.hpp>
#include <random>

#include "kinematics/configuration.h"
#include "solvers/problem/judge.h"
#include "solvers/serial/serial_chain.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;

KDL::Frame toKdl(const Eigen::Isometry3d& frame) {
  const auto& R = frame.linear();
  const auto& p = frame.translation();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          KDL::Vector(p.x(), p.y(), p.z())};
}

/// The fixed part of link i, before its joint moves.
KDL::Frame linkOffset(const SerialChain& chain, int i) {
  const ChainConstants& C = chain.constants;
  return KDL::Frame::DH_Craig1989(C.a[i], std::atan2(C.sinAlpha[i], C.cosAlpha[i]), C.d[i], C.theta[i]);
}

/// KDL's chain in the base frame of ours: a segment is a joint, then the fixed part up to the next.
KDL::Chain toKdl(const SerialChain& chain) {
  KDL::Chain out;
  for (int i = 0; i < chain.n; ++i)
    out.addSegment(
        KDL::Segment(KDL::Joint(chain.constants.revolute[i] != 0.0 ? KDL::Joint::RotZ : KDL::Joint::TransZ),
                     i + 1 < chain.n ? linkOffset(chain, i + 1) : toKdl(chain.lastFromTip)));
  return out;
}

KDL::JntArray toKdl(const VectorXd& q) {
  KDL::JntArray out(q.size());
  out.data = q;
  return out;
}

/// Of this thread: a busy machine shall not shorten a peer's budget.
double processorSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

enum class Method { Newton, NewtonWithLimits, LevenbergMarquardt };

/// KDL's solver objects hold state; each chain has its own.
class KdlChainSolver {
 public:
  KdlChainSolver(Method method, const SerialChain& chain, int iterations)
      : serial(chain),
        method_(method),
        chain_(toKdl(chain)),
        forward_(chain_),
        pseudoInverse_(chain_),
        damped_(chain_),
        newton_(chain_, forward_, pseudoInverse_, iterations, 5e-7),
        limited_(chain_, toKdl(finite(chain.lower)), toKdl(finite(chain.upper)), forward_, damped_,
                 iterations, 5e-7),
        marquardt_(chain_, Eigen::Matrix<double, 6, 1>::Ones(), 9e-7, iterations) {
    damped_.setLambda(0.01);
  }

  /// q: start and answer.
  void solve(const KDL::Frame& baseFromTip, KDL::JntArray& q) {
    const KDL::JntArray start = q;
    switch (method_) {
      case Method::Newton: newton_.CartToJnt(start, baseFromTip, q); break;
      case Method::NewtonWithLimits: limited_.CartToJnt(start, baseFromTip, q); break;
      case Method::LevenbergMarquardt: marquardt_.CartToJnt(start, baseFromTip, q); break;
    }
  }

  const SerialChain serial;

 private:
  static VectorXd finite(const VectorXd& limit) { return limit.cwiseMax(-1e9).cwiseMin(1e9); }
  Method method_;
  KDL::Chain chain_;
  KDL::ChainFkSolverPos_recursive forward_;
  KDL::ChainIkSolverVel_pinv pseudoInverse_;
  KDL::ChainIkSolverVel_wdls damped_;
  KDL::ChainIkSolverPos_NR newton_;
  KDL::ChainIkSolverPos_NR_JL limited_;
  KDL::ChainIkSolverPos_LMA marquardt_;
};

/// An angle outside the limits moves by whole turns into them where it can.
void wrapIntoLimits(const SerialChain& chain, KDL::JntArray& q) {
  for (int i = 0; i < chain.n; ++i) {
    if (chain.constants.revolute[i] == 0.0) continue;
    const double turn = 2.0 * M_PI;
    if (q(i) < chain.lower[i]) q(i) += turn * std::ceil((chain.lower[i] - q(i)) / turn);
    if (q(i) > chain.upper[i]) q(i) -= turn * std::ceil((q(i) - chain.upper[i]) / turn);
  }
}

class KdlPeer final : public IkSolver {
 public:
  explicit KdlPeer(Method method) : method_(method) {}

  void prepare(const Skeleton& skeleton) override {
    const int tip = skeleton.jointCount() - 1;
    SerialChainResult result = extractSerialChain(skeleton, tip);
    prepared_ = result.whyNot.empty() && whyNot(result.chain).empty()
                    ? std::make_unique<KdlChainSolver>(method_, result.chain, defaultIterations)
                    : nullptr;
    skeleton_ = &skeleton;
  }

  std::string whyUnsupported(const IkProblem& problem) const override {
    if (problem.goals.size() != 1 || problem.goals[0].kind != GoalKind::Pose)
      return "solves exactly one pose goal";
    const SerialChainResult result = extractSerialChain(*problem.skeleton, problem.goals[0].joint);
    return result.whyNot.empty() ? whyNot(result.chain) : result.whyNot;
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel) const override {
    const double begin = processorSeconds();
    const auto seconds = [&] { return processorSeconds() - begin; };
    IkReport report;
    report.q = problem.start;
    report.why = Stop::Unsupported;
    if (problem.goals.size() != 1 || problem.goals[0].kind != GoalKind::Pose) return report;
    const Goal& goal = problem.goals[0];
    std::unique_ptr<KdlChainSolver> fresh;
    KdlChainSolver* solver = prepared_.get();
    if (!solver || problem.skeleton != skeleton_ || goal.joint != skeleton_->jointCount() - 1 ||
        budget.maxIterations != defaultIterations) {
      const SerialChainResult result = extractSerialChain(*problem.skeleton, goal.joint);
      if (!result.whyNot.empty() || !whyNot(result.chain).empty()) return report;
      fresh = std::make_unique<KdlChainSolver>(method_, result.chain, budget.maxIterations);
      solver = fresh.get();
    }
    report.why = Stop::Failure;
    if (!problem.start.allFinite() || !goal.target.allFinite() || !goal.orientation.coeffs().allFinite())
      return report;

    const SerialChain& chain = solver->serial;
    Eigen::Isometry3d worldFromTip = Eigen::Translation3d(goal.target) * goal.orientation.normalized();
    worldFromTip = worldFromTip * Eigen::Translation3d(-goal.pointInJoint);
    const KDL::Frame wanted = toKdl(chain.worldFromBase.inverse() * worldFromTip);
    std::mt19937_64 random(budget.seed);
    KDL::JntArray q(chain.n);
    report.q = projectToLimits(*problem.skeleton, problem.start);
    const VectorXd start = report.q;
    double best = errorOf(problem, start);
    report.why = Stop::Stalled;
    for (int attempt = 0; attempt <= budget.restarts; ++attempt) {
      if (attempt > 0 && seconds() > budget.maxSeconds) {
        report.why = Stop::Budget;
        break;
      }
      for (int i = 0; i < chain.n; ++i) {
        const ChainConstants& C = chain.constants;
        q(i) = attempt == 0 ? start[chain.qIndex[i]]
                            : C.seedLower[i] + (C.seedUpper[i] - C.seedLower[i]) * uniform01(random);
      }
      solver->solve(wanted, q);
      if (!q.data.allFinite()) continue;
      wrapIntoLimits(chain, q);
      VectorXd candidate = start;
      for (int i = 0; i < chain.n; ++i) candidate[chain.qIndex[i]] = q(i);
      candidate = projectToLimits(*problem.skeleton, candidate);
      const double error = errorOf(problem, candidate);
      if (error < best) {
        best = error;
        report.q = candidate;
      }
      report.counters.restarts = attempt;
      if (judge(problem, candidate).solved) {
        report.q = candidate;
        best = error;
        report.why = Stop::Converged;
        break;
      }
    }
    report.residual = std::sqrt(goal.weight) * best;
    report.seconds = seconds();
    return report;
  }

 private:
  static constexpr int defaultIterations = 200;

  static double errorOf(const IkProblem& problem, const VectorXd& q) {
    const Judgement verdict = judge(problem, q);
    return verdict.finite ? std::hypot(verdict.goals[0].position, verdict.goals[0].orientation) : INFINITY;
  }

  /// KDL 1.5.1's damped velocities end the program (an assertion of the library) where the Jacobian has fewer
  /// columns than rows.
  std::string whyNot(const SerialChain& chain) const {
    if (method_ != Method::NewtonWithLimits || chain.n >= 6) return {};
    return "KDL's damped velocity solver needs six or more degrees of freedom, this chain has " +
           std::to_string(chain.n);
  }

  Method method_;
  std::unique_ptr<KdlChainSolver> prepared_;
  const Skeleton* skeleton_ = nullptr;
};

}  // namespace

std::unique_ptr<IkSolver> makeKdlNewton() { return std::make_unique<KdlPeer>(Method::Newton); }
std::unique_ptr<IkSolver> makeKdlNewtonWithLimits() {
  return std::make_unique<KdlPeer>(Method::NewtonWithLimits);
}
std::unique_ptr<IkSolver> makeKdlLevenbergMarquardt() {
  return std::make_unique<KdlPeer>(Method::LevenbergMarquardt);
}

}  // namespace gelenk

#endif
