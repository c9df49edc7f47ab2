#include "solvers/tree/goal_tree.h"

#include <algorithm>
#include <cmath>

#include "kinematics/limits.h"
#include "kinematics/rotation.h"
#include "solvers/serial/simd.h"

namespace gelenk {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// The swing's coordinates have a pole at a half turn (w = 0): stay below 150 degrees, |c| = 2 sin(75 deg).
constexpr double largestSwing = 1.9318516525781366;

/// The limit's ellipse where it stays inside |c| <= largestSwing, else the largest one of its shape about its
/// centre that does.
void setSwingLimit(const BallLimit& limit, TreeNode& node) {
  node.swingCentre = limit.swingCentre;
  node.swingRadii = limit.swingRadii;
  const double beyond = node.swingCentre.norm() / (0.99 * largestSwing);
  if (beyond > 1.0) node.swingCentre /= beyond;
  double scale = 1.0;
  const bool inside = node.swingCentre.norm() + node.swingRadii.maxCoeff() <= largestSwing;
  for (int k = 0; !inside && k < 360; ++k) {  // |centre + s r(angle)| = largestSwing, solved for s
    const double angle = k * M_PI / 180.0;
    const Vector2d r = node.swingRadii.cwiseProduct(Vector2d(std::cos(angle), std::sin(angle)));
    const double a = r.squaredNorm(), b = r.dot(node.swingCentre);
    const double c = node.swingCentre.squaredNorm() - largestSwing * largestSwing;
    scale = std::min(scale, (-b + std::sqrt(b * b - a * c)) / a);
  }
  node.swingRadii *= scale;
  const bool wholeTurn = limit.twistLower <= -M_PI && limit.twistUpper >= M_PI;
  node.lower = wholeTurn ? -unlimited : std::max(limit.twistLower, -M_PI);
  node.upper = wholeTurn ? unlimited : std::min(limit.twistUpper, M_PI);
}

/// R <- R * rotation about the coordinate axis k by the angle with this sine and cosine.
GELENK_INLINE void turnColumns(Matrix3d& R, int k, double s, double c) {
  const int a = k == 2 ? 0 : k + 1, b = k == 0 ? 2 : k - 1;
  const Vector3d old = R.col(a);
  R.col(a) = c * old + s * R.col(b);
  R.col(b) = c * R.col(b) - s * old;
}

/// Rotation of the unit quaternion (w, x, y, z).
GELENK_INLINE Matrix3d rotationMatrix(const std::array<double, 4>& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Matrix3d R;
  R << 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),  //
      2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),   //
      2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y);
  return R;
}

GELENK_INLINE double swingCosine(double x, double y) {
  return std::sqrt(std::max(0.05, 1.0 - x * x - y * y));
}

}  // namespace

GoalTree::GoalTree(const Skeleton& skeleton, double unit) : skeleton_(&skeleton), unit_(unit) {
  nodes_.reserve(skeleton.nv() + skeleton.followers().size());
  dofParent_.reserve(skeleton.nv());
  order_.reserve(skeleton.jointCount());
  onPath_.resize(skeleton.jointCount());
  carrier_.resize(skeleton.jointCount());
  carrierFromJoint_.resize(skeleton.jointCount());
}

