#include "kinematics/motion/motion_edit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "kinematics/jacobian.h"
#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

double smoothStep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

Quaterniond partOf(const Quaterniond& rotation, double s) { return expRotation(s * logRotation(rotation)); }

int rotationCount(const Joint& joint) {
  return static_cast<int>(std::count_if(joint.axes.begin(), joint.axes.end(), [](const AxisDof& dof) {
    return dof.kind == AxisDof::Kind::Rotation;
  }));
}

/// Second-order Butterworth low-pass, direct form.
struct Biquad {
  double b0, b1, b2, a1, a2;
  Biquad(double cutoffHz, double rate) {
    // Two passes lower the frequency of gain 1/sqrt 2 by the fourth root of sqrt 2 - 1.
    const double K = std::tan(M_PI * cutoffHz / rate) / std::pow(std::sqrt(2.0) - 1.0, 0.25);
    const double norm = 1.0 / (1.0 + std::sqrt(2.0) * K + K * K);
    b0 = K * K * norm, b1 = 2.0 * b0, b2 = b0;
    a1 = 2.0 * (K * K - 1.0) * norm, a2 = (1.0 - std::sqrt(2.0) * K + K * K) * norm;
  }
  /// In place, beginning in the steady state of the first value.
  void run(VectorXd& x) const {
    double x1 = x[0], x2 = x[0], y1 = x[0], y2 = x[0];
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double y = b0 * x[i] + b1 * x1 + b2 * x2 - a1 * y1 - a2 * y2;
      x2 = x1, x1 = x[i], y2 = y1, y1 = y;
      x[i] = y;
    }
  }
};

VectorXd zeroPhase(const VectorXd& signal, const Biquad& filter, int padding) {
  const Eigen::Index n = signal.size(), pad = std::min<Eigen::Index>(padding, n - 1);
  VectorXd x(n + 2 * pad);
  for (Eigen::Index i = 0; i < pad; ++i) {  // odd about the end points
    x[i] = 2.0 * signal[0] - signal[pad - i];
    x[n + pad + i] = 2.0 * signal[n - 1] - signal[n - 2 - i];
  }
  x.segment(pad, n) = signal;
  filter.run(x);
  x.reverseInPlace();
  filter.run(x);
  x.reverseInPlace();
  return x.segment(pad, n);
}

void requireSame(const Skeleton& skeleton, const MotionClip& a, const MotionClip& b) {
  validate(skeleton, a);
  validate(skeleton, b);
  if (std::abs(a.framesPerSecond - b.framesPerSecond) > 1e-9 * a.framesPerSecond)
    throw std::invalid_argument("the clips have different frame rates; resample one of them");
}

/// Puts the root at a world frame; false where its dofs cannot do that.
bool setRootFrame(const Skeleton& skeleton, Eigen::Ref<VectorXd> q, const Eigen::Isometry3d& worldFromRoot) {
  const Joint& root = skeleton.joint(0);
  const bool free = root.axes.size() >= 3 && (root.ball || rotationCount(root) == 3) &&
                    std::all_of(root.axes.begin(), root.axes.begin() + 3,
                                [](const AxisDof& dof) { return dof.kind == AxisDof::Kind::Translation; });
  if (!free) return false;
  Eigen::Matrix3d axes;
  for (int k = 0; k < 3; ++k) axes.col(k) = root.axes[k].axis;
  if (!(axes.transpose() * axes).isIdentity(1e-9)) return false;
  const Eigen::Isometry3d moved = root.parentFromZero.inverse(Eigen::Isometry) * worldFromRoot;
  q.head<3>() = axes.transpose() * moved.translation();
  return setJointRotation(skeleton, q, 0, Quaterniond(moved.linear()));
}

}  // namespace

