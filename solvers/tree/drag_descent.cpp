#include "solvers/tree/drag_descent.h"

#include <algorithm>
#include <cmath>

#include "kinematics/rotation.h"
#include "solvers/serial/simd.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Limits are met to the last bits where a step ended on them.
bool onCone(const TreeNode& node, const double* c) {
  return (Vector2d(c[0], c[1]) - node.swingCentre).cwiseQuotient(node.swingRadii).squaredNorm() > 1.0 - 1e-9;
}

constexpr double smallestPivot = 1e-9;
constexpr double armijo = 1e-4;

/// Rotation vector from a to b, both unit quaternions (w, x, y, z), in the frame that a turns.
Vector3d rotationVector(const double* a, const double* b) {
  return logRotation(Quaterniond(a[0], -a[1], -a[2], -a[3]) * Quaterniond(b[0], b[1], b[2], b[3]));
}

}  // namespace

DragDescent::DragDescent(const Skeleton& skeleton, double unit, std::vector<double> stiffness,
                         const VectorXd& rest)
    : tree_(skeleton, unit), stiffnessOfDof_(std::move(stiffness)), posture_(rest) {}

void DragDescent::setPosture(const VectorXd& q) {
  if (posture_ == q) return;
  posture_ = q;
  TreePose pose;
  tree_.load(posture_, pose);
  postureCoordinates_ = pose.coordinates;
}

void DragDescent::build(std::span<const int> joints, const Vector3d& origin) {
  tree_.build(joints, origin);
  const int n = tree_.dofCount();
  H_.setStructure(tree_.dofParents());
  W_.setStructure(tree_.dofParents());
  stays_.assign(n, 0);
  for (std::vector<double>* v : {&g_, &d_, &x_, &value_, &s_, &tangentLength_}) v->assign(n, 0.0);
  tangent_.assign(n, Vector2d::Zero());
  state_.assign(n, DofState::Free);
  for (const TreeNode& node : tree_.nodes()) {
    const Skeleton& skeleton = tree_.skeleton();
    const int v = skeleton.vIndex(node.joint) + node.qIndex - skeleton.qIndex(node.joint);
    if (skeleton.joint(node.joint).coupling) continue;  // its source's posture is its own
    for (int k = 0; k < node.dofs(); ++k) s_[node.dof + k] = stiffnessOfDof_[v + k];
  }
  points_.clear();
  blocks_.clear();
  sums_.clear();
  shares_.clear();
  rows_ = 0;
  tree_.load(posture_, trial_);
  postureCoordinates_ = trial_.coordinates;
  forget();
}

void DragDescent::forget() {
  muGaussNewton_ = muExact_ = 0.0;
  lastGaussNewtonGain_ = 1.0;
  forcedExact_ = 0;
}

void DragDescent::load(const VectorXd& q) {
  tree_.load(q, pose_);
  trial_ = pose_;
  anchor();
}

double DragDescent::residual() const { return std::sqrt(2.0 * goalCost(pose_)); }

double DragDescent::startingDamping() const { return std::max(1e-3, 0.1 * std::sqrt(cost_)); }

double DragDescent::regulariser(const Settings& settings, const TreePose& pose) const {
  double posture = 0.0, change = 0.0;
  for (const TreeNode& node : tree_.nodes()) {
    const double* c = pose.coordinates.data() + node.coordinate;
    const double* rest = postureCoordinates_.data() + node.coordinate;
    const double* anchor = changeAnchor_.data() + node.coordinate;
    if (node.motion == TreeMotion::FreeBall) {
      if (settings.lambda > 0.0) posture += s_[node.dof] * rotationVector(rest, c).squaredNorm();
      if (settings.kappa > 0.0) change += rotationVector(anchor, c).squaredNorm();
      continue;
    }
    for (int k = 0; k < node.dofs(); ++k) {
      posture += s_[node.dof + k] * (c[k] - rest[k]) * (c[k] - rest[k]);
      change += (c[k] - anchor[k]) * (c[k] - anchor[k]);
    }
  }
  return 0.5 * (settings.lambda * posture + settings.kappa * change);
}

double DragDescent::objective(const Settings& settings, const TreePose& pose) const {
  return goalCost(pose) + regulariser(settings, pose);
}

// ---- blocks ----------------------------------------------------------------------------------------------

