#include "solvers/ceres/ceres_solver.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "kinematics/rotation.h"
#include "solvers/iteration/attempt.h"

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

enum class Method { LevenbergMarquardt, Dogleg, LineSearch };

/// A bounded number x as Ceres sees it: itself with bounds, or, where Ceres knows none, middle + half sin(t).
struct Range {
  double lower, upper;
  bool sine;

  bool bounded() const { return std::isfinite(lower) && std::isfinite(upper); }
  double middle() const { return 0.5 * (lower + upper); }
  double half() const { return 0.5 * (upper - lower); }
  double fromParameter(double t) const { return sine && bounded() ? middle() + half() * std::sin(t) : t; }
  double slope(double t) const { return sine && bounded() ? half() * std::cos(t) : 1.0; }
  double toParameter(double x) const {
    if (!sine || !bounded() || half() <= 0.0) return x;
    return std::asin(std::clamp((x - middle()) / half(), -0.99, 0.99));
  }
};

/// The unit square onto the unit disc, and its derivative.
Vector2d discFromSquare(double u, double v) {
  return {u * std::sqrt(1.0 - 0.5 * v * v), v * std::sqrt(1.0 - 0.5 * u * u)};
}
Eigen::Matrix2d discSlope(double u, double v) {
  const double a = std::sqrt(1.0 - 0.5 * v * v), b = std::sqrt(1.0 - 0.5 * u * u);
  return (Eigen::Matrix2d() << a, -0.5 * u * v / a, -0.5 * u * v / b, b).finished();
}
Vector2d squareFromDisc(Vector2d d) {
  if (d.norm() > 1.0) d.normalize();
  const double k = 2.0 * std::sqrt(2.0), s = d.x() * d.x() - d.y() * d.y();
  const auto root = [](double x) { return std::sqrt(std::max(0.0, x)); };
  const Vector2d uv(0.5 * (root(2.0 + s + k * d.x()) - root(2.0 + s - k * d.x())),
                    0.5 * (root(2.0 - s + k * d.y()) - root(2.0 - s - k * d.y())));
  return uv.cwiseMax(-1.0).cwiseMin(1.0);
}

/// A parameter block: one axis, a free quaternion, or a limited ball.
struct Block {
  enum class Kind { Axis, Quaternion, LimitedBall } kind;
  int joint, iq, iv, size, offset;  ///< offset: of the block in the parameter vector
  std::vector<Range> ranges = {};
};

std::vector<Block> makeBlocks(const Skeleton& skeleton, bool sine) {
  std::vector<Block> blocks;
  int offset = 0;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    if (joint.coupling) continue;
    const int axes = static_cast<int>(joint.axes.size());
    for (int k = 0; k < axes; ++k) {
      const AxisDof& dof = joint.axes[k];
      const bool wraps = dof.isFullTurn() && !skeleton.isCoupled(i);
      const Range range = wraps ? Range{-unlimited, unlimited, sine} : Range{dof.lower, dof.upper, sine};
      blocks.push_back(
          {Block::Kind::Axis, i, skeleton.qIndex(i) + k, skeleton.vIndex(i) + k, 1, offset, {range}});
      offset += 1;
    }
    if (!joint.ball) continue;
    Block block{Block::Kind::Quaternion, i, skeleton.qIndex(i) + axes, skeleton.vIndex(i) + axes, 4, offset};
    if (joint.ballLimit) {
      block.kind = Block::Kind::LimitedBall;
      block.size = 3;
      block.ranges = {{-1.0, 1.0, sine},
                      {-1.0, 1.0, sine},
                      {joint.ballLimit->twistLower, joint.ballLimit->twistUpper, sine}};
    }
    offset += block.size;
    blocks.push_back(block);
  }
  return blocks;
}

/// The problem as Ceres sees it.
class Chart {
 public:
  Chart(const Skeleton& skeleton, bool sine) : skeleton_(skeleton), blocks_(makeBlocks(skeleton, sine)) {
    x_.setZero(blocks_.empty() ? 0 : blocks_.back().offset + blocks_.back().size);
  }
  const std::vector<Block>& blocks() const { return blocks_; }
  double* parameters(const Block& block) { return x_.data() + block.offset; }

  void set(const VectorXd& q) {
    for (const Block& block : blocks_) {
      double* x = parameters(block);
      if (block.kind == Block::Kind::Axis) {
        x[0] = block.ranges[0].toParameter(q[block.iq]);
      } else if (block.kind == Block::Kind::Quaternion) {
        Eigen::Map<Eigen::Vector4d>(x, 4) = q.segment<4>(block.iq);
      } else {
        const BallLimit& limit = *skeleton_.joint(block.joint).ballLimit;
        const Vector3d c = swingTwistCoordinates(ballRotation(skeleton_, q, block.joint));
        const Vector2d uv = squareFromDisc((c.head<2>() - limit.swingCentre).cwiseQuotient(limit.swingRadii));
        x[0] = block.ranges[0].toParameter(uv.x());
        x[1] = block.ranges[1].toParameter(uv.y());
        x[2] = block.ranges[2].toParameter(std::clamp(c.z(), limit.twistLower, limit.twistUpper));
      }
    }
  }