MotionClip lowPassed(const Skeleton& skeleton, const MotionClip& clip, double cutoffHz) {
  validate(skeleton, clip);
  if (!(cutoffHz > 0.0) || !(cutoffHz < 0.5 * clip.framesPerSecond))
    throw std::invalid_argument("the cut-off must lie between 0 and half the frame rate, " +
                                std::to_string(0.5 * clip.framesPerSecond) + " Hz");
  MotionClip result = clip;
  const int frames = clip.frameCount();
  if (frames < 2) return result;
  const Biquad filter(cutoffHz, clip.framesPerSecond);
  const int padding = static_cast<int>(std::ceil(3.0 * clip.framesPerSecond / cutoffHz));
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const int at = skeleton.qIndex(i);
    const bool asQuaternion = joint.ball || rotationCount(joint) > 1;
    for (std::size_t k = 0; k < joint.axes.size(); ++k) {
      const bool rotation = joint.axes[k].kind == AxisDof::Kind::Rotation;
      if (rotation && asQuaternion) continue;
      VectorXd values = clip.q.row(at + k);
      if (rotation)
        for (int f = 1; f < frames; ++f)
          values[f] = values[f - 1] + std::remainder(values[f] - values[f - 1], 2.0 * M_PI);
      result.q.row(at + k) = zeroPhase(values, filter, padding);
    }
    if (!asQuaternion) continue;
    Eigen::Matrix4Xd coefficients(4, frames);
    for (int f = 0; f < frames; ++f) {
      coefficients.col(f) = jointRotation(skeleton, clip.q.col(f), i).coeffs();
      if (f > 0 && coefficients.col(f).dot(coefficients.col(f - 1)) < 0.0) coefficients.col(f) *= -1.0;
    }
    for (int k = 0; k < 4; ++k) coefficients.row(k) = zeroPhase(coefficients.row(k), filter, padding);
    for (int f = 0; f < frames; ++f)
      setJointRotation(skeleton, result.q.col(f), i,
                       Quaterniond(Eigen::Vector4d(coefficients.col(f))).normalized());
  }
  return result;
}

MotionClip layered(const Skeleton& skeleton, const MotionClip& base, const Layer& layer) {
  requireSame(skeleton, base, layer.clip);
  const bool additive = layer.kind == Layer::Kind::Additive;
  if (!std::isfinite(layer.weight) || layer.weight < 0.0 || (!additive && layer.weight > 1.0))
    throw std::invalid_argument(
        "the weight of a layer must lie between 0 and 1, or be 0 or more for an additive one, not " +
        std::to_string(layer.weight));
  const VectorXd& reference = layer.reference.size() > 0 ? layer.reference : skeleton.rest();
  if (reference.size() != skeleton.nq())
    throw std::invalid_argument("the reference pose does not fit the skeleton");
  std::vector<int> joints = layer.joints;
  if (joints.empty())
    for (int i = 0; i < skeleton.jointCount(); ++i) joints.push_back(i);
  for (const int i : joints)
    if (i < 0 || i >= skeleton.jointCount())
      throw std::invalid_argument("a layer names joint " + std::to_string(i) + ", which does not exist");
  MotionClip result = base;
  VectorXd mixed;
  for (int f = 0; f < base.frameCount(); ++f) {
    const auto under = base.q.col(f), on = layer.clip.q.col(f % layer.clip.frameCount());
    if (!additive) interpolate(skeleton, under, on, layer.weight, mixed);
    for (const int i : joints) {
      const Joint& joint = skeleton.joint(i);
      const int at = skeleton.qIndex(i);
      if (!additive) {
        result.q.col(f).segment(at, skeleton.qCount(i)) = mixed.segment(at, skeleton.qCount(i));
        continue;
      }
      const Quaterniond departure =
          jointRotation(skeleton, reference, i).conjugate() * jointRotation(skeleton, on, i);
      const bool exact = setJointRotation(
          skeleton, result.q.col(f), i,
          (jointRotation(skeleton, under, i) * partOf(departure, layer.weight)).normalized());
      for (std::size_t k = 0; k < joint.axes.size(); ++k)
        if (!exact || joint.axes[k].kind == AxisDof::Kind::Translation)
          result.q(at + k, f) = under[at + k] + layer.weight * (on[at + k] - reference[at + k]);
    }
  }
  return result;
}

std::vector<int> limbBelow(const Skeleton& skeleton, int joint) {
  std::vector<int> limb;
  for (int i = joint; i < skeleton.jointCount(); ++i)
    if (skeleton.isAncestor(joint, i)) limb.push_back(i);
  return limb;
}