void DragDescent::look(const TreeBlock& block, const TreePose& pose, bool corrected, bool exact,
                       DragModel& model) const {
  std::array<Vector3d, DragModel::mostVectors> y;
  const int count = block.type->drag.sums;
  for (int j = 0; j < count; ++j) {
    const TreeSum& sum = sums_[block.firstSum + j];
    y[j] = sum.scale * tree_.at(pose, sum, shares_) + sum.shift;
    if (corrected) y[j] -= block.correction[j];
  }
  block.type->drag.model(*block.goal, {y.data(), static_cast<std::size_t>(count)}, arm_, exact, model);
}

double DragDescent::pullOf(const TreeBlock& block, const DragModel& model) {
  const double squared = 2.0 * model.cost;
  return squared <= block.cut * block.cut ? 1.0 : block.cut / std::sqrt(squared);
}

double DragDescent::costOfBlocks(const TreePose& pose) const {
  double sum = 0.0;
  for (const TreeBlock& block : blocks_) {
    if (block.weight == 0.0) continue;
    DragModel model;
    look(block, pose, true, false, model);
    const double length = std::sqrt(2.0 * model.cost);
    sum += block.weight * (length <= block.cut ? model.cost : block.cut * (length - 0.5 * block.cut));
  }
  return sum / (tree_.unit() * tree_.unit());
}

void DragDescent::gather() {
  if (blocks_.empty()) return tree_.gather(pose_, points_);
  const double perUnit2 = 1.0 / (tree_.unit() * tree_.unit());
  tree_.beginGather();
  tree_.addPoints(pose_, points_);
  for (const TreeBlock& block : blocks_) {
    if (block.weight == 0.0) continue;
    DragModel model;
    look(block, pose_, true, false, model);
    const double factor = block.weight * pullOf(block, model) * perUnit2;
    for (int j = 0; j < block.type->drag.sums; ++j) {
      const TreeSum& sum = sums_[block.firstSum + j];
      if (!model.force[j].isZero(0.0))
        tree_.addForce(pose_, sum, shares_, factor * sum.scale * model.force[j]);
    }
  }
  tree_.endGather();
}

/// A row of U of zeros: entry k stands at 4 k of what is returned.
double* DragDescent::addRow(double sign) {
  const int n = tree_.dofCount();
  if (rows_ % 4 == 0) {
    U_.resize(static_cast<std::size_t>(rows_ + 4) * n);
    std::fill(U_.end() - 4 * n, U_.end(), 0.0);
  }
  double* to = U_.data() + static_cast<std::ptrdiff_t>(rows_ / 4) * 4 * n + rows_ % 4;
  sign_.push_back(sign);
  ++rows_;
  return to;
}

/// U: couplings, and what the blocks' models add to the Hessian beside the tree. After gradientAndHessian.
void DragDescent::collectRows(StepKind kind) {
  rows_ = 0;
  sign_.clear();
  for (const TreeCoupling& c : tree_.couplings()) {
    double* to = addRow(0.0);
    to[4 * tree_.node(c.follower).dof] = 1.0;
    to[4 * tree_.node(c.source).dof] = -c.multiplier;
  }
  if (blocks_.empty()) return;
  const int n = tree_.dofCount();
  for (const double wanted : {1.0, -1.0})
    for (const TreeBlock& block : blocks_) {
      if (block.weight == 0.0) continue;
      DragModel model;
      look(block, pose_, true, kind == StepKind::ExactHessian, model);
      if (model.rows == 0) continue;
      const int sums = block.type->drag.sums;
      bool sloped = false;
      const double factor = std::sqrt(block.weight * pullOf(block, model)) / tree_.unit();
      for (int r = 0; r < model.rows; ++r) {
        if (model.row[r].sign != wanted) continue;
        slopes_.resize(static_cast<std::size_t>(DragModel::mostVectors) * n);
        for (int j = 0; !sloped && j < sums; ++j)
          tree_.slopeOf(pose_, sums_[block.firstSum + j], shares_,
                        slopes_.data() + static_cast<std::ptrdiff_t>(j) * n);
        sloped = true;
        double* to = addRow(wanted);
        for (int j = 0; j < sums; ++j) {
          const Vector3d c = factor * sums_[block.firstSum + j].scale * model.row[r].c[j];
          if (c.isZero(0.0)) continue;
          const Vector3d* slope = slopes_.data() + static_cast<std::ptrdiff_t>(j) * n;
          for (int k = 0; k < n; ++k) to[4 * k] += c.dot(slope[k]);
        }
      }
    }
}