void GoalTree::build(std::span<const int> joints, const Vector3d& origin) {
  origin_ = origin;
  std::fill(onPath_.begin(), onPath_.end(), 0);
  for (int joint : joints)
    for (; joint >= 0 && !onPath_[joint]; joint = skeleton_->parent(joint)) onPath_[joint] = 1;

  nodes_.clear();
  dofParent_.clear();
  dofs_ = coordinates_ = 0;
  int deepest = 1;
  order_.clear();
  if (onPath_[0]) order_.push_back(0);
  while (!order_.empty()) {  // depth first: a joint's whole subtree before its sibling
    const int i = order_.back();
    order_.pop_back();
    for (const int child : skeleton_->children(i))
      if (onPath_[child]) order_.push_back(child);

    const Joint& joint = skeleton_->joint(i);
    int parent = joint.parent < 0 ? -1 : carrier_[joint.parent];
    Isometry3d offset = joint.parentFromZero;
    offset.translation() /= unit_;
    if (joint.parent >= 0)
      offset = carrierFromJoint_[joint.parent] * offset;
    else
      offset.translation() = toTree(joint.parentFromZero.translation());

    const int axes = static_cast<int>(joint.axes.size());
    for (int k = 0; k < axes + (joint.ball ? 1 : 0); ++k) {
      const TreeNode& node = addNode(i, k, parent, offset);
      deepest = std::max(deepest, node.depth + node.dofs());
      parent = static_cast<int>(nodes_.size()) - 1;
      offset = Isometry3d::Identity();
    }
    carrier_[i] = parent;
    carrierFromJoint_[i] = offset;
  }
  addCouplings();
  sums_.resize(nodes_.size());
  below_.resize(nodes_.size());
  twistOfDof_.resize(dofs_);
  twistStride_ = TreeMatrix::padded(deepest);
  twists_.assign(6 * twistStride_, 0.0);
}

/// The joint's axis k, or its ball. offset: of the motion's zero from the parent node.
TreeNode& GoalTree::addNode(int i, int k, int parent, const Isometry3d& offset) {
  const Joint& joint = skeleton_->joint(i);
  TreeNode& node = nodes_.emplace_back();
  node.parent = parent;
  node.joint = i;
  node.qIndex = skeleton_->qIndex(i) + k;
  node.dof = dofs_;
  node.coordinate = coordinates_;
  node.depth = parent < 0 ? 0 : nodes_[parent].depth + nodes_[parent].dofs();
  node.offsetRotation = offset.linear();
  node.offset = offset.translation();
  node.offsetTurns = !node.offsetRotation.isIdentity(0.0);
  node.offsetIsIdentity = parent >= 0 && !node.offsetTurns && node.offset.isZero(0.0);
  node.coordinateAxis = -1;
  node.lower = -unlimited;
  node.upper = unlimited;
  if (k < static_cast<int>(joint.axes.size())) {
    const AxisDof& dof = joint.axes[k];
    const bool turns = dof.kind == AxisDof::Kind::Rotation;
    node.motion = turns ? TreeMotion::RotationAxis : TreeMotion::TranslationAxis;
    node.axis = dof.axis;
    for (int a = 0; a < 3; ++a)
      if (dof.axis == Vector3d::Unit(a)) node.coordinateAxis = a;
    if (!joint.coupling) {  // else its source's range holds its own
      node.lower = turns ? dof.lower : dof.lower / unit_;
      node.upper = turns ? dof.upper : dof.upper / unit_;
    }
  } else if (joint.ballLimit) {
    node.motion = TreeMotion::LimitedBall;
    setSwingLimit(*joint.ballLimit, node);
  } else {
    node.motion = TreeMotion::FreeBall;
  }
  for (int d = 0; d < node.dofs(); ++d)
    dofParent_.push_back(d > 0        ? dofs_ + d - 1
                         : parent < 0 ? -1
                                      : nodes_[parent].dof + nodes_[parent].dofs() - 1);
  dofs_ += node.dofs();
  coordinates_ += node.coordinates();
  return node;
}

void GoalTree::addCouplings() {
  couplings_.clear();
  const auto nodeOf = [&](int joint) {
    int at = nodeCount() - 1;
    while (at >= 0 && nodes_[at].joint != joint) --at;
    return at;
  };
  const auto metres = [&](int joint) {  // a unit of its coordinate, radians for turns
    return skeleton_->joint(joint).axes[0].kind == AxisDof::Kind::Translation ? unit_ : 1.0;
  };
  for (const int i : skeleton_->followers()) {
    const int follower = nodeOf(i);
    if (follower < 0) continue;
    const Coupling& c = *skeleton_->joint(i).coupling;
    int source = nodeOf(c.source);
    if (source < 0) {  // none of the goals hangs on its place
      addNode(c.source, 0, -1, Isometry3d::Identity());
      source = nodeCount() - 1;
    }
    couplings_.push_back({.follower = follower,
                          .source = source,
                          .multiplier = c.multiplier * metres(c.source) / metres(i),
                          .offset = c.offset / metres(i)});
  }
}

