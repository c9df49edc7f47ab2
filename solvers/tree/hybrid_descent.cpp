#include "solvers/tree/hybrid_descent.h"

#include <algorithm>
#include <cmath>

#include "kinematics/rotation.h"

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

/// Hessian of 1/2 |log R|^2 for R <- R exp(d): n n^T + (angle/2) cot(angle/2) (I - n n^T). Positive below a
/// half turn.
Matrix3d squaredAngleHessian(const Vector3d& log) {
  const double angle = log.norm();
  const double across = angle < 1e-4 ? 1.0 - angle * angle / 12.0 : 0.5 * angle / std::tan(0.5 * angle);
  if (angle < 1e-12) return Matrix3d::Identity();
  const Vector3d n = log / angle;
  return across * Matrix3d::Identity() + (1.0 - across) * n * n.transpose();
}

}  // namespace

HybridDescent::HybridDescent(const Skeleton& skeleton, double unit, std::vector<double> stiffness,
                             const VectorXd& rest)
    : tree_(skeleton, unit), stiffnessOfDof_(std::move(stiffness)), rest_(rest) {}

void HybridDescent::build(std::span<const int> joints, const Vector3d& origin) {
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
    for (int k = 0; k < node.dofs(); ++k) s_[node.dof + k] = stiffnessOfDof_[v + k];
  }
  points_.clear();
  tree_.load(rest_, trial_);
  restCoordinates_ = trial_.coordinates;
  forget();
}

void HybridDescent::forget() {
  muGaussNewton_ = muExact_ = 0.0;
  lastGaussNewtonGain_ = 1.0;
  forcedExact_ = 0;
}

void HybridDescent::load(const VectorXd& q) {
  tree_.load(q, pose_);
  trial_ = pose_;
  anchor();
}

double HybridDescent::residual() const { return std::sqrt(2.0 * tree_.cost(pose_, points_)); }

double HybridDescent::startingDamping() const { return std::max(1e-3, 0.1 * std::sqrt(cost_)); }