MotionClip crossFaded(const Skeleton& skeleton, const MotionClip& first, const MotionClip& second,
                      double seconds, bool alignRoot) {
  requireSame(skeleton, first, second);
  const int fade = static_cast<int>(std::lround(seconds * first.framesPerSecond));
  const int shorter = std::min(first.frameCount(), second.frameCount());
  if (fade < 0 || fade > shorter)
    throw std::invalid_argument("a fade of " + std::to_string(fade) +
                                " frames is longer than the shorter clip, which has " +
                                std::to_string(shorter));
  MotionClip moved = second;
  if (alignRoot) {
    const int at = std::min(first.frameCount() - fade, first.frameCount() - 1);
    const Eigen::Isometry3d a = forwardKinematics(skeleton, first.q.col(at))[0],
                            b = forwardKinematics(skeleton, second.q.col(0))[0];
    // The turn about y that brings one heading nearest to the other: the twist about y of a b^-1.
    const Quaterniond between(Eigen::Matrix3d(a.linear() * b.linear().transpose()));
    const Quaterniond heading = std::hypot(between.w(), between.y()) < 1e-9
                                    ? Quaterniond::Identity()
                                    : Quaterniond(between.w(), 0.0, between.y(), 0.0).normalized();
    Eigen::Isometry3d turn(heading);
    Vector3d shift = a.translation() - heading * b.translation();
    shift.y() = 0.0;
    turn.translation() = shift;
    for (int f = 0; f < moved.frameCount(); ++f)
      if (!setRootFrame(skeleton, moved.q.col(f), turn * forwardKinematics(skeleton, second.q.col(f))[0]))
        break;
  }
  const int before = first.frameCount() - fade;
  MotionClip result{.framesPerSecond = first.framesPerSecond,
                    .q = Eigen::MatrixXd(skeleton.nq(), before + moved.frameCount())};
  result.q.leftCols(before) = first.q.leftCols(before);
  result.q.rightCols(moved.frameCount()) = moved.q;
  VectorXd q;
  for (int f = 0; f < fade; ++f) {
    interpolate(skeleton, first.q.col(before + f), moved.q.col(f), smoothStep((f + 1.0) / (fade + 1.0)), q);
    result.q.col(before + f) = q;
  }
  return result;
}

namespace {

/// What a key asks of its joint beyond the clip.
struct Departure {
  Quaterniond rotation = Quaterniond::Identity();  ///< before the clip's own rotation
  VectorXd values;                                 ///< axis by axis; angles by the shorter way
};

Departure departureOf(const Skeleton& skeleton, const Eigen::Ref<const VectorXd>& from, const VectorXd& to,
                      int index) {
  const Joint& joint = skeleton.joint(index);
  const int at = skeleton.qIndex(index), axes = static_cast<int>(joint.axes.size());
  Departure departure{jointRotation(skeleton, to, index) * jointRotation(skeleton, from, index).conjugate(),
                      to.segment(at, axes) - from.segment(at, axes)};
  for (int k = 0; k < axes; ++k)
    if (joint.axes[k].kind == AxisDof::Kind::Rotation)
      departure.values[k] = std::remainder(departure.values[k], 2.0 * M_PI);
  return departure;
}

Departure between(const Departure& a, const Departure& b, double s) {
  return {a.rotation.slerp(s, b.rotation), (1.0 - s) * a.values + s * b.values};
}

}  // namespace