  template <typename Parameters>  // Parameters: block number -> const double*
  void configuration(const Parameters& at, VectorXd& q) const {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const Block& block = blocks_[i];
      const double* x = at(i);
      if (block.kind == Block::Kind::Axis) {
        q[block.iq] = block.ranges[0].fromParameter(x[0]);
      } else if (block.kind == Block::Kind::Quaternion) {
        q.segment<4>(block.iq) = Eigen::Map<const Eigen::Vector4d>(x).normalized();
      } else {
        const BallLimit& limit = *skeleton_.joint(block.joint).ballLimit;
        const Vector2d disc =
            discFromSquare(block.ranges[0].fromParameter(x[0]), block.ranges[1].fromParameter(x[1]));
        const Vector2d swing = limit.swingCentre + limit.swingRadii.cwiseProduct(disc);
        setBallRotation(
            skeleton_, q, block.joint,
            fromSwingTwistCoordinates({swing.x(), swing.y(), block.ranges[2].fromParameter(x[2])}));
      }
    }
    skeleton_.couple(q);
  }
  void configuration(VectorXd& q) const {
    configuration([&](std::size_t i) { return x_.data() + blocks_[i].offset; }, q);
  }

  /// d(tangent) / d(parameters) of a block, applied to the tangent Jacobian's columns: out = J_block * slope.
  void pullBack(const Block& block, const double* x, const VectorXd& q, const MatrixXd& J,
                Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>> out) const {
    if (block.kind == Block::Kind::Axis) {
      out.col(0) = J.col(block.iv) * block.ranges[0].slope(x[0]);
      return;
    }
    const Eigen::Quaterniond rotation = ballRotation(skeleton_, q, block.joint);
    if (block.kind == Block::Kind::Quaternion) {  // omega = 2 vec(conj(q) dq)
      Eigen::Matrix<double, 3, 4> slope;
      slope << -rotation.x(), rotation.w(), rotation.z(), -rotation.y(),  //
          -rotation.y(), -rotation.z(), rotation.w(), rotation.x(),       //
          -rotation.z(), rotation.y(), -rotation.x(), rotation.w();
      out = J.middleCols<3>(block.iv) * (2.0 * slope);
      return;
    }
    const BallLimit& limit = *skeleton_.joint(block.joint).ballLimit;
    Matrix3d slope = Matrix3d::Identity();
    slope.topLeftCorner<2, 2>() =
        limit.swingRadii.asDiagonal() *
        discSlope(block.ranges[0].fromParameter(x[0]), block.ranges[1].fromParameter(x[1]));
    for (int k = 0; k < 3; ++k) slope.col(k) *= block.ranges[k].slope(x[k]);
    out = J.middleCols<3>(block.iv) * (swingTwistJacobian(rotation).inverse() * slope);
  }

 private:
  const Skeleton& skeleton_;
  std::vector<Block> blocks_;
  VectorXd x_;
};

class Residual final : public ceres::CostFunction {
 public:
  Residual(CountedEvaluator& at, const Chart& chart) : at_(at), chart_(chart), q_(at.skeleton().nq()) {
    set_num_residuals(at.rows());
    for (const Block& block : chart.blocks()) mutable_parameter_block_sizes()->push_back(block.size);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    chart_.configuration([&](std::size_t i) { return parameters[i]; }, q_);
    if (!q_.allFinite()) return false;
    at_.moveTo(q_);
    Eigen::Map<VectorXd>(residuals, at_.rows()) = at_.residual();
    if (!jacobians) return true;
    for (std::size_t i = 0; i < chart_.blocks().size(); ++i) {
      if (!jacobians[i]) continue;
      const Block& block = chart_.blocks()[i];
      Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>> out(jacobians[i], at_.rows(), block.size);
      chart_.pullBack(block, parameters[i], q_, at_.jacobian(), out);
      out = -out;
      if (!out.allFinite()) return false;
    }
    return true;
  }

 private:
  CountedEvaluator& at_;
  const Chart& chart_;
  mutable VectorXd q_;
};

/// Ceres's progress, handed to the attempt: counts, traces and ends it when the goals are met.
class Watch final : public ceres::IterationCallback {
 public:
  Watch(Attempt& attempt, const Chart& chart)
      : attempt_(attempt), chart_(chart), q_(attempt.at.skeleton().nq()) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (summary.iteration == 0) return ceres::SOLVER_CONTINUE;
    attempt_.countIteration(summary.step_norm,
                            summary.trust_region_radius > 0.0 ? 1.0 / summary.trust_region_radius : 0.0);
    ++attempt_.at.counters().factorisations;
    chart_.configuration(q_);
    attempt_.propose(q_);
    return attempt_.isOver() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  Attempt& attempt_;
  const Chart& chart_;
  VectorXd q_;
};