bool GoalTree::project(const TreeNode& node, double* c) {
  bool moved = false;
  if (node.motion == TreeMotion::LimitedBall) {
    Vector2d swing(c[0], c[1]);
    if (intoSwing(node.swingCentre, node.swingRadii, swing)) {
      c[0] = swing.x();
      c[1] = swing.y();
      moved = true;
    }
    c += 2;
  } else if (node.motion == TreeMotion::FreeBall) {
    return false;
  }
  if (*c < node.lower || *c > node.upper) {
    *c = std::clamp(*c, node.lower, node.upper);
    moved = true;
  }
  return moved;
}

Vector3d GoalTree::toCarrier(int joint, const Vector3d& pointInJoint) const {
  return carrierFromJoint_[joint] * Vector3d(pointInJoint / unit_);
}

void GoalTree::load(const VectorXd& q, TreePose& pose) const {
  pose.coordinates.resize(coordinates_);
  pose.frames.resize(nodes_.size());
  for (const TreeNode& node : nodes_) {
    double* c = pose.coordinates.data() + node.coordinate;
    const double* value = q.data() + node.qIndex;
    switch (node.motion) {
      case TreeMotion::RotationAxis: c[0] = std::clamp(value[0], node.lower, node.upper); break;
      case TreeMotion::TranslationAxis: c[0] = std::clamp(value[0] / unit_, node.lower, node.upper); break;
      case TreeMotion::LimitedBall: {
        const Vector3d read =
            swingTwistCoordinates(Quaterniond(value[0], value[1], value[2], value[3]).normalized());
        std::copy_n(read.data(), 3, c);
        project(node, c);
        break;
      }
      case TreeMotion::FreeBall: {
        const double scale = 1.0 / std::sqrt(value[0] * value[0] + value[1] * value[1] + value[2] * value[2] +
                                             value[3] * value[3]);
        for (int k = 0; k < 4; ++k) c[k] = scale * value[k];
        break;
      }
    }
  }
  place(pose);
}

void GoalTree::store(const TreePose& pose, VectorXd& q) const {
  for (int i = 0; i < nodeCount(); ++i) {
    const TreeNode& node = nodes_[i];
    const double* c = pose.coordinates.data() + node.coordinate;
    double* value = q.data() + node.qIndex;
    switch (node.motion) {
      case TreeMotion::RotationAxis: value[0] = c[0]; break;
      // The division by the unit may round a displacement past its limit in its last bit.
      case TreeMotion::TranslationAxis: {
        const AxisDof& dof = skeleton_->joint(node.joint).axes[node.qIndex - skeleton_->qIndex(node.joint)];
        value[0] = std::clamp(unit_ * c[0], dof.lower, dof.upper);
        break;
      }
      case TreeMotion::LimitedBall:
      case TreeMotion::FreeBall: std::copy_n(pose.frames[i].q.data(), 4, value); break;
    }
  }
  skeleton_->couple(q);
}