/// S <- factors of diag(sign) + V W^-1 V^T, strict lower and diagonal. False where a pivot has not the sign
/// of its row: the matrix of the step is not positive definite.
bool DragDescent::factorRows() {
  const int n = tree_.dofCount(), packs = (rows_ + 3) / 4, m = 4 * packs;
  Y_ = V_;
  for (int p = 0; p < packs; ++p) W_.solveUpper(Y_.data() + static_cast<std::ptrdiff_t>(p) * 4 * n);
  S_.assign(static_cast<std::size_t>(m) * m, 0.0);
  for (int p = 0; p < packs; ++p)
    for (int q = 0; q <= p; ++q) {
      Double4 sum[4] = {};
      const double* a = Y_.data() + static_cast<std::ptrdiff_t>(p) * 4 * n;
      const double* b = Y_.data() + static_cast<std::ptrdiff_t>(q) * 4 * n;
      for (int k = 0; k < n; ++k) {
        const Double4 scaled = four(b + 4 * k) * (1.0 / W_.diagonal(k));
        for (int i = 0; i < 4; ++i) sum[i] += a[4 * k + i] * scaled;
      }
      for (int i = 0; i < 4; ++i)
        four(S_.data() + static_cast<std::ptrdiff_t>(4 * p + i) * m + 4 * q) = sum[i];
    }
  for (int i = 0; i < rows_; ++i) S_[static_cast<std::size_t>(i) * m + i] += sign_[i];
  for (int i = 0; i < rows_; ++i) {  // L D L^T by rows
    double* Si = S_.data() + static_cast<std::ptrdiff_t>(i) * m;
    for (int j = 0; j < i; ++j) {
      const double* Sj = S_.data() + static_cast<std::ptrdiff_t>(j) * m;
      double entry = Si[j];
      for (int k = 0; k < j; ++k) entry -= Si[k] * Sj[k];  // Si[k] still carries D_k
      Si[j] = entry;
    }
    double pivot = Si[i];
    for (int j = 0; j < i; ++j) {
      const double l = Si[j] / S_[static_cast<std::size_t>(j) * m + j];
      pivot -= l * Si[j];
      Si[j] = l;
    }
    if (!(pivot * (sign_[i] < 0.0 ? -1.0 : 1.0) > 0.0)) return false;
    Si[i] = pivot;
  }
  return true;
}

/// x <- (W + V^T S V)^-1 x.
void DragDescent::solveSystem(double* x) {
  W_.solve(x);
  if (rows_ == 0) return;
  const int n = tree_.dofCount(), packs = (rows_ + 3) / 4, m = 4 * packs;
  std::array<double, 256> buffer;
  double* t = buffer.data();
  std::vector<double> larger;
  if (m > 256) larger.resize(m), t = larger.data();
  for (int p = 0; p < packs; ++p) {
    const double* V = V_.data() + static_cast<std::ptrdiff_t>(p) * 4 * n;
    Double4 sum = {};
    for (int k = 0; k < n; ++k) sum += x[k] * four(V + 4 * k);
    four(t + 4 * p) = sum;
  }
  for (std::size_t i = 0; i < tree_.couplings().size(); ++i) t[i] += held_[i];
  for (int i = 0; i < rows_; ++i)
    for (int j = 0; j < i; ++j) t[i] -= S_[static_cast<std::size_t>(i) * m + j] * t[j];
  for (int i = 0; i < rows_; ++i) t[i] /= S_[static_cast<std::size_t>(i) * m + i];
  for (int i = rows_ - 1; i >= 0; --i)
    for (int j = i + 1; j < rows_; ++j) t[i] -= S_[static_cast<std::size_t>(j) * m + i] * t[j];
  z_.assign(n, 0.0);
  for (int p = 0; p < packs; ++p) {
    const double* V = V_.data() + static_cast<std::ptrdiff_t>(p) * 4 * n;
    for (int k = 0; k < n; ++k) {
      const Double4 product = four(V + 4 * k) * four(t + 4 * p);
      z_[k] += product[0] + product[1] + product[2] + product[3];
    }
  }
  W_.solve(z_.data());
  for (int k = 0; k < n; ++k) x[k] -= z_[k];
}