struct Constants {
  CeresTrustRegionParameters trustRegion = {};
  CeresLineSearchParameters lineSearch = {};
};

ceres::Solver::Options optionsFor(Method method, const Constants& constants, const Budget& budget,
                                  double elapsed) {
  ceres::Solver::Options options;
  options.minimizer_type = method == Method::LineSearch ? ceres::LINE_SEARCH : ceres::TRUST_REGION;
  options.trust_region_strategy_type = method == Method::Dogleg ? ceres::DOGLEG : ceres::LEVENBERG_MARQUARDT;
  options.linear_solver_type = ceres::DENSE_QR;
  options.line_search_direction_type = ceres::LBFGS;
  options.initial_trust_region_radius = constants.trustRegion.initialRadius;
  options.min_relative_decrease = constants.trustRegion.leastRelativeDecrease;
  options.max_lbfgs_rank = constants.lineSearch.rank;
  options.line_search_sufficient_function_decrease = constants.lineSearch.armijo;
  options.line_search_sufficient_curvature_decrease = constants.lineSearch.wolfe;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  options.max_num_iterations = budget.maxIterations;
  options.max_solver_time_in_seconds = std::max(0.0, budget.maxSeconds - elapsed);
  options.function_tolerance = 0.0;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.update_state_every_iteration = true;
  return options;
}

class CeresSolver final : public IkSolver {
 public:
  CeresSolver(Method method, const Constants& constants) : method_(method), constants_(constants) {}
  std::string whyUnsupported(const IkProblem&) const override { return {}; }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    Chart chart(*problem.skeleton, method_ == Method::LineSearch);
    return solveWithRestarts(problem, budget, trace, [&](Attempt& attempt) {
      if (attempt.isOver()) return;
      if (chart.blocks().empty()) return attempt.stop(Stop::Stationary);
      do {
        chart.set(attempt.at.q());
        Residual residual(attempt.at, chart);
        ceres::Problem::Options ownership;
        ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
        ceres::Problem task(ownership);
        connect(task, residual, chart);
        Watch watch(attempt, chart);
        ceres::Solver::Options options = optionsFor(method_, constants_, budget, attempt.at.seconds());
        options.callbacks.push_back(&watch);
        ceres::Solver::Summary summary;
        ceres::Solve(options, &task, &summary);
        conclude(attempt, chart, summary);
      } while (!attempt.isOver());
    });
  }

 private:
  void connect(ceres::Problem& task, Residual& residual, Chart& chart) const {
    std::vector<double*> parameters;
    for (const Block& block : chart.blocks()) {
      double* x = chart.parameters(block);
      parameters.push_back(x);
      task.AddParameterBlock(x, block.size);
      if (block.kind == Block::Kind::Quaternion) task.SetManifold(x, new ceres::QuaternionManifold);
      for (std::size_t k = 0; method_ != Method::LineSearch && k < block.ranges.size(); ++k) {
        const Range& range = block.ranges[k];
        if (range.upper <= range.lower) {
          task.SetParameterBlockConstant(x);
          continue;
        }
        if (std::isfinite(range.lower)) task.SetParameterLowerBound(x, static_cast<int>(k), range.lower);
        if (std::isfinite(range.upper)) task.SetParameterUpperBound(x, static_cast<int>(k), range.upper);
      }
    }
    task.AddResidualBlock(&residual, nullptr, parameters);
  }

  static void conclude(Attempt& attempt, const Chart& chart, const ceres::Solver::Summary& summary) {
    VectorXd q(attempt.at.skeleton().nq());
    chart.configuration(q);
    if (q.allFinite() && attempt.why() != Stop::Converged) attempt.propose(q);
    if (attempt.isOver()) return;
    if (attempt.rest() != Attempt::Rest::No) return;  // over, or on from where a saddle was left
    switch (summary.termination_type) {
      case ceres::NO_CONVERGENCE: return attempt.stop(Stop::Budget);
      case ceres::FAILURE: return attempt.stop(Stop::Failure);
      default: return attempt.stop(Stop::Stalled);
    }
  }

  Method method_;
  Constants constants_;
};

}  // namespace

std::unique_ptr<IkSolver> makeCeresLm(const CeresTrustRegionParameters& parameters) {
  return std::make_unique<CeresSolver>(Method::LevenbergMarquardt, Constants{.trustRegion = parameters});
}
std::unique_ptr<IkSolver> makeCeresDogleg(const CeresTrustRegionParameters& parameters) {
  return std::make_unique<CeresSolver>(Method::Dogleg, Constants{.trustRegion = parameters});
}
std::unique_ptr<IkSolver> makeCeresLineSearch(const CeresLineSearchParameters& parameters) {
  return std::make_unique<CeresSolver>(Method::LineSearch, Constants{.lineSearch = parameters});
}

}  // namespace gelenk
