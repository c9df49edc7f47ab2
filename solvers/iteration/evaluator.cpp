#include "solvers/iteration/evaluator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gelenk {

using Eigen::MatrixXd;
using Eigen::VectorXd;

int residualRows(const Goal& goal, const Skeleton& skeleton) { return goalType(goal.kind).rows(skeleton); }

void goalResidual(const Goal& goal, const Skeleton& skeleton, const VectorXd& q, const Frames& frames,
                  Eigen::Ref<VectorXd> r) {
  goalType(goal.kind).residual(goal, {skeleton, q, frames}, r);
}

CountedEvaluator::CountedEvaluator(const IkProblem& problem)
    : problem_(problem), begin_(std::chrono::steady_clock::now()) {
  if (!skeleton().followers().empty()) {
    uncoupled_ = skeleton().uncoupled();
    moves_.resize(free().nv());
    factor_.assign(free().nv(), 1.0);
    for (int i = 0; i < free().jointCount(); ++i) {
      const auto& coupling = skeleton().joint(i).coupling;
      for (int k = 0; k < free().vCount(i); ++k) moves_[free().vIndex(i) + k] = skeleton().vIndex(i) + k;
      if (coupling) factor_[free().vIndex(i)] = coupling->multiplier;
    }
  }
  for (const Goal& goal : problem.goals) {
    const GoalType& type = goalType(goal.kind);
    if (type.whyNot)
      if (const std::string why = type.whyNot(goal, free()); !why.empty()) throw std::invalid_argument(why);
    parts_.push_back({.type = &type,
                      .row = rows_,
                      .rows = type.rows(free()),
                      .rootWeight = std::sqrt(goal.weight),
                      .path = pathTo(goal.joint)});
    rows_ += parts_.back().rows;
  }
  const int nv = free().nv();
  r_.resize(rows_);
  J_.resize(rows_, nv);
  for (Eigen::Matrix3Xd* scratch : {&A_, &B_, &C_}) scratch->resize(3, nv);
}

/// From the root.
std::vector<DofGroup> CountedEvaluator::pathTo(int joint) const {
  std::vector<DofGroup> path;
  for (; joint >= 0; joint = free().parent(joint)) {  // from the tip, turned round below
    const int axes = static_cast<int>(free().joint(joint).axes.size());
    if (free().joint(joint).ball) path.push_back({free().vIndex(joint) + axes, 3});
    for (int k = axes - 1; k >= 0; --k) path.push_back({free().vIndex(joint) + k, 1});
  }
  std::reverse(path.begin(), path.end());
  return path;
}

double CountedEvaluator::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

void CountedEvaluator::moveTo(const VectorXd& q) {
  q_ = q;
  forwardKinematics(free(), q_, frames_);
  ++counters_.forwardKinematics;
  jacobianIsCurrent_ = false;
  for (std::size_t g = 0; g < parts_.size(); ++g) {
    const Part& part = parts_[g];
    auto r = r_.segment(part.row, part.rows);
    part.type->residual(problem_.goals[g], {free(), q_, frames_}, r);
    r *= part.rootWeight;
  }
}

const MatrixXd& CountedEvaluator::jacobian() {
  if (jacobianIsCurrent_) return uncoupled_ ? foldedJ_ : J_;
  jacobianIsCurrent_ = true;
  ++counters_.jacobians;
  dofTwists(free(), q_, frames_, twists_);
  for (std::size_t g = 0; g < parts_.size(); ++g) {
    const Part& part = parts_[g];
    auto J = J_.middleRows(part.row, part.rows);
    part.type->jacobian(problem_.goals[g], {free(), q_, frames_, twists_, A_, B_, C_}, J);
    J *= part.rootWeight;
  }
  if (!uncoupled_) return J_;
  foldColumns(J_, foldedJ_);
  return foldedJ_;
}

/// By the chain rule: the columns of a follower and of its source move together.
void CountedEvaluator::foldColumns(const MatrixXd& ofFree, MatrixXd& out) const {
  out.setZero(ofFree.rows(), skeleton().nv());
  for (int k = 0; k < free().nv(); ++k) out.col(moves_[k]) += factor_[k] * ofFree.col(k);
}

/// Of the goal's own rows.
GoalBend CountedEvaluator::bendOf(std::size_t g) {
  const Part& part = parts_[g];
  return {twists_,
          part.path,
          J_.middleRows(part.row, part.rows),
          r_.segment(part.row, part.rows),
          problem_.goals[g].weight,
          free(),
          A_};
}

void CountedEvaluator::jacobianDerivative(const VectorXd& d, MatrixXd& dJ) {
  jacobian();
  ++counters_.hessians;
  if (uncoupled_) {
    unfolded_.resize(free().nv());
    for (int k = 0; k < free().nv(); ++k) unfolded_[k] = factor_[k] * d[moves_[k]];
  }
  MatrixXd& out = uncoupled_ ? H_ : dJ;
  out.setZero(rows_, free().nv());
  for (std::size_t g = 0; g < parts_.size(); ++g)
    if (const Part& part = parts_[g]; part.type->addJacobianDerivative)
      part.type->addJacobianDerivative(problem_.goals[g], bendOf(g), uncoupled_ ? unfolded_ : d,
                                       out.middleRows(part.row, part.rows));
  if (uncoupled_) foldColumns(out, dJ);
}

const MatrixXd& CountedEvaluator::hessian() {
  jacobian();
  ++counters_.hessians;
  H_.setZero(free().nv(), free().nv());
  for (std::size_t g = 0; g < parts_.size(); ++g) {
    const Part& part = parts_[g];
    if (!(problem_.goals[g].weight > 0.0)) continue;
    if (part.type->addHessian) {
      part.type->addHessian(problem_.goals[g], bendOf(g), H_);
    } else {
      const auto J = J_.middleRows(part.row, part.rows);
      H_.noalias() += J.transpose() * J;
    }
  }
  if (!uncoupled_) return H_;
  MatrixXd half;
  foldColumns(H_, half);
  foldColumns(half.transpose(), foldedH_);
  return foldedH_;
}

bool CountedEvaluator::withinTolerance() const {
  for (const Part& part : parts_) {
    if (!part.type->judged) continue;
    const double unweight = part.rootWeight > 0.0 ? 1.0 / part.rootWeight : 0.0;
    const GoalError error = part.type->error(r_.segment(part.row, part.rows));
    if (!(error.position * unweight <= problem_.positionTolerance &&
          error.orientation * unweight <= problem_.orientationTolerance))
      return false;
  }
  return true;
}

}  // namespace gelenk