void GoalTree::place(TreePose& pose) const {
  for (const TreeCoupling& c : couplings_)
    pose.coordinates[nodes_[c.follower].coordinate] =
        c.multiplier * pose.coordinates[nodes_[c.source].coordinate] + c.offset;
  for (int i = 0; i < nodeCount(); ++i) {
    const TreeNode& node = nodes_[i];
    TreePose::NodeFrame& frame = pose.frames[i];
    if (node.parent < 0) {
      frame.R = node.offsetRotation;
      frame.p = node.offset;
    } else {
      const TreePose::NodeFrame& parent = pose.frames[node.parent];
      if (node.offsetTurns)
        frame.R.noalias() = parent.R * node.offsetRotation;
      else
        frame.R = parent.R;
      frame.p = parent.p;
      if (!node.offsetIsIdentity) frame.p.noalias() += parent.R * node.offset;
    }
    const double* c = pose.coordinates.data() + node.coordinate;
    switch (node.motion) {
      case TreeMotion::RotationAxis: {
        const double sine = std::sin(c[0]), cosine = std::cos(c[0]);
        if (node.coordinateAxis >= 0) {
          turnColumns(frame.R, node.coordinateAxis, sine, cosine);
        } else {  // Rodrigues on the columns: R (I + s [a]x + (1 - c) [a]x^2)
          const Vector3d a = frame.R * node.axis;
          for (int k = 0; k < 3; ++k) {
            const Vector3d column = frame.R.col(k);
            frame.R.col(k) = cosine * column + sine * a.cross(column) + (1.0 - cosine) * node.axis[k] * a;
          }
        }
        break;
      }
      case TreeMotion::TranslationAxis: frame.p.noalias() += frame.R * (c[0] * node.axis); break;
      case TreeMotion::LimitedBall: {
        const double x = 0.5 * c[0], y = 0.5 * c[1];
        const double w = swingCosine(x, y), sine = std::sin(0.5 * c[2]), cosine = std::cos(0.5 * c[2]);
        frame.q = {w * cosine, x * cosine + y * sine, y * cosine - x * sine, w * sine};  // swing * twist
        frame.zero = frame.R;
        frame.R.noalias() = frame.zero * rotationMatrix(frame.q);
        break;
      }
      case TreeMotion::FreeBall:
        frame.q = {c[0], c[1], c[2], c[3]};
        frame.zero = frame.R;
        frame.R.noalias() = frame.zero * rotationMatrix(frame.q);
        break;
    }
  }
}

Vector3d GoalTree::at(const TreePose& pose, const TreePoint& point) const {
  if (point.node < 0) return point.local;
  const TreePose::NodeFrame& frame = pose.frames[point.node];
  Vector3d x = frame.R * point.local;
  if (!point.direction) x += frame.p;
  return x;
}

double GoalTree::cost(const TreePose& pose, std::span<const TreePoint> points) const {
  double sum = 0.0;
  for (const TreePoint& point : points) {
    const double squared = (point.target - at(pose, point)).squaredNorm(), cut = point.cut;
    sum += point.weight * (squared <= cut * cut ? 0.5 * squared : cut * (std::sqrt(squared) - 0.5 * cut));
  }
  return sum;
}

Vector3d GoalTree::at(const TreePose& pose, const TreeSum& sum, std::span<const TreeShare> shares) const {
  Vector3d y = sum.constant;
  for (const TreeShare& part : shares.subspan(sum.first, sum.count)) {
    const TreePose::NodeFrame& frame = pose.frames[part.node];
    Vector3d x = frame.R * part.local;
    if (!part.direction) x += frame.p;
    y += part.share * x;
  }
  return y;
}

void GoalTree::gather(const TreePose& pose, std::span<const TreePoint> points) {
  beginGather();
  addPoints(pose, points);
  endGather();
}

void GoalTree::beginGather() {
  for (Sums& s : sums_) s = {0.0, Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), {}, Matrix3d::Zero()};
}

void GoalTree::addForce(const TreePose& pose, const TreeSum& sum, std::span<const TreeShare> shares,
                        const Vector3d& force) {
  for (const TreeShare& part : shares.subspan(sum.first, sum.count)) {
    const TreePose::NodeFrame& frame = pose.frames[part.node];
    Sums& s = sums_[part.node];
    const Vector3d f = part.share * force;
    Vector3d p = frame.R * part.local;
    if (!part.direction) {
      p += frame.p;
      s.F += f;
    }
    s.T += p.cross(f);
    s.P += p * f.transpose();
  }
}