MotionClip keyed(const Skeleton& skeleton, const MotionClip& clip, int joint, std::span<const JointKey> keys,
                 double falloff) {
  validate(skeleton, clip);
  std::vector<Departure> departures;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (keys[k].frame < 0 || keys[k].frame >= clip.frameCount() ||
        (k > 0 && keys[k].frame <= keys[k - 1].frame))
      throw std::invalid_argument("keys must lie within the clip, in ascending order");
    if (keys[k].q.size() != skeleton.nq() || !keys[k].q.allFinite())
      throw std::invalid_argument("a key's pose does not fit the skeleton");
    departures.push_back(departureOf(skeleton, clip.q.col(keys[k].frame), keys[k].q, joint));
  }
  MotionClip result = clip;
  const std::vector<AxisDof>& axes = skeleton.joint(joint).axes;
  const Departure none{Quaterniond::Identity(), VectorXd::Zero(axes.size())};
  const double reach = std::max(1.0, falloff * clip.framesPerSecond);
  const int at = skeleton.qIndex(joint);
  for (int f = 0; f < clip.frameCount() && !keys.empty(); ++f) {
    const auto next =
        std::find_if(keys.begin(), keys.end(), [f](const JointKey& key) { return key.frame >= f; });
    const std::size_t b = static_cast<std::size_t>(next - keys.begin());
    Departure departure;
    if (b == 0)
      departure = between(none, departures[0], smoothStep(1.0 - (keys[0].frame - f) / reach));
    else if (b == keys.size())
      departure = between(none, departures[b - 1], smoothStep(1.0 - (f - keys[b - 1].frame) / reach));
    else
      departure = between(
          departures[b - 1], departures[b],
          smoothStep(static_cast<double>(f - keys[b - 1].frame) / (keys[b].frame - keys[b - 1].frame)));
    const bool exact =
        setJointRotation(skeleton, result.q.col(f), joint,
                         (departure.rotation * jointRotation(skeleton, clip.q.col(f), joint)).normalized());
    for (std::size_t k = 0; k < axes.size(); ++k)
      if (!exact || axes[k].kind == AxisDof::Kind::Translation) result.q(at + k, f) += departure.values[k];
  }
  for (const JointKey& key : keys)  // without rounding, and the Euler angles that were asked for
    result.q.col(key.frame).segment(at, skeleton.qCount(joint)) = key.q.segment(at, skeleton.qCount(joint));
  return result;
}

namespace {

/// The dimensions of dq by which the given joints turn.
std::vector<int> turningDimensions(const Skeleton& skeleton, std::span<const int> joints) {
  std::vector<int> columns;
  for (const int j : joints) {
    const std::vector<AxisDof>& axes = skeleton.joint(j).axes;
    for (int k = 0; k < skeleton.vCount(j); ++k)
      if (k >= static_cast<int>(axes.size()) || axes[k].kind == AxisDof::Kind::Rotation)
        columns.push_back(skeleton.vIndex(j) + k);
  }
  return columns;
}

/// All joints but the limb's root bend a little, into their ranges.
VectorXd bent(const Skeleton& skeleton, const VectorXd& q, std::span<const int> limb) {
  constexpr double little = 0.05;
  const int root = *std::min_element(limb.begin(), limb.end());
  VectorXd dq = VectorXd::Zero(skeleton.nv());
  for (const int j : limb) {
    if (j == root) continue;
    for (const int column : turningDimensions(skeleton, std::array{j})) {
      const std::size_t k = column - skeleton.vIndex(j);
      const std::vector<AxisDof>& axes = skeleton.joint(j).axes;
      const double at = k < axes.size() ? q[skeleton.qIndex(j) + static_cast<int>(k)] : 0.0;
      dq[column] = k < axes.size() && at - axes[k].lower > axes[k].upper - at ? -little : little;
    }
  }
  return integrate(skeleton, q, dq);
}

}  // namespace