double HybridDescent::regulariser(const Settings& settings, const TreePose& pose) const {
  double posture = 0.0, change = 0.0;
  for (const TreeNode& node : tree_.nodes()) {
    const double* c = pose.coordinates.data() + node.coordinate;
    const double* rest = restCoordinates_.data() + node.coordinate;
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

double HybridDescent::objective(const Settings& settings, const TreePose& pose) const {
  return tree_.cost(pose, points_) + regulariser(settings, pose);
}

void HybridDescent::addRegulariser(const Settings& settings) {
  const double lambda = settings.lambda, kappa = settings.kappa;
  for (const TreeNode& node : tree_.nodes()) {
    const double* c = pose_.coordinates.data() + node.coordinate;
    const double* rest = restCoordinates_.data() + node.coordinate;
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

void HybridDescent::assemble(const Settings& settings, StepKind kind) {
  tree_.gradientAndHessian(pose_, kind == StepKind::ExactHessian ? 1.0 : 0.0, g_.data(), H_);
  addRegulariser(settings);
}

void HybridDescent::derivatives(const Settings& settings, double beta, double* gradient, TreeMatrix& H) {
  tree_.gather(pose_, points_);
  assemble(settings, beta != 0.0 ? StepKind::ExactHessian : StepKind::GaussNewton);
  std::copy(g_.begin(), g_.end(), gradient);
  H.copyValues(H_);
}

// ---- limits
// -------------------------------------------------------------------------------------------------------------

/// Where the swing at c stands on its cone: the unit tangent of the ellipse and its length by the ellipse's
/// angle.
void HybridDescent::setConeTangent(const TreeNode& node, const double* c) {
  const Vector2d scaled = (Vector2d(c[0], c[1]) - node.swingCentre).cwiseQuotient(node.swingRadii);
  const Vector2d e(-node.swingRadii.x() * scaled.y(), node.swingRadii.y() * scaled.x());
  tangentLength_[node.dof] = e.norm();
  tangent_[node.dof] = e / tangentLength_[node.dof];
}

void HybridDescent::chooseActiveSet() {
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
void HybridDescent::rememberActiveSet() {
  for (const TreeNode& node : tree_.nodes()) {
    if (node.motion == TreeMotion::FreeBall) continue;
    const double* c = pose_.coordinates.data() + node.coordinate;
    int k = node.dof;
    if (node.motion == TreeMotion::LimitedBall) {
      stays_[k] = 0;
      if (state_[k] == DofState::AlongCone) {
        const Vector2d outward(tangent_[k].y(), -tangent_[k].x());
        const Vector2d slope(g_[k] + H_.rowTimes(k, d_.data()), g_[k + 1] + H_.rowTimes(k + 1, d_.data()));
        stays_[k] = outward.dot(slope) < 0.0;
      } else if (state_[k] == DofState::Fixed) {
        stays_[k] = 1;  // the step ends on the cone
      }
      c += 2;
      k += 2;
    }
    stays_[k] = 0;
    if (state_[k] != DofState::Fixed) continue;
    const double slope = g_[k] + H_.rowTimes(k, d_.data());
    stays_[k] = *c + value_[k] <= node.lower ? slope > 0.0 : slope < 0.0;
  }
}

/// W <- factors of H + mu I with the fixed dofs taken out and cone swings reduced to their tangent; x_ <-
/// right side.
bool HybridDescent::factorWithActiveSet(double mu) {
  W_.copyValues(H_);
  for (int k = 0; k < W_.size(); ++k) {
    W_.diagonal(k) += mu;
    x_[k] = -g_[k];
  }
  for (const TreeNode& node : tree_.nodes()) {
    const int k = node.dof;
    if (state_[k] != DofState::AlongCone) continue;
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
  for (int k = 0; k < W_.size(); ++k)
    if (state_[k] == DofState::Fixed) {
      W_.isolate(k);
      x_[k] = value_[k];
    } else if (state_[k] == DofState::ConePartner) {
      x_[k] = 0.0;
    }
  return W_.factor(smallestPivot);
}

/// Fixes the free dofs that the step, which will be cut to entries of size `reach`, carries across their
/// limits on those limits. True where there were any.
bool HybridDescent::fixCrossing(double reach) {
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
bool HybridDescent::solve(double mu, double reach, StepOutcome& outcome) {
  constexpr int passes = 3;
  chooseActiveSet();
  for (int pass = 0;; ++pass) {
    ++outcome.factorisations;
    if (!factorWithActiveSet(mu)) return false;
    W_.solve(x_.data());
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
  slope_ = 0.0;
  for (int k = 0; k < n; ++k) slope_ += g_[k] * d_[k];
  // On the free dofs (H + mu) d = -g, so d . (H + mu) d = -g . d but for those fixed at a value.
  curvature_ = -slope_;
  if (anyFixedMoves_)
    for (int k = 0; k < n; ++k)
      if (state_[k] == DofState::Fixed && value_[k] != 0.0)
        curvature_ += d_[k] * (H_.rowTimes(k, d_.data()) + mu * d_[k] + g_[k]);
  return true;
}

/// trial_ <- pose_ moved by alpha d_, within limits.
void HybridDescent::apply(double alpha) {
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

void HybridDescent::moveFreely(const double* d) {
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

double HybridDescent::largestRotation(const TreePose& pose) const {
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
// ----------------------------------------------------------------------------------------------------------

/// Solves and takes one step of the assembled model; raises mu until the objective falls. False on a bad
/// pivot.
bool HybridDescent::descend(const Settings& settings, double& mu, StepOutcome& outcome) {
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

StepOutcome HybridDescent::step(const Settings& settings) {
  StepOutcome outcome;
  if (tree_.dofCount() == 0) return outcome;
  tree_.gather(pose_, points_);
  const double goalCost = tree_.cost(pose_, points_);
  cost_ = goalCost + regulariser(settings, pose_);
  if (settings.passing) {
    double mu = 1e-6;
    assemble(settings, StepKind::GaussNewton);
    descend(settings, mu, outcome);
    return outcome;
  }
  if (muGaussNewton_ == 0.0 && muExact_ == 0.0) muGaussNewton_ = muExact_ = startingDamping();

  const bool near = std::sqrt(2.0 * goalCost) < 0.03;
  // A heavily damped Gauss-Newton step keeps its promise by being short, which is no merit.
  const bool good = lastGaussNewtonGain_ > 0.75 && muGaussNewton_ < 0.01;
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
  descend(settings, muGaussNewton_, outcome);
  if (!outcome.budgetSpent)
    lastGaussNewtonGain_ = outcome.moved ? gain_ : -1.0;  // a step cut short says nothing
  if (exact && gain_ < 0.25) forcedExact_ = 8;
  return outcome;
}

}  // namespace gelenk