void GoalTree::slopeOf(const TreePose& pose, const TreeSum& sum, std::span<const TreeShare> shares,
                       Vector3d* slope) {
  std::fill(below_.begin(), below_.end(), Eigen::Vector4d::Zero());
  for (const TreeShare& part : shares.subspan(sum.first, sum.count)) {
    const TreePose::NodeFrame& frame = pose.frames[part.node];
    Eigen::Vector4d& b = below_[part.node];
    b.head<3>() += part.share * (frame.R * part.local);
    if (part.direction) continue;
    b.head<3>() += part.share * frame.p;
    b[3] += part.share;
  }
  for (int i = nodeCount() - 1; i >= 0; --i) {
    const TreeNode& node = nodes_[i];
    if (node.parent >= 0) below_[node.parent] += below_[i];
    const Vector3d moment = below_[i].head<3>();
    for (int k = node.dof; k < node.dof + node.dofs(); ++k)
      slope[k] = below_[i][3] * twistOfDof_[k][1] + twistOfDof_[k][0].cross(moment);
  }
}

void GoalTree::addPoints(const TreePose& pose, std::span<const TreePoint> points) {
  for (const TreePoint& point : points) {
    if (point.node < 0) continue;
    Sums& s = sums_[point.node];
    const Vector3d p = at(pose, point), e = point.target - p;
    // Beyond the cut the quadratic that touches the cost there and lies above it everywhere.
    const double squared = e.squaredNorm();
    const double weight =
        squared <= point.cut * point.cut ? point.weight : point.weight * point.cut / std::sqrt(squared);
    const Vector3d f = weight * e, wp = weight * p;
    if (!point.direction) {  // a direction only turns: no mass, no force, but inertia and moment
      s.m += weight;
      s.h += wp;
      s.F += f;
    }
    s.T += p.cross(f);
    s.P += p * f.transpose();
    s.A[0] += wp[0] * p[0];
    s.A[1] += wp[1] * p[1];
    s.A[2] += wp[2] * p[2];
    s.A[3] += wp[0] * p[1];
    s.A[4] += wp[0] * p[2];
    s.A[5] += wp[1] * p[2];
  }
}

void GoalTree::endGather() {
  for (int i = nodeCount() - 1; i >= 0; --i) {
    if (nodes_[i].parent < 0) continue;
    Sums& above = sums_[nodes_[i].parent];
    const Sums& s = sums_[i];
    above.m += s.m;
    above.h += s.h;
    above.F += s.F;
    above.T += s.T;
    for (int k = 0; k < 6; ++k) above.A[k] += s.A[k];
    above.P += s.P;
  }
}

namespace {

/// entries[0 .. length) = w . M + v . N for the twists of the path; length is a multiple of four.
GELENK_INLINE void rowOfPath(const double* __restrict twists, int stride, const Vector3d& M,
                             const Vector3d& N, int length, double* __restrict entries) {
  const double m0 = M[0], m1 = M[1], m2 = M[2], n0 = N[0], n1 = N[1], n2 = N[2];
  for (int j = 0; j < length; j += 4) {
    const double* t = twists + j;
    Double4 sum = m0 * four(t) + m1 * four(t + stride);
    sum += m2 * four(t + 2 * stride) + n0 * four(t + 3 * stride);
    sum += n1 * four(t + 4 * stride) + n2 * four(t + 5 * stride);
    four(entries + j) = sum;
  }
}

}  // namespace

