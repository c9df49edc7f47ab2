#include "kinematics/skeleton.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <unordered_set>

namespace gelenk {
namespace {

[[noreturn]] void reject(const Joint& joint, int index, const std::string& why) {
  throw std::invalid_argument("joint " + std::to_string(index) + " '" + joint.name + "': " + why);
}

void validate(const Joint& joint, int index) {
  if (joint.name.empty()) reject(joint, index, "the name is empty");
  if (index == 0 && joint.parent != -1)
    reject(joint, index, "the first joint is the root, its parent must be -1");
  if (index > 0 && joint.parent < 0)
    reject(joint, index, "a second root; every joint but the first needs a parent");
  if (joint.parent >= index)
    reject(joint, index, "its parent " + std::to_string(joint.parent) + " does not come before it");

  const Eigen::Matrix4d& offset = joint.parentFromZero.matrix();
  if (!offset.allFinite()) reject(joint, index, "the offset has a value that is not finite");
  const Eigen::Matrix3d R = joint.parentFromZero.linear();
  if (!(R * R.transpose()).isIdentity(1e-9) || R.determinant() < 0.0)
    reject(joint, index, "the offset is not a rigid motion");

  for (const AxisDof& dof : joint.axes) {
    if (!dof.axis.allFinite() || std::abs(dof.axis.norm() - 1.0) > 1e-9)
      reject(joint, index, "an axis is not a unit vector");
    if (std::isnan(dof.lower) || std::isnan(dof.upper) || dof.lower > dof.upper)
      reject(joint, index,
             "limits must satisfy lower <= upper, found " + std::to_string(dof.lower) + " and " +
                 std::to_string(dof.upper));
  }
  if (joint.ballLimit) {
    const BallLimit& limit = *joint.ballLimit;
    if (!joint.ball) reject(joint, index, "a ball limit on a joint that is no ball");
    if (!limit.swingCentre.allFinite() || !(limit.swingRadii.minCoeff() > 0.0))
      reject(joint, index, "the swing cone needs a finite centre and positive radii");
    if (!(limit.twistLower <= limit.twistUpper))
      reject(joint, index, "twist limits must satisfy lower <= upper");
  }
}

}  // namespace

/// Checks them, takes the followers' ranges into their sources', and gives followers their sources' vIndex.
void Skeleton::addCouplings() {
  coupled_.assign(joints_.size(), 0);
  const auto hasOneAxis = [&](int i) { return joints_[i].axes.size() == 1 && !joints_[i].ball; };
  for (int i = 0; i < jointCount(); ++i) {
    if (!joints_[i].coupling) continue;
    const Coupling& c = *joints_[i].coupling;
    if (c.source < 0 || c.source >= jointCount() || c.source == i)
      reject(joints_[i], i, "it follows joint " + std::to_string(c.source) + ", which is no other joint");
    if (joints_[c.source].coupling)
      reject(joints_[i], i,
             "it follows '" + joints_[c.source].name + "', which follows another joint itself");
    if (!hasOneAxis(i) || !hasOneAxis(c.source))
      reject(joints_[i], i, "couplings are between joints of one axis");
    if (!std::isfinite(c.multiplier) || !std::isfinite(c.offset))
      reject(joints_[i], i, "a coupling needs finite numbers");
    followers_.push_back(i);
    coupled_[i] = coupled_[c.source] = 1;
    vIndex_[i] = vIndex_[c.source];
    if (c.multiplier == 0.0) continue;
    const AxisDof& own = joints_[i].axes[0];
    AxisDof& range = joints_[c.source].axes[0];
    double lower = (own.lower - c.offset) / c.multiplier, upper = (own.upper - c.offset) / c.multiplier;
    if (lower > upper) std::swap(lower, upper);
    range.lower = std::max(range.lower, lower);
    range.upper = std::min(range.upper, upper);
    if (range.lower > range.upper)
      reject(joints_[i], i, "its limits leave '" + joints_[c.source].name + "', which it follows, no value");
  }
}

Skeleton Skeleton::uncoupled() const {
  std::vector<Joint> joints = joints_;
  for (Joint& joint : joints) joint.coupling.reset();
  return Skeleton(std::move(joints), rest_);
}

bool AxisDof::isFullTurn() const { return kind == Kind::Rotation && upper - lower >= 2.0 * M_PI - 1e-9; }

Skeleton::Skeleton(std::vector<Joint> joints, std::optional<Eigen::VectorXd> rest)
    : joints_(std::move(joints)) {
  if (joints_.empty()) throw std::invalid_argument("a skeleton needs at least one joint");
  children_.resize(joints_.size());
  std::unordered_set<std::string> names;
  for (int i = 0; i < jointCount(); ++i) {
    validate(joints_[i], i);
    if (!names.insert(joints_[i].name).second) reject(joints_[i], i, "the name is used twice");
    if (joints_[i].parent >= 0) children_[joints_[i].parent].push_back(i);
    qIndex_.push_back(nq_);
    vIndex_.push_back(nv_);
    nq_ += qCount(i);
    nv_ += vCount(i);
  }
  addCouplings();

  rest_ = Eigen::VectorXd::Zero(nq_);
  if (rest && rest->size() != nq_)
    throw std::invalid_argument("the rest configuration has " + std::to_string(rest->size()) +
                                " values, expected nq = " + std::to_string(nq_));
  if (rest && !rest->allFinite())
    throw std::invalid_argument("the rest configuration has a value that is not finite");
  for (int i = 0; i < jointCount(); ++i) {
    if (!joints_[i].ball) continue;
    const int at = qIndex_[i] + static_cast<int>(joints_[i].axes.size());
    if (rest && std::abs(rest->segment<4>(at).norm() - 1.0) > 1e-9)
      reject(joints_[i], i, "the quaternion of the rest configuration is not of unit length");
    rest_[at] = 1.0;
  }
  if (rest) rest_ = *rest;
  couple(rest_);
}

std::optional<int> Skeleton::findJoint(std::string_view name) const {
  for (int i = 0; i < jointCount(); ++i)
    if (joints_[i].name == name) return i;
  return std::nullopt;
}

int Skeleton::jointIndex(std::string_view name) const {
  if (const auto found = findJoint(name)) return *found;
  std::string known;
  for (const Joint& joint : joints_) known += (known.empty() ? "" : ", ") + joint.name;
  throw std::invalid_argument("no joint is called '" + std::string(name) + "'; there are: " + known);
}

bool Skeleton::isAncestor(int a, int j) const {
  while (j > a) j = joints_[j].parent;
  return j == a;
}

}  // namespace gelenk