/// (H + U^T S U + mu) d at dof k and what follows it, d_ the step.
double DragDescent::modelSlope(int k, double mu) const {
  double sum = H_.rowTimes(k, d_.data()) + mu * d_[k];
  for (int r = 0; r < rows_; ++r) sum += rowEntry(r, k) * Ud_[r];
  for (const TreeCoupling& c : tree_.couplings())
    if (tree_.node(c.source).dof == k) sum += c.multiplier * modelSlope(tree_.node(c.follower).dof, mu);
  return sum;
}

void DragDescent::addRegulariser(const Settings& settings) {
  const double lambda = settings.lambda, kappa = settings.kappa;
  for (const TreeNode& node : tree_.nodes()) {
    const double* c = pose_.coordinates.data() + node.coordinate;
    const double* rest = postureCoordinates_.data() + node.coordinate;
    const double* anchor = changeAnchor_.data() + node.coordinate;
    if (node.motion == TreeMotion::FreeBall) {
      const double s = lambda * s_[node.dof];
      const Vector3d fromRest = rotationVector(rest, c), fromAnchor = rotationVector(anchor, c);
      const Matrix3d A = s * squaredAngleHessian(fromRest) + kappa * squaredAngleHessian(fromAnchor);
      for (int i = 0; i < 3; ++i) {
        g_[node.dof + i] += s * fromRest[i] + kappa * fromAnchor[i];
        for (int j = 0; j <= i; ++j) H_.row(node.dof + i)[node.depth + j] += A(i, j);
      }
      continue;
    }
    for (int k = 0; k < node.dofs(); ++k) {
      const double s = lambda * s_[node.dof + k];
      g_[node.dof + k] += s * (c[k] - rest[k]) + kappa * (c[k] - anchor[k]);
      H_.row(node.dof + k)[node.depth + k] += s + kappa;
    }
  }
}

void DragDescent::assemble(const Settings& settings, StepKind kind) {
  tree_.gradientAndHessian(pose_, kind == StepKind::ExactHessian ? 1.0 : 0.0, g_.data(), H_);
  collectRows(kind);
  addRegulariser(settings);
  for (const TreeCoupling& c : tree_.couplings()) {  // the same steps solve it: they keep the coupling
    double& ofFollower = g_[tree_.node(c.follower).dof];
    g_[tree_.node(c.source).dof] += c.multiplier * ofFollower;
    ofFollower = 0.0;
  }
}

void DragDescent::derivatives(const Settings& settings, double beta, double* gradient, TreeMatrix& H) {
  gather();
  assemble(settings, beta != 0.0 ? StepKind::ExactHessian : StepKind::GaussNewton);
  std::copy(g_.begin(), g_.end(), gradient);
  H.copyValues(H_);
}

// ---- limits
// ----------------------------------------------------------------------------------------------------

/// Where the swing at c stands on its cone: the unit tangent of the ellipse and its length by the ellipse's
/// angle.
void DragDescent::setConeTangent(const TreeNode& node, const double* c) {
  const Vector2d scaled = (Vector2d(c[0], c[1]) - node.swingCentre).cwiseQuotient(node.swingRadii);
  const Vector2d e(-node.swingRadii.x() * scaled.y(), node.swingRadii.y() * scaled.x());
  tangentLength_[node.dof] = e.norm();
  tangent_[node.dof] = e / tangentLength_[node.dof];
}

void DragDescent::chooseActiveSet() {
  anyFixedMoves_ = false;
  for (const TreeNode& node : tree_.nodes()) {
    const double* c = pose_.coordinates.data() + node.coordinate;
    int k = node.dof;
    if (node.motion == TreeMotion::FreeBall) {
      state_[k] = state_[k + 1] = state_[k + 2] = DofState::Free;
      continue;
    }
    if (node.motion == TreeMotion::LimitedBall) {
      state_[k] = state_[k + 1] = DofState::Free;
      if (onCone(node, c)) {
        setConeTangent(node, c);
        const Vector2d outward(tangent_[k].y(), -tangent_[k].x());
        if (stays_[k] || outward.dot(Vector2d(g_[k], g_[k + 1])) < 0.0) {
          state_[k] = DofState::AlongCone;
          state_[k + 1] = DofState::ConePartner;
        }
      }
      c += 2;
      k += 2;
    }
    const bool atLower = *c <= node.lower, atUpper = *c >= node.upper;
    const bool pushed = (atLower && g_[k] > 0.0) || (atUpper && g_[k] < 0.0);
    state_[k] = pushed || (atLower && atUpper) || (stays_[k] && (atLower || atUpper)) ? DofState::Fixed
                                                                                      : DofState::Free;
    value_[k] = 0.0;
  }
}