GELENK_SIMD_CLONES
void GoalTree::gradientAndHessian(const TreePose& pose, double beta, double* gradient, TreeMatrix& H) {
  const int stride = twistStride_;
  double* const path = twists_.data();
  for (int i = 0; i < nodeCount(); ++i) {
    const TreeNode& node = nodes_[i];
    const TreePose::NodeFrame& frame = pose.frames[i];
    const Sums& s = sums_[i];
    const Vector3d& p = frame.p;

    Vector3d w[3];
    Vector3d dw11 = Vector3d::Zero(), dw22 = Vector3d::Zero(),
             dw12 = Vector3d::Zero();  // of the swing: dw1/dc1, dw2/dc2, dw1/dc2
    const int dofs = node.dofs();
    switch (node.motion) {
      case TreeMotion::TranslationAxis: break;
      case TreeMotion::RotationAxis:
        if (node.coordinateAxis >= 0)
          w[0] = frame.R.col(node.coordinateAxis);
        else
          w[0].noalias() = frame.R * node.axis;
        break;
      case TreeMotion::LimitedBall: {
        const double* c = pose.coordinates.data() + node.coordinate;
        const double x = 0.5 * c[0], y = 0.5 * c[1], cosine = swingCosine(x, y), r = 1.0 / cosine,
                     r3 = r * r * r;
        w[0].noalias() = frame.zero * Vector3d(cosine + x * x * r, x * y * r, -y);
        w[1].noalias() = frame.zero * Vector3d(x * y * r, cosine + y * y * r, x);
        w[2] = frame.R.col(2);
        dw11.noalias() =
            frame.zero * Vector3d(0.5 * (x * r + x * x * x * r3), 0.5 * (y * r + x * x * y * r3), 0.0);
        dw22.noalias() =
            frame.zero * Vector3d(0.5 * (x * r + x * y * y * r3), 0.5 * (y * r + y * y * y * r3), 0.0);
        dw12.noalias() =
            frame.zero * Vector3d(0.5 * (-y * r + x * x * y * r3), 0.5 * (x * r + x * y * y * r3), -0.5);
        break;
      }
      case TreeMotion::FreeBall:
        for (int k = 0; k < 3; ++k) w[k] = frame.R.col(k);
        break;
    }

    const double traceA = s.A[0] + s.A[1] + s.A[2], traceP = s.P.trace();
    for (int d = 0; d < dofs; ++d) {
      const int k = node.dof + d, depth = node.depth + d;
      Vector3d M, N;
      double* t = path + depth;
      if (node.motion == TreeMotion::TranslationAxis) {
        const Vector3d v = frame.R * node.axis;
        gradient[k] = -v.dot(s.F);
        twistOfDof_[k] = {Vector3d::Zero(), v};
        M = s.h.cross(v) + beta * s.F.cross(v);
        N = s.m * v;
        for (int a = 0; a < 3; ++a) {
          t[a * stride] = 0.0;
          t[(a + 3) * stride] = v[a];
        }
      } else {
        const Vector3d& omega = w[d];
        const Vector3d v = p.cross(omega);
        gradient[k] = -(omega.dot(s.T) + v.dot(s.F));
        twistOfDof_[k] = {omega, v};
        const Vector3d Aw(s.A[0] * omega[0] + s.A[3] * omega[1] + s.A[4] * omega[2],
                          s.A[3] * omega[0] + s.A[1] * omega[1] + s.A[5] * omega[2],
                          s.A[4] * omega[0] + s.A[5] * omega[1] + s.A[2] * omega[2]);
        M = (s.h + beta * s.F).cross(v) + (traceA + beta * traceP) * omega - Aw;
        if (beta != 0.0) M.noalias() -= beta * (s.P * omega);
        N = s.m * v + omega.cross(s.h);
        for (int a = 0; a < 3; ++a) {
          t[a * stride] = omega[a];
          t[(a + 3) * stride] = v[a];
        }
      }
      rowOfPath(path, stride, M, N, TreeMatrix::padded(depth + 1), H.row(k));
    }

    if (beta == 0.0 || dofs == 1) continue;
    const int depth = node.depth, k = node.dof;
    const Vector3d moment = s.T - p.cross(s.F);  // about the joint
    if (node.motion == TreeMotion::LimitedBall) {
      H.row(k)[depth] -= beta * dw11.dot(moment);
      H.row(k + 1)[depth + 1] -= beta * dw22.dot(moment);
      H.row(k + 1)[depth] -= beta * dw12.dot(moment);
    } else {
      // exp is symmetric to second order: the commutator w_i x w_j that the ordered product leaves is split
      // evenly.
      for (int a = 0; a < 3; ++a)
        for (int b = a + 1; b < 3; ++b) H.row(k + b)[depth + a] += 0.5 * beta * w[a].cross(w[b]).dot(moment);
    }
  }
}

}  // namespace gelenk
