// Lecture 10.2: the hierarchy in space with Euler angles and with quaternions.

#include <random>

#include "apps/lecture/derivations.h"
#include "apps/lecture/example.h"
#include "apps/lecture/slide_data.h"
#include "apps/lecture/text.h"
#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/notation/euler.h"
#include "kinematics/rotation.h"
#include "solvers/ceres/quaternion_chain.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;
const std::vector<double> lengths{1.0, 0.8, 0.5};
const std::array<Vector3d, 3>& pose = slide::ballAngles;

/// Three joints at the ends of links along x, each with three axes in the given order, or a ball.
Skeleton chain(const EulerOrder* order) {
  std::vector<Joint> joints;
  for (int i = 0; i < 3; ++i) {
    Joint joint{.name = "joint" + std::to_string(i + 1), .parent = i - 1};
    if (i > 0) joint.parentFromZero.translation() = Vector3d(lengths[static_cast<std::size_t>(i) - 1], 0, 0);
    if (order)
      for (const int axis : {order->first, order->second, order->third})
        joint.axes.push_back(AxisDof{.axis = Vector3d::Unit(axis)});
    else
      joint.ball = true;
    joints.push_back(joint);
  }
  joints.push_back({.name = "end-effector",
                    .parent = 2,
                    .parentFromZero = Isometry3d(Eigen::Translation3d(lengths[2], 0, 0))});
  return Skeleton(std::move(joints));
}

using Angles = std::array<Vector3d, 3>;  ///< (phi^x, phi^y, phi^z) of each joint

/// R(phi^x, phi^y, phi^z) of a joint.
Quaterniond rotationOf(const Vector3d& angles) {
  return Quaterniond(rotationFromEuler(lectureEulerOrder(), angles));
}

Frames framesByQuaternions(const Angles& angles) {
  const Skeleton skeleton = chain(nullptr);
  VectorXd q = neutral(skeleton);
  for (int i = 0; i < 3; ++i) setBallRotation(skeleton, q, i, rotationOf(angles[i]));
  return forwardKinematics(skeleton, q);
}

Frames framesByEuler(const EulerOrder& order, const Angles& angles) {
  VectorXd q(9);
  for (int i = 0; i < 3; ++i)
    q.segment<3>(3 * i) = eulerFromRotation(order, rotationOf(angles[i]).toRotationMatrix());
  return forwardKinematics(chain(&order), q);
}

/// The slide's own product T(l_i, 0) R(phi_(i+1)), without any skeleton.
Isometry3d endByProducts(const Angles& angles) {
  Isometry3d K = Isometry3d::Identity();
  for (std::size_t i = 0; i < 3; ++i) {
    K.rotate(rotationFromEuler(lectureEulerOrder(), angles[i]));
    K.translate(Vector3d(lengths[i], 0, 0));
  }
  return K;
}

/// Largest difference of any frame between the quaternion chain and all twelve orders.
double ordersApart(const Angles& angles) {
  const Frames byQuaternions = framesByQuaternions(angles);
  double apart = 0.0;
  for (const EulerOrder& order : eulerOrders()) {
    const Frames byEuler = framesByEuler(order, angles);
    for (std::size_t i = 0; i < byEuler.size(); ++i)
      apart = std::max(apart, (byEuler[i].matrix() - byQuaternions[i].matrix()).cwiseAbs().maxCoeff());
  }
  return apart;
}

/// At gimbal lock the first and the third angle turn about one line: sine of the angle between the two axes
/// in the world.
double lockedAxesApart(double middle) {
  const Eigen::Matrix3d E = eulerRates(lectureEulerOrder(), {0.4, middle, 0.9});
  return E.col(0).cross(E.col(2)).norm();
}

const std::vector<Quaterniond>& fitStart() {
  static const std::vector<Quaterniond> start = [] {
    std::mt19937_64 random(3);
    std::vector<Quaterniond> q;
    for (int i = 0; i < 3; ++i) {
      Vector3d w;
      for (double& c : w) c = uniform01(random) - 0.5;  // one after the other: arguments have no order
      q.push_back(expRotation(w));
    }
    return q;
  }();
  return start;
}
const Vector3d reachable{0.4, 1.1, 0.9}, unreachable{1.5, 2.0, 1.0};  // 1.49 and 2.69 away, reach 2.3

QuaternionChainFit fit(const Vector3d& target, UnitConstraint constraint, double weight = 1.0) {
  return fitQuaternionChain(lengths, fitStart(), target, constraint, weight);
}

std::string fitTable(const Vector3d& target) {
  std::string out = fmt::format("  target {}, {:.3f} away; reach {:.3f}\n", text::point(target),
                                target.norm(), lengths[0] + lengths[1] + lengths[2]);
  out +=
      text::heads({"constraint", "iterations", "max | ||q|| - 1 |", "error it claims", "of the rigid chain"});
  const auto row = [&](const std::string& name, const QuaternionChainFit& f) {
    out += text::row({name, std::to_string(f.iterations), text::scientific(f.constraintError, 1),
                      text::scientific(f.claimedError, 5), text::scientific(f.trueError, 5)});
  };
  row("manifold", fit(target, UnitConstraint::Manifold));
  for (const double weight : {0.1, 1.0, 10.0, 100.0})
    row(fmt::format("penalty, weight {:g}", weight), fit(target, UnitConstraint::Penalty, weight));
  return out;
}