/// Which dofs on their limits to leave there in the next step although its gradient may point inwards: those
/// that the model at the end of this step still presses outwards (the sign of the limit's multiplier).
void DragDescent::rememberActiveSet() {
  for (const TreeNode& node : tree_.nodes()) {
    if (node.motion == TreeMotion::FreeBall) continue;
    const double* c = pose_.coordinates.data() + node.coordinate;
    int k = node.dof;
    if (node.motion == TreeMotion::LimitedBall) {
      stays_[k] = 0;
      if (state_[k] == DofState::AlongCone) {
        const Vector2d outward(tangent_[k].y(), -tangent_[k].x());
        const Vector2d slope(g_[k] + modelSlope(k), g_[k + 1] + modelSlope(k + 1));
        stays_[k] = outward.dot(slope) < 0.0;
      } else if (state_[k] == DofState::Fixed) {
        stays_[k] = 1;  // the step ends on the cone
      }
      c += 2;
      k += 2;
    }
    stays_[k] = 0;
    if (state_[k] != DofState::Fixed) continue;
    const double slope = g_[k] + modelSlope(k);
    stays_[k] = *c + value_[k] <= node.lower ? slope > 0.0 : slope < 0.0;
  }
}

/// W <- factors of H + mu I with the fixed dofs taken out and cone swings reduced to their tangent; x_ <-
/// right side.
bool DragDescent::factorWithActiveSet(double mu) {
  W_.copyValues(H_);
  for (int k = 0; k < W_.size(); ++k) {
    W_.diagonal(k) += mu;
    x_[k] = -g_[k];
  }
  const int n = tree_.dofCount(), packs = (rows_ + 3) / 4;
  if (rows_ > 0) V_.assign(U_.begin(), U_.begin() + static_cast<std::ptrdiff_t>(packs) * 4 * n);
  for (const TreeNode& node : tree_.nodes()) {
    const int k = node.dof;
    if (state_[k] != DofState::AlongCone) continue;
    for (int p = 0; p < packs; ++p) {
      double* V = V_.data() + static_cast<std::ptrdiff_t>(p) * 4 * n + 4 * k;
      for (int i = 0; i < 4; ++i) {
        V[i] = tangent_[k][0] * V[i] + tangent_[k][1] * V[i + 4];
        V[i + 4] = 0.0;
      }
    }
    const Vector2d e = tangent_[k], g(g_[k], g_[k + 1]);
    double* first = W_.row(k);
    const double* second = W_.row(k + 1);
    const int depth = node.depth;
    const double along =
        e[0] * e[0] * first[depth] + 2.0 * e[0] * e[1] * second[depth] + e[1] * e[1] * second[depth + 1];
    for (int j = 0; j < depth; ++j) first[j] = e[0] * first[j] + e[1] * second[j];
    // Going straight on along the tangent leaves the ellipse; following it bends inwards with curvature r1 r2
    // / |tangent|^3, against the gradient's push along the outward normal.
    const Vector2d normal(e.y(), -e.x());
    const double push = -g.dot(normal), length = tangentLength_[k];
    first[depth] = along + std::max(0.0, push) * node.swingRadii.prod() / (length * length * length);
    for (int below = k + 2; below < W_.subtreeEnd(k); ++below) {
      double* entries = W_.row(below) + depth;
      entries[0] = e[0] * entries[0] + e[1] * entries[1];
      entries[1] = 0.0;
    }
    x_[k] = -e.dot(g);
    W_.isolate(k + 1);
    x_[k + 1] = 0.0;
  }
  if (anyFixedMoves_)
    for (int k = 0; k < W_.size(); ++k)
      if (state_[k] == DofState::Fixed && value_[k] != 0.0) W_.subtractColumn(k, value_[k], x_.data());
  held_.assign(rows_, 0.0);
  for (int p = 0; p < packs; ++p) {
    double* V = V_.data() + static_cast<std::ptrdiff_t>(p) * 4 * n;
    if (anyFixedMoves_) {
      Double4 moved = {};
      for (int k = 0; k < n; ++k)
        if (state_[k] == DofState::Fixed) moved += value_[k] * four(V + 4 * k);
      for (int i = 0; i < 4 && 4 * p + i < rows_; ++i)
        if (sign_[4 * p + i] == 0.0) held_[4 * p + i] = moved[i];
      for (int i = 0; i < 4 && 4 * p + i < rows_; ++i) moved[i] *= sign_[4 * p + i];
      for (int k = 0; k < n; ++k) {
        const Double4 product = four(V + 4 * k) * moved;
        x_[k] -= product[0] + product[1] + product[2] + product[3];
      }
    }
    for (int k = 0; k < n; ++k)
      if (state_[k] == DofState::Fixed) four(V + 4 * k) = Double4{};
  }
  for (int k = 0; k < W_.size(); ++k)
    if (state_[k] == DofState::Fixed) {
      W_.isolate(k);
      x_[k] = value_[k];
    } else if (state_[k] == DofState::ConePartner) {
      x_[k] = 0.0;
    }
  return W_.factor(smallestPivot) && (rows_ == 0 || factorRows());
}