double reachWithLeastChange(const Skeleton& skeleton, VectorXd& q, int joint, const Vector3d& target,
                            std::span<const int> movingJoints) {
  const std::vector<int> columns = turningDimensions(skeleton, movingJoints);
  const Eigen::Index n = static_cast<Eigen::Index>(columns.size());
  Frames frames = forwardKinematics(skeleton, q);
  Eigen::Matrix3Xd J(3, n);
  const auto takeColumns = [&] {
    const Eigen::Matrix3Xd all = pointJacobian(skeleton, q, frames, joint, Vector3d::Zero());
    for (Eigen::Index k = 0; k < n; ++k) J.col(k) = all.col(columns[k]);
  };
  takeColumns();
  Vector3d error = target - frames[joint].translation();
  const double before = error.norm();
  const VectorXd begin = q;
  // A straight limb and a target on its line: no slope leads there.
  if (n > 0 && (J.transpose() * error).norm() < 1e-6 * J.norm() * before) {
    q = bent(skeleton, q, movingJoints);
    forwardKinematics(skeleton, q, frames);
    error = target - frames[joint].translation();
    takeColumns();
  }
  constexpr int mostSteps = 200;
  constexpr double most = 1e9;
  double caution = 1.0;  // of the damping: more where a step leads away, as at a straight limb
  Frames there;
  for (int step = 0; step < mostSteps && error.norm() > 1e-9 && n > 0 && caution < most; ++step) {
    // Damped in proportion to the error: exact in the end.
    const double damping = caution * 1e-4 * J.squaredNorm() * std::min(1.0, error.norm());
    const Eigen::Matrix3d A = J * J.transpose() + damping * Eigen::Matrix3d::Identity();
    const VectorXd change = J.transpose() * A.ldlt().solve(error);
    VectorXd dq = VectorXd::Zero(skeleton.nv());
    for (Eigen::Index k = 0; k < n; ++k) dq[columns[k]] = change[k];
    const VectorXd next = integrate(skeleton, q, dq);
    forwardKinematics(skeleton, next, there);
    const Vector3d after = target - there[joint].translation();
    if (!(after.norm() < error.norm())) {
      caution *= 10.0;
      continue;
    }
    const bool settled = error.norm() - after.norm() < 1e-12;
    q = next;
    frames.swap(there);
    error = after;
    if (settled) break;
    caution = std::max(1.0, 0.1 * caution);
    takeColumns();
  }
  if (!(error.norm() < before)) q = begin;
  return std::min(before, error.norm());
}

Foot footAt(const Skeleton& skeleton, int ball) {
  Foot foot{.name = skeleton.joint(ball).name, .ball = ball, .leg = {}};
  if (!skeleton.children(ball).empty()) foot.tip = skeleton.children(ball).front();
  for (int j = skeleton.parent(ball); j > 0 && foot.leg.size() < 3; j = skeleton.parent(j))
    if (skeleton.vCount(j) > 0) foot.leg.insert(foot.leg.begin(), j);
  return foot;
}

std::vector<Foot> cmuFeet(const Skeleton& skeleton) {
  std::vector<Foot> feet;
  for (const char* name : {"ltoes", "rtoes"})
    if (const auto ball = skeleton.findJoint(name)) feet.push_back(footAt(skeleton, *ball));
  return feet;
}

std::vector<Contact> footContacts(const Skeleton& skeleton, const MotionClip& clip,
                                  std::span<const Foot> feet, const FootPlantOptions& options) {
  validate(skeleton, clip);
  const int frames = clip.frameCount();
  std::vector<std::vector<Vector3d>> balls(feet.size(), std::vector<Vector3d>(frames));
  Frames pose;
  for (int f = 0; f < frames; ++f) {
    forwardKinematics(skeleton, clip.q.col(f), pose);
    for (std::size_t k = 0; k < feet.size(); ++k) balls[k][f] = pose[feet[k].ball].translation();
  }
  const int shortest = std::max(2, static_cast<int>(std::lround(options.shortest * clip.framesPerSecond)));
  std::vector<Contact> contacts;
  for (std::size_t k = 0; k < feet.size(); ++k) {
    const auto stands = [&](int f) {
      const int a = std::max(0, f - 1), b = std::min(frames - 1, f + 1);
      return b > a &&
             (balls[k][b] - balls[k][a]).norm() * clip.framesPerSecond / (b - a) < options.plantedBelow;
    };
    for (int f = 0; f < frames; ++f) {
      if (!stands(f)) continue;
      const int first = f;
      while (f + 1 < frames && stands(f + 1)) ++f;
      if (f - first + 1 >= shortest) contacts.push_back({static_cast<int>(k), first, f});
    }
  }
  return contacts;
}

