#include "solvers/methods/newton.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "kinematics/configuration.h"
#include "solvers/iteration/attempt.h"

namespace gelenk {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<NewtonStep1d> newton1d(const std::function<double(double)>& f, double start, double X,
                                   double delta, double tolerance, int maxSteps) {
  std::vector<NewtonStep1d> steps;
  double phi = start;
  for (int i = 0; i <= maxSteps; ++i) {
    const double value = f(phi);
    steps.push_back({.phi = phi, .g = value - X, .slope = (f(phi + delta) - value) / delta});
    const NewtonStep1d& at = steps.back();
    if (std::abs(at.g) <= tolerance || at.slope == 0.0 || !std::isfinite(at.g)) break;
    phi -= at.g / at.slope;
  }
  return steps;
}

double convergenceOrder(const std::vector<double>& errors, double floor) {
  std::vector<double> large;
  for (const double e : errors)
    if (std::abs(e) > floor) large.push_back(std::abs(e));
  const std::size_t n = large.size();
  if (n < 3 || large[n - 2] == large[n - 3]) return 0.0;
  return std::log(large[n - 1] / large[n - 2]) / std::log(large[n - 2] / large[n - 3]);
}

MatrixXd pseudoInverse(const MatrixXd& D) {
  const VectorXd sigma = D.jacobiSvd().singularValues();
  if (D.rows() > D.cols() || !(sigma.tail<1>()[0] > 1e-14 * sigma[0])) return {};
  if (D.rows() == D.cols()) return D.partialPivLu().inverse();
  return D.transpose() * (D * D.transpose()).llt().solve(MatrixXd::Identity(D.rows(), D.rows()));
}

NewtonRun newton(const VectorFunction& f, const MatrixFunction& D, const VectorXd& start, const VectorXd& X,
                 double tolerance, int maxSteps) {
  NewtonRun run;
  VectorXd phi = start;
  for (int i = 0; i <= maxSteps; ++i) {
    NewtonStep at{.phi = phi,
                  .f = f(phi),
                  .g = {},
                  .D = D(phi),
                  .Dplus = {},
                  .singularValues = {},
                  .step = {},
                  .linearised = {}};
    at.g = at.f - X;
    at.singularValues = at.D.jacobiSvd().singularValues();
    at.Dplus = pseudoInverse(at.D);
    const bool finite = at.g.allFinite(), reached = finite && at.g.norm() <= tolerance;
    if (!finite || reached || at.Dplus.size() == 0 || i == maxSteps) {
      run.why = reached            ? NewtonStop::Converged
                : !finite          ? NewtonStop::NotFinite
                : !at.Dplus.size() ? NewtonStop::Singular
                                   : NewtonStop::Budget;
      run.steps.push_back(std::move(at));
      break;
    }
    at.step = -at.Dplus * at.g;
    at.linearised = at.f + at.D * at.step;
    phi += at.step;
    run.steps.push_back(std::move(at));
  }
  return run;
}

MatrixXd differenceQuotient(const VectorFunction& f, const VectorXd& phi, double delta) {
  const VectorXd value = f(phi);
  MatrixXd D(value.size(), phi.size());
  for (Eigen::Index k = 0; k < phi.size(); ++k) {
    VectorXd moved = phi;
    moved[k] += delta;
    D.col(k) = (f(moved) - value) / delta;
  }
  return D;
}

namespace {

constexpr double analytic = 0.0;  // for a delta: no difference quotient

/// dr = -J dq, analytic or by the difference quotient along every tangent axis.
MatrixXd residualJacobian(CountedEvaluator& at, double delta) {
  if (delta == analytic) return at.jacobian();
  const VectorXd q = at.q(), r = at.residual();
  MatrixXd J(at.rows(), at.skeleton().nv());
  for (int k = 0; k < at.skeleton().nv(); ++k) {
    at.moveTo(integrate(at.skeleton(), q, delta * VectorXd::Unit(at.skeleton().nv(), k)));
    J.col(k) = (r - at.residual()) / delta;
  }
  at.moveTo(q);
  return J;
}

/// dq = J^+ r over the rows that the joints can change; nothing where J has no full row rank there.
std::optional<VectorXd> newtonStep(const MatrixXd& J, const VectorXd& r) {
  std::vector<Eigen::Index> rows;
  const double size = J.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < J.rows(); ++i)
    if (J.row(i).cwiseAbs().maxCoeff() > 1e-14 * size) rows.push_back(i);
  if (rows.empty()) return std::nullopt;
  const MatrixXd Jplus = pseudoInverse(J(rows, Eigen::all));
  if (Jplus.size() == 0) return std::nullopt;
  return VectorXd(Jplus * r(rows));
}

class NewtonSolver final : public IkSolver {
 public:
  explicit NewtonSolver(double delta) : delta_(delta) {}