/// Fixes the free dofs that the step, which will be cut to entries of size `reach`, carries across their
/// limits on those limits. True where there were any.
bool DragDescent::fixCrossing(double reach) {
  constexpr double tolerance = 1e-12;
  double largest = 0.0;
  for (const double entry : x_) largest = std::max(largest, std::abs(entry));
  const double share = largest > reach ? reach / largest : 1.0;
  bool any = false;
  for (const TreeNode& node : tree_.nodes()) {
    if (node.motion == TreeMotion::FreeBall) continue;
    const double* c = pose_.coordinates.data() + node.coordinate;
    int k = node.dof;
    if (node.motion == TreeMotion::LimitedBall) {
      if (state_[k] == DofState::Free) {
        const Vector2d target(c[0] + share * x_[k], c[1] + share * x_[k + 1]);
        const bool crosses =
            (target - node.swingCentre).cwiseQuotient(node.swingRadii).squaredNorm() > 1.0 + tolerance;
        if (crosses && onCone(node, c)) {
          setConeTangent(node, c);
          state_[k] = DofState::AlongCone;
          state_[k + 1] = DofState::ConePartner;
          any = true;
        } else if (crosses) {
          double moved[3] = {target.x(), target.y(), c[2]};
          GoalTree::project(node, moved);
          for (int j = 0; j < 2; ++j) {
            state_[k + j] = DofState::Fixed;
            value_[k + j] = (moved[j] - c[j]) / share;
          }
          any = anyFixedMoves_ = true;
        }
      }
      c += 2;
      k += 2;
    }
    if (state_[k] != DofState::Free) continue;
    const double moved = *c + share * x_[k], inside = std::clamp(moved, node.lower, node.upper);
    if (std::abs(moved - inside) > tolerance) {
      state_[k] = DofState::Fixed;
      value_[k] = (inside - *c) / share;
      any = true;
      anyFixedMoves_ = anyFixedMoves_ || value_[k] != 0.0;
    }
  }
  return any;
}

/// The step d_ within limits, and of the model along it: slope_ = g . d, curvature_ = d . (H + mu) d. False
/// on a bad pivot.
bool DragDescent::solve(double mu, double reach, StepOutcome& outcome) {
  constexpr int passes = 3;
  chooseActiveSet();
  for (int pass = 0;; ++pass) {
    ++outcome.factorisations;
    if (!factorWithActiveSet(mu)) return false;
    solveSystem(x_.data());
    if (pass == passes || !fixCrossing(reach)) break;
  }
  const int n = tree_.dofCount();
  std::copy(x_.begin(), x_.end(), d_.begin());
  // d in dofs: along the cone the first entry is the length along the tangent.
  for (int k = 0; k < n; ++k)
    if (state_[k] == DofState::AlongCone) {
      d_[k] = x_[k] * tangent_[k][0];
      d_[k + 1] = x_[k] * tangent_[k][1];
    }
  Ud_.assign(rows_, 0.0);
  for (int r = 0; r < rows_; ++r) {
    for (int k = 0; k < n; ++k) Ud_[r] += rowEntry(r, k) * d_[k];
    Ud_[r] *= sign_[r];
  }
  slope_ = 0.0;
  for (int k = 0; k < n; ++k) slope_ += g_[k] * d_[k];
  // On the free dofs (H + mu) d = -g, so d . (H + mu) d = -g . d but for those fixed at a value.
  curvature_ = -slope_;
  if (anyFixedMoves_)
    for (int k = 0; k < n; ++k)
      if (state_[k] == DofState::Fixed && value_[k] != 0.0) curvature_ += d_[k] * (modelSlope(k, mu) + g_[k]);
  return true;
}