std::string steps() {
  std::string out = rotationsDerivation(pose) + "\n";
  out +=
      "Gimbal lock: x, y, z at phi^y = 90 degrees. The world axes about which the angles turn, and |det E| = "
      "|cos phi^y|:\n" +
      text::heads({"phi^y [deg]", "|det E|", "sine between first and third axis"});
  for (const double middle : {0.0, 45.0, 80.0, 89.0, 90.0}) {
    const Eigen::Matrix3d E = eulerRates(lectureEulerOrder(), {0.4, middle * degree, 0.9});
    out += text::row({fmt::format("{:g}", middle), text::scientific(std::abs(E.determinant())),
                      text::scientific(lockedAxesApart(middle * degree))});
  }
  out +=
      "At 90 degrees first and third axis are one line: a direction of turning is lost, and only phi^x + "
      "phi^z is determined.\n\n";
  out +=
      fmt::format("Optimising quaternions under ||q|| = 1, three ball joints, {}:\n", quaternionChainMethod) +
      fitTable(reachable) + fitTable(unreachable);
  out +=
      "On the manifold the constraint holds to rounding. As a penalty it is a wish: out of reach, "
      "quaternions grow and the links stretch.\n";
  return out;
}

}  // namespace

std::string rotationsDerivation(const Angles& angles) {
  std::string out =
      "T_(i -> i+1) = T(l_i, 0) R(phi_(i+1)),  R(phi) = R(phi^x, phi^y, phi^z): rotations about x, then y, "
      "then z of the moving frame.\n";
  out += text::heads({"i", "l_i", "(phi^x, phi^y, phi^z)", "", "", "q = (w, x, y, z)", "", "", ""});
  for (std::size_t i = 0; i < 3; ++i) {
    const Quaterniond q = rotationOf(angles[i]);
    std::vector<std::string> cells{std::to_string(i + 1), fmt::format("{:g}", lengths[i])};
    text::append(cells, angles[i] / degree, 2);
    text::append(cells, Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()), 5);
    out += text::row(cells);
  }
  const auto end = [](std::vector<std::string> cells, const Vector3d& at) {
    text::append(cells, at, 5);
    return text::row(cells);
  };
  out += "\nThe end-effector:\n";
  out += end({"by the slide's product"}, endByProducts(angles).translation());
  out += end({"by the skeleton, quaternions"}, framesByQuaternions(angles).back().translation());
  out += "\nBy the skeleton in each of the twelve orders (angles of joint 1 in degrees):\n";
  out += text::heads({"order", "angles", "", "", "end-effector", "", ""});
  for (const EulerOrder& order : eulerOrders()) {
    std::vector<std::string> cells{std::string(order.name)};
    text::append(cells, eulerFromRotation(order, rotationOf(angles[0]).toRotationMatrix()) / degree, 2);
    out += end(cells, framesByEuler(order, angles).back().translation());
  }
  return out + fmt::format("  largest difference of any matrix entry: {:.1e}\n", ordersApart(angles));
}

LectureTopic rotationsTopic() {
  const std::string section = "10.2, hierarchical coordinate systems in 3D";
  LectureTopic topic{.id = "rotations",
                     .section = "10.2",
                     .title = "Euler angles and quaternions",
                     .steps = &steps,
                     .checks = {}};
  topic.checks = {
      {.id = "rotations-routes",
       .section = section,
       .what = "T(l, 0) R(phi^x, phi^y, phi^z) equals the quaternion skeleton",
       .printed = {1e-14},
       .tolerance = {0},
       .compute =
           [] {
             return std::vector{(endByProducts(pose).matrix() - framesByQuaternions(pose).back().matrix())
                                    .cwiseAbs()
                                    .maxCoeff()};
           },
       .comparison = Comparison::AtMost},
      {.id = "rotations-orders",
       .section = section,
       .what = "all twelve Euler orders give the same pose",
       .printed = {1e-14},
       .tolerance = {0},
       .compute = [] { return std::vector{ordersApart(pose)}; },
       .comparison = Comparison::AtMost},
      {.id = "rotations-gimbal",
       .section = section,
       .what = "gimbal lock at phi^y = 90: sine between first and third axis",
       .printed = {0},
       .tolerance = {1e-15},
       .compute = [] { return std::vector{lockedAxesApart(90 * degree)}; }},
      {.id = "rotations-manifold",
       .section = "10.2, condition ||q|| = 1",
       .what = "manifold: reached, max ||q| - 1|",
       .printed = {1e-10, 1e-14},
       .tolerance = {0},
       .compute =
           [] {
             const QuaternionChainFit f = fit(reachable, UnitConstraint::Manifold);
             return std::vector{f.trueError, f.constraintError};
           },
       .comparison = Comparison::AtMost},
      {.id = "rotations-manifold-unreachable",
       .section = "10.2, condition ||q|| = 1",
       .what = "manifold, out of reach: the rigid chain's nearest distance",
       .printed = {unreachable.norm() - 2.3},
       .tolerance = {1e-8},
       .compute = [] { return std::vector{fit(unreachable, UnitConstraint::Manifold).trueError}; }},
      {.id = "rotations-penalty-unreachable",
       .section = "10.2, condition ||q|| = 1",
       .what = "penalty of weight 1, out of reach: max ||q| - 1|",
       .printed = {1e-3},
       .tolerance = {0},
       .compute = [] { return std::vector{fit(unreachable, UnitConstraint::Penalty).constraintError}; },
       .comparison = Comparison::AtLeast,
       .note = "the penalty lets the links stretch instead of keeping ||q|| = 1"},
  };
  return topic;
}

}  // namespace gelenk