  std::string whyUnsupported(const IkProblem& problem) const override {
    int rows = 0;
    for (const Goal& goal : problem.goals) rows += residualRows(goal, *problem.skeleton);
    const bool inPlane = isPlanar(*problem.skeleton) && problem.goals.size() == 1 &&
                         problem.goals[0].kind == GoalKind::Position;
    if (inPlane) rows = 2;
    if (rows <= problem.skeleton->nv()) return {};
    return "Newton's method of the lecture needs n >= m: " + std::to_string(problem.skeleton->nv()) +
           " degrees of freedom for " + std::to_string(rows) + " conditions";
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    CountedEvaluator at(problem);
    IkReport report;
    const MovingJoints moving(problem);
    const auto placed = [&](VectorXd q) {
      moving.restore(q);  // quotients are not quite 0 where a joint moves nothing
      return q;
    };
    at.moveTo(placed(projectToLimits(*problem.skeleton, problem.start)));
    report.why = Stop::Budget;
    if (!whyUnsupported(problem).empty()) {
      report.why = Stop::Unsupported;
      at.moveTo(problem.start);
    }
    VectorXd best = at.q();
    double bestResidual = at.residual().norm();
    for (int& i = at.counters().iterations; report.why == Stop::Budget && i < budget.maxIterations; ++i) {
      if (at.withinTolerance()) {
        report.why = Stop::Converged;
        break;
      }
      if (at.seconds() > budget.maxSeconds) break;
      const std::optional<VectorXd> dq = newtonStep(residualJacobian(at, delta_), at.residual());
      ++at.counters().factorisations;
      if (!dq || !dq->allFinite()) {
        report.why = Stop::Failure;  // singular: the inverse on the slide does not exist
        break;
      }
      if (trace != TraceLevel::Off)
        report.trace.push_back({.q = trace == TraceLevel::Full ? at.q() : VectorXd(),
                                .residual = at.residual().norm(),
                                .stepNorm = dq->norm(),
                                .damping = 0.0,
                                .seconds = at.seconds()});
      const VectorXd next =
          placed(projectToLimits(*problem.skeleton, integrate(*problem.skeleton, at.q(), *dq)));
      if (!next.allFinite()) {
        report.why = Stop::Failure;
        break;
      }
      at.moveTo(next);
      if (at.residual().norm() < bestResidual) {
        bestResidual = at.residual().norm();
        best = at.q();
      }
    }
    if (report.why == Stop::Budget && at.withinTolerance()) report.why = Stop::Converged;
    if (report.why == Stop::Converged) {
      best = at.q();
      bestResidual = at.residual().norm();
    }
    report.q = best;
    report.residual = bestResidual;
    report.counters = at.counters();
    report.seconds = at.seconds();
    return report;
  }

 private:
  /// All axes turn about one direction or slide across it: positions have two conditions, not three.
  static bool isPlanar(const Skeleton& skeleton) {
    const Frames frames = forwardKinematics(skeleton, neutral(skeleton));
    for (int i = 0; i < skeleton.jointCount(); ++i) {
      if (skeleton.joint(i).ball) return false;
      for (const AxisDof& dof : skeleton.joint(i).axes) {
        const double z = std::abs((frames[i].linear() * dof.axis).z());
        if (dof.kind == AxisDof::Kind::Rotation ? z < 1.0 - 1e-12 : z > 1e-12) return false;
      }
    }
    return true;
  }

  double delta_;
};

class Newton1dSolver final : public IkSolver {
 public:
  explicit Newton1dSolver(double delta) : delta_(delta) {}
  std::string whyUnsupported(const IkProblem& problem) const override {
    if (problem.skeleton->nv() == 1) return {};
    return "one-dimensional Newton needs a skeleton of one degree of freedom, this one has " +
           std::to_string(problem.skeleton->nv());
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    CountedEvaluator at(problem);
    IkReport report;
    report.q = problem.start;
    report.why = Stop::Unsupported;
    at.moveTo(problem.start);
    if (!whyUnsupported(problem).empty()) {
      report.residual = at.residual().norm();
      return report;
    }
    at.moveTo(projectToLimits(*problem.skeleton, problem.start));
    const Skeleton& skeleton = *problem.skeleton;
    int one = 0;  // the joint that moves
    while (skeleton.vCount(one) == 0) ++one;
    const int iq = skeleton.qIndex(one);
    const auto configuration = [&](double value) {
      VectorXd q = VectorXd::Constant(skeleton.nq(), value);
      skeleton.couple(q);
      return q;
    };
    const auto gradient = [&](double q) {  // of half the squared residual: -J^T r
      at.moveTo(configuration(q));
      return -at.jacobian().col(0).dot(at.residual());
    };
    report.why = Stop::Budget;
    for (int& i = at.counters().iterations; i < budget.maxIterations; ++i) {
      if (at.withinTolerance()) {
        report.why = Stop::Converged;
        break;
      }
      if (at.seconds() > budget.maxSeconds) break;
      const double q = at.q()[iq], residual = at.residual().norm();
      const double g = gradient(q), slope = (gradient(q + delta_) - g) / delta_;
      const double dq = -g / slope;
      if (trace != TraceLevel::Off)
        report.trace.push_back({.q = trace == TraceLevel::Full ? configuration(q) : VectorXd(),
                                .residual = residual,
                                .stepNorm = std::abs(dq),
                                .damping = 0.0,
                                .seconds = at.seconds()});
      if (slope == 0.0 || !std::isfinite(dq)) {
        at.moveTo(configuration(q));
        report.why = Stop::Failure;
        break;
      }
      at.moveTo(projectToLimits(*problem.skeleton, configuration(q + dq)));
      if (std::abs(at.q()[iq] - q) < 1e-12) {
        report.why = at.withinTolerance() ? Stop::Converged : whyAtRest(problem, at.q());
        break;
      }
    }
    if (report.why == Stop::Budget && at.withinTolerance()) report.why = Stop::Converged;
    report.q = at.q();
    report.residual = at.residual().norm();
    report.counters = at.counters();
    report.seconds = at.seconds();
    return report;
  }

 private:
  double delta_;
};

}  // namespace

std::unique_ptr<IkSolver> makeNewton1d(const Newton1dParameters& parameters) {
  return std::make_unique<Newton1dSolver>(parameters.delta);
}
std::unique_ptr<IkSolver> makeNewton() { return std::make_unique<NewtonSolver>(analytic); }
std::unique_ptr<IkSolver> makeNewtonDifferenceQuotient(const NewtonDifferenceQuotientParameters& parameters) {
  return std::make_unique<NewtonSolver>(parameters.delta);
}

}  // namespace gelenk