/// trial_ <- pose_ moved by alpha d_, within limits.
void DragDescent::apply(double alpha) {
  for (const TreeNode& node : tree_.nodes()) {
    const double* from = pose_.coordinates.data() + node.coordinate;
    double* to = trial_.coordinates.data() + node.coordinate;
    const int k = node.dof;
    if (node.motion == TreeMotion::FreeBall) {
      const Quaterniond turned = Quaterniond(from[0], from[1], from[2], from[3]) *
                                 expRotation(alpha * Vector3d(d_[k], d_[k + 1], d_[k + 2]));
      const double scale = 1.0 / turned.norm();
      to[0] = scale * turned.w();
      to[1] = scale * turned.x();
      to[2] = scale * turned.y();
      to[3] = scale * turned.z();
      continue;
    }
    for (int j = 0; j < node.dofs(); ++j) to[j] = from[j] + alpha * d_[k + j];
    if (state_[k] == DofState::AlongCone) {  // along the ellipse itself
      const double angle = std::clamp(alpha * x_[k] / tangentLength_[k], -1.0, 1.0);
      const Vector2d scaled = (Vector2d(from[0], from[1]) - node.swingCentre).cwiseQuotient(node.swingRadii);
      const double sine = std::sin(angle), cosine = std::cos(angle);
      const Vector2d turned(cosine * scaled.x() - sine * scaled.y(), sine * scaled.x() + cosine * scaled.y());
      const Vector2d on = node.swingCentre + node.swingRadii.cwiseProduct(turned.normalized());
      to[0] = on.x();
      to[1] = on.y();
    }
    GoalTree::project(node, to);
  }
  tree_.place(trial_);
}

void DragDescent::moveFreely(const double* d) {
  chooseActiveSet();
  std::fill(state_.begin(), state_.end(), DofState::Free);
  for (const TreeNode& node : tree_.nodes()) {
    double* c = pose_.coordinates.data() + node.coordinate;
    if (node.motion == TreeMotion::FreeBall) {
      const Quaterniond turned =
          Quaterniond(c[0], c[1], c[2], c[3]) * expRotation({d[node.dof], d[node.dof + 1], d[node.dof + 2]});
      c[0] = turned.w();
      c[1] = turned.x();
      c[2] = turned.y();
      c[3] = turned.z();
    } else {
      for (int j = 0; j < node.dofs(); ++j) c[j] += d[node.dof + j];
    }
  }
  tree_.place(pose_);
}

double DragDescent::largestRotation(const TreePose& pose) const {
  double largest = 0.0, ofJoint = 0.0;
  int joint = -1;
  for (int i = 0; i < tree_.nodeCount(); ++i) {
    const TreeNode& node = tree_.node(i);
    if (node.joint != joint) ofJoint = 0.0;
    joint = node.joint;
    if (node.motion == TreeMotion::RotationAxis) {
      ofJoint += std::abs(pose.coordinates[node.coordinate] - anchor_.coordinates[node.coordinate]);
    } else if (node.motion >= TreeMotion::LimitedBall) {
      // angle = 4 asin(|a - b| / 2), which loses no precision where a and b are close
      const auto &a = pose.frames[i].q, &b = anchor_.frames[i].q;
      double same = 0.0, opposite = 0.0;
      for (int k = 0; k < 4; ++k) {
        same += (a[k] - b[k]) * (a[k] - b[k]);
        opposite += (a[k] + b[k]) * (a[k] + b[k]);
      }
      const double chord = std::min(same, opposite);
      ofJoint += chord < 0.02 ? 2.0 * std::sqrt(chord) * (1.0 + chord / 24.0)
                              : 4.0 * std::asin(std::min(1.0, 0.5 * std::sqrt(chord)));
    }
    largest = std::max(largest, ofJoint);
  }
  return largest;
}

// ---- iteration
// ----------------------------------------------------------------------------------------------------