FootFacts footFacts(const Skeleton& skeleton, const MotionClip& clip, std::span<const Foot> feet,
                    std::span<const Contact> contacts, double floor) {
  FootFacts facts;
  std::vector<Frames> poses(clip.frameCount());
  for (int f = 0; f < clip.frameCount(); ++f) poses[f] = forwardKinematics(skeleton, clip.q.col(f));
  for (const Contact& contact : contacts)
    for (int f = contact.first; f < contact.last; ++f) {
      Vector3d way = poses[f + 1][feet[contact.foot].ball].translation() -
                     poses[f][feet[contact.foot].ball].translation();
      way.y() = 0.0;
      facts.meanSlide += way.norm();
      facts.largestSlide = std::max(facts.largestSlide, way.norm());
      ++facts.plantedSteps;
    }
  if (facts.plantedSteps > 0) facts.meanSlide /= facts.plantedSteps;
  for (const Frames& pose : poses)
    for (const Foot& foot : feet)
      for (const int joint : {foot.ball, foot.tip})
        if (joint >= 0)
          facts.deepestPenetration =
              std::max(facts.deepestPenetration, floor - pose[joint].translation().y());
  return facts;
}

namespace {

/// Offsets of a ball in every frame: what holds it in its contacts, faded outside.
std::vector<Vector3d> offsets(const std::vector<Vector3d>& ball, std::vector<Contact> contacts,
                              double blendFrames) {
  const int frames = static_cast<int>(ball.size());
  std::vector<Vector3d> result(frames, Vector3d::Zero());
  std::sort(contacts.begin(), contacts.end(),
            [](const Contact& a, const Contact& b) { return a.first < b.first; });
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Contact& contact = contacts[c];
    Eigen::AlignedBox3d slid;
    for (int f = contact.first; f <= contact.last; ++f) slid.extend(ball[f]);
    const auto hold = [&](int f) {
      Vector3d offset = slid.center() - ball[f];
      offset.y() = 0.0;
      return offset;
    };
    for (int f = contact.first; f <= contact.last; ++f) result[f] = hold(f);
    // Fades to both sides, at most half-way to the neighbouring contact.
    const int from = c > 0 ? (contacts[c - 1].last + contact.first) / 2 + 1 : 0;
    const int to = c + 1 < contacts.size() ? (contact.last + contacts[c + 1].first) / 2 : frames - 1;
    const double before = std::min<double>(blendFrames, contact.first - from + 1),
                 after = std::min<double>(blendFrames, to - contact.last + 1);
    for (int f = from; f < contact.first; ++f)
      result[f] = hold(contact.first) * smoothStep(1.0 - (contact.first - f) / before);
    for (int f = contact.last + 1; f <= to; ++f)
      result[f] = hold(contact.last) * smoothStep(1.0 - (f - contact.last) / after);
  }
  return result;
}

/// Turns the toes until their tip is above the floor; the least turn is found by reaching for the nearest
/// point above.
void liftTip(const Skeleton& skeleton, VectorXd& q, const Foot& foot, double floor) {
  if (foot.tip < 0) return;
  for (int attempt = 0; attempt < 8; ++attempt) {
    Vector3d tip = forwardKinematics(skeleton, q)[foot.tip].translation();
    if (tip.y() >= floor) return;
    tip.y() = floor + 1e-6 * (attempt + 1);
    reachWithLeastChange(skeleton, q, foot.tip, tip, std::array{foot.ball});
  }
}

}  // namespace

MotionClip footPlanted(const Skeleton& skeleton, const MotionClip& clip, std::span<const Foot> feet,
                       std::span<const Contact> contacts, const FootPlantOptions& options) {
  validate(skeleton, clip);
  MotionClip result = clip;
  const int frames = clip.frameCount();
  for (std::size_t k = 0; k < feet.size(); ++k) {
    const Foot& foot = feet[k];
    std::vector<Vector3d> ball(frames);
    for (int f = 0; f < frames; ++f)
      ball[f] = forwardKinematics(skeleton, result.q.col(f))[foot.ball].translation();
    std::vector<Contact> own;
    for (const Contact& contact : contacts)
      if (contact.foot == static_cast<int>(k)) own.push_back(contact);
    const auto offset = offsets(ball, own, options.blend * clip.framesPerSecond);
    for (int f = 0; f < frames; ++f) {
      Vector3d target = ball[f] + offset[f];
      target.y() = std::max(target.y(), options.floor);
      VectorXd q = result.q.col(f);
      if ((target - ball[f]).norm() > 0.0) reachWithLeastChange(skeleton, q, foot.ball, target, foot.leg);
      liftTip(skeleton, q, foot, options.floor);
      result.q.col(f) = q;
    }
  }
  return result;
}

}  // namespace gelenk