/// Solves and takes one step of the assembled model; raises mu until the objective falls. False on a bad
/// pivot.
bool DragDescent::descend(const Settings& settings, double& mu, StepOutcome& outcome) {
  constexpr int retries = 3;
  // What the clamp and the budget will leave of a long step.
  const double reach =
      std::min(settings.largestStep, 1.2 * (settings.rotationBudget - largestRotation(pose_)) + 0.02);
  for (int attempt = 0; attempt <= retries; ++attempt, mu = std::max(4.0 * mu, startingDamping())) {
    if (!solve(mu, reach, outcome)) return false;
    outcome.damping = mu;
    outcome.budgetSpent = false;
    double largest = 0.0, squared = 0.0;
    for (const double entry : d_) {
      largest = std::max(largest, std::abs(entry));
      squared += entry * entry;
    }
    outcome.step = largest;
    if (!(largest >= settings.smallestStep)) return std::isfinite(largest);

    double alpha = std::min(1.0, settings.largestStep / largest);
    apply(alpha);
    ++outcome.placements;
    if (settings.rotationBudget < 1e9) {
      const double before = largestRotation(pose_);
      for (int cut = 0; cut < 6; ++cut) {
        const double after = largestRotation(trial_);
        if (after <= settings.rotationBudget) break;
        outcome.budgetSpent = true;
        const double share = (settings.rotationBudget - before) / (after - before);
        alpha *= cut < 4 && share > 0.0 ? std::min(0.999 * share, 0.95) : 0.0;
        apply(alpha);
        ++outcome.placements;
      }
    }
    const double reached = objective(settings, trial_);
    const double predicted = -alpha * slope_ - 0.5 * alpha * alpha * (curvature_ - mu * squared);
    gain_ = predicted > 0.0 ? (cost_ - reached) / predicted : -1.0;
    if (reached <= cost_ + armijo * alpha * slope_ && slope_ <= 0.0) {
      outcome.moved = alpha > 0.0;
      outcome.step = alpha * largest;
      cost_ = reached;
      rememberActiveSet();
      std::swap(pose_, trial_);
      if (gain_ > 0.5)
        mu = mu > 1e-12 ? mu / 5.0 : 0.0;
      else if (gain_ < 0.1)
        mu = std::max(4.0 * mu, startingDamping());
      return true;
    }
    gain_ = -1.0;
    if (attempt > 0)
      std::fill(stays_.begin(), stays_.end(), 0);  // what was remembered may be what bars the way
  }
  return true;
}

StepOutcome DragDescent::step(const Settings& settings) {
  StepOutcome outcome;
  if (tree_.dofCount() == 0) return outcome;
  gather();
  const double asked = goalCost(pose_);
  cost_ = asked + regulariser(settings, pose_);
  if (settings.passing) {
    double mu = 1e-6;
    assemble(settings, StepKind::GaussNewton);
    descend(settings, mu, outcome);
    return outcome;
  }
  if (muGaussNewton_ == 0.0 && muExact_ == 0.0) muGaussNewton_ = muExact_ = startingDamping();

  const bool near = std::sqrt(2.0 * asked) < settings.near;
  // A heavily damped Gauss-Newton step keeps its promise by being short, which is no merit.
  const bool good = lastGaussNewtonGain_ > settings.goodGain && muGaussNewton_ < settings.goodDamping;
  bool exact = settings.exact && !near && !good;
  if (forcedExact_ > 0) {
    --forcedExact_;
    exact = settings.exact;
  }
  if (exact) {
    outcome.kind = StepKind::ExactHessian;
    assemble(settings, StepKind::ExactHessian);
    if (descend(settings, muExact_, outcome)) return outcome;
    for (int raise = 0; forcedExact_ > 0 && raise < 5; ++raise) {
      muExact_ = std::max(4.0 * muExact_, startingDamping());
      if (descend(settings, muExact_, outcome)) return outcome;
    }
  }
  outcome.kind = StepKind::GaussNewton;
  assemble(settings, StepKind::GaussNewton);
  bool definite = descend(settings, muGaussNewton_, outcome);
  // What blocks alone hold is no part of H: without posture it is damped until it is definite.
  for (int raise = 0; !definite && !blocks_.empty() && raise < 5; ++raise) {
    muGaussNewton_ = std::max(4.0 * muGaussNewton_, startingDamping());
    definite = descend(settings, muGaussNewton_, outcome);
  }
  if (!outcome.budgetSpent)
    lastGaussNewtonGain_ = outcome.moved ? gain_ : -1.0;  // a step cut short says nothing
  if (exact && gain_ < settings.poorGain) forcedExact_ = settings.raisedSteps;
  return outcome;
}

}  // namespace gelenk
