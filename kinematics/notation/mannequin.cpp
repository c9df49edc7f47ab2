#include "kinematics/notation/mannequin.h"

#include <array>
#include <cmath>
#include <string_view>

#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

enum class Kind {
  Free,    ///< three translations and a ball
  Ball,    ///< ranges: swing about x, swing about y, twist about z
  Hinge,   ///< x
  Saddle,  ///< x, then y
  Ankle,   ///< x, then the horizontal forward axis
  Elbow,   ///< x (normal of the plane shoulder-elbow-wrist), then twist of the forearm about z
  End      ///< fixed
};

/// Where a hinge's angle is zero.
enum class Zero {
  Rest,
  Straight
};  // at rest, or where the bone continues its parent's in the plane of flexion

struct Direction {
  double x, y, z;
};
struct Degrees {
  double lower, upper;
};

/// One joint of the left side or of the middle. Names without the side; "_l" stands for both.
struct Row {
  std::string_view name, parent;
  double x, y, z;  ///< rest position, metres
  Kind kind = Kind::End;
  std::string_view towards = {};  ///< the main child: z of the frame points to it
  Direction y_hint = {0, 0, 0};   ///< the frame's y axis as nearly as z allows
  std::array<Degrees, 3> ranges = {};
  Zero zero = Zero::Rest;
  Direction zeroBone = {0, 0,
                        0};  ///< direction of the bone in the joint's zero, where that is not the rest pose
};

constexpr Direction back{0, 0, -1}, forward{0, 0, 1}, up{0, 1, 0}, down{0, -1, 0}, none{0, 0, 0};
constexpr Direction handBack{0.748, 0.663, -0.007}, thumbBack{-0.930, 0.346, -0.122};
constexpr Direction reaching{0.333, -0.153, 0.930}, hipFlexed45{0.09, -0.74, 0.66}, kneeUp{0, 0.66, 0.74};

// Rest positions: measured on a CC0 body (MakeHuman hm08), rounded to 0.1 mm. Ranges: adult active ranges of
// motion, rounded to 5 degrees (Norkin and White, Measurement of Joint Motion; AAOS), measured from the
// joint's zero; the split of the spine's totals over its joints is a modelling choice. Shoulder: the smallest
// ellipse that holds flexion -50..170, abduction 0..170 and horizontal adduction -30..120 around the zero
// direction `reaching`.
constexpr Row rows[] = {
    {"Root", "", 0, 0, 0, Kind::Free},
    {"pelvis", "Root", 0, 0.9314, 0.0031, Kind::Ball, "spine_01", back, {{{-30, 30}, {-20, 20}, {-30, 30}}}},
    {"thigh_l",
     "pelvis",
     0.1085,
     0.9261,
     -0.0076,
     Kind::Ball,
     "calf_l",
     kneeUp,
     {{{-72, 70}, {-36, 42}, {-40, 45}}},
     Zero::Rest,
     hipFlexed45},
    {"calf_l",
     "thigh_l",
     0.1480,
     0.5100,
     0.0269,
     Kind::Hinge,
     "foot_l",
     forward,
     {{{2, 140}}},
     Zero::Straight},
    {"foot_l", "calf_l", 0.1978, 0.0715, 0.0152, Kind::Ankle, "ball_l", up, {{{-20, 50}, {-35, 20}}}},
    {"ball_l", "foot_l", 0.2018, 0.0083, 0.1407, Kind::Hinge, "toe_end_l", up, {{{-70, 40}}}},
    {"toe_end_l", "ball_l", 0.1976, 0.0138, 0.2117},
    {"spine_01",
     "pelvis",
     0,
     1.0178,
     -0.0288,
     Kind::Ball,
     "spine_02",
     back,
     {{{-10, 25}, {-10, 10}, {-5, 5}}}},
    {"spine_02",
     "spine_01",
     0,
     1.0818,
     -0.0199,
     Kind::Ball,
     "spine_03",
     back,
     {{{-10, 25}, {-10, 10}, {-10, 10}}}},
    {"spine_03",
     "spine_02",
     0,
     1.1412,
     -0.0285,
     Kind::Ball,
     "neck_01",
     back,
     {{{-10, 20}, {-10, 10}, {-25, 25}}}},
    {"neck_01", "spine_03", 0, 1.4840, 0.0115, Kind::Ball, "head", back, {{{-30, 25}, {-25, 25}, {-40, 40}}}},
    {"head", "neck_01", 0, 1.5807, 0.0476, Kind::Ball, "head_end", back, {{{-30, 20}, {-20, 20}, {-40, 40}}}},
    {"head_end", "head", 0, 1.7365, 0.0411},
    {"clavicle_l",
     "spine_03",
     0.0228,
     1.4096,
     0.0223,
     Kind::Ball,
     "upperarm_l",
     down,
     {{{-10, 40}, {-25, 30}, {-45, 10}}}},
    {"upperarm_l",
     "clavicle_l",
     0.2035,
     1.3795,
     0.0183,
     Kind::Ball,
     "lowerarm_l",
     down,
     {{{-120, 95}, {-101, 51}, {-90, 70}}},
     Zero::Rest,
     reaching},
    {"lowerarm_l",
     "upperarm_l",
     0.3657,
     1.1908,
     0.0156,
     Kind::Elbow,
     "hand_l",
     none,
     {{{2, 145}, {-80, 80}}},
     Zero::Straight},
    {"hand_l",
     "lowerarm_l",
     0.5003,
     1.0621,
     0.2076,
     Kind::Saddle,
     "middle_01_l",
     handBack,
     {{{-70, 80}, {-20, 30}}}},
    {"thumb_01_l",
     "hand_l",
     0.5015,
     1.0554,
     0.2563,
     Kind::Saddle,
     "thumb_02_l",
     thumbBack,
     {{{-15, 30}, {-30, 30}}}},
    {"thumb_02_l",
     "thumb_01_l",
     0.4787,
     1.0469,
     0.2797,
     Kind::Hinge,
     "thumb_03_l",
     thumbBack,
     {{{2, 55}}},
     Zero::Straight},
    {"thumb_03_l",
     "thumb_02_l",
     0.4651,
     1.0329,
     0.3145,
     Kind::Hinge,
     "thumb_end_l",
     thumbBack,
     {{{2, 80}}},
     Zero::Straight},
    {"thumb_end_l", "thumb_03_l", 0.4591, 1.0149, 0.3382},
    {"index_01_l",
     "hand_l",
     0.5305,
     1.0214,
     0.3129,
     Kind::Saddle,
     "index_02_l",
     handBack,
     {{{-30, 90}, {-20, 20}}},
     Zero::Straight},
    {"index_02_l",
     "index_01_l",
     0.5341,
     1.0057,
     0.3363,
     Kind::Hinge,
     "index_03_l",
     handBack,
     {{{2, 100}}},
     Zero::Straight},
    {"index_03_l",
     "index_02_l",
     0.5336,
     0.9885,
     0.3550,
     Kind::Hinge,
     "index_end_l",
     handBack,
     {{{-5, 80}}},
     Zero::Straight},
    {"index_end_l", "index_03_l", 0.5298, 0.9675, 0.3749},
    {"middle_01_l",
     "hand_l",
     0.5485,
     1.0086,
     0.2941,
     Kind::Saddle,
     "middle_02_l",
     handBack,
     {{{-30, 90}, {-20, 20}}},
     Zero::Straight},
    {"middle_02_l",
     "middle_01_l",
     0.5564,
     0.9811,
     0.3175,
     Kind::Hinge,
     "middle_03_l",
     handBack,
     {{{2, 100}}},
     Zero::Straight},
    {"middle_03_l",
     "middle_02_l",
     0.5594,
     0.9584,
     0.3371,
     Kind::Hinge,
     "middle_end_l",
     handBack,
     {{{-5, 80}}},
     Zero::Straight},
    {"middle_end_l", "middle_03_l", 0.5592, 0.9344, 0.3542},
    {"ring_01_l",
     "hand_l",
     0.5569,
     0.9997,
     0.2755,
     Kind::Saddle,
     "ring_02_l",
     handBack,
     {{{-30, 90}, {-20, 20}}},
     Zero::Straight},
    {"ring_02_l",
     "ring_01_l",
     0.5671,
     0.9735,
     0.2919,
     Kind::Hinge,
     "ring_03_l",
     handBack,
     {{{2, 100}}},
     Zero::Straight},
    {"ring_03_l",
     "ring_02_l",
     0.5718,
     0.9511,
     0.3067,
     Kind::Hinge,
     "ring_end_l",
     handBack,
     {{{-5, 80}}},
     Zero::Straight},
    {"ring_end_l", "ring_03_l", 0.5743, 0.9252, 0.3198},
    {"pinky_01_l",
     "hand_l",
     0.5584,
     0.9893,
     0.2545,
     Kind::Saddle,
     "pinky_02_l",
     handBack,
     {{{-30, 90}, {-20, 20}}},
     Zero::Straight},
    {"pinky_02_l",
     "pinky_01_l",
     0.5649,
     0.9688,
     0.2635,
     Kind::Hinge,
     "pinky_03_l",
     handBack,
     {{{2, 100}}},
     Zero::Straight},
    {"pinky_03_l",
     "pinky_02_l",
     0.5668,
     0.9533,
     0.2703,
     Kind::Hinge,
     "pinky_end_l",
     handBack,
     {{{-5, 80}}},
     Zero::Straight},
    {"pinky_end_l", "pinky_03_l", 0.5696, 0.9334, 0.2787},
};

Vector3d vector(const Direction& d) { return {d.x, d.y, d.z}; }
Vector3d position(const Row& row) { return {row.x, row.y, row.z}; }
double radians(double degrees) { return degrees * M_PI / 180.0; }
bool sided(std::string_view name) { return name.ends_with("_l"); }

const Row* find(std::string_view name) {
  for (const Row& row : rows)
    if (row.name == name) return &row;
  return nullptr;
}

Matrix3d frameWith(const Vector3d& z, const Vector3d& yHint) {
  Matrix3d R;
  R.col(2) = z.normalized();
  R.col(0) = yHint.cross(R.col(2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

/// Direction of the bone that starts at the row, at rest.
Vector3d bone(const Row& row) { return (position(*find(row.towards)) - position(row)).normalized(); }

/// worldFromJoint at rest, and the rest pose of the joint's motion.
struct RestPose {
  Matrix3d worldFromJoint = Matrix3d::Identity();
  Quaterniond ball = Quaterniond::Identity();
  double flexion = 0.0;  ///< about x
};

RestPose restPose(const Row& row) {
  RestPose rest;
  const Row* parent = find(row.parent);
  if (row.kind == Kind::Free) return rest;
  if (row.kind == Kind::End) {
    rest.worldFromJoint = restPose(*parent).worldFromJoint;
    return rest;
  }
  const Vector3d z = bone(row);
  if (row.kind == Kind::Elbow) {
    const Vector3d x = bone(*parent).cross(z);
    rest.worldFromJoint = frameWith(z, z.cross(x));
  } else if (vector(row.zeroBone).isZero()) {
    rest.worldFromJoint = frameWith(z, vector(row.y_hint));
  } else {
    const Matrix3d worldFromZero = frameWith(vector(row.zeroBone), vector(row.y_hint));
    rest.ball = rotationBetween(Vector3d::UnitZ(), worldFromZero.transpose() * z);
    rest.worldFromJoint = worldFromZero * rest.ball.toRotationMatrix();
  }
  if (row.zero == Zero::Straight) {
    const Vector3d x = rest.worldFromJoint.col(0), before = bone(*parent);
    rest.flexion = std::atan2(x.dot(before.cross(z)), (before - x.dot(before) * x).dot(z));
  }
  return rest;
}

AxisDof turn(const Vector3d& axis, const Degrees& range) {
  return {AxisDof::Kind::Rotation, axis, radians(range.lower), radians(range.upper)};
}

BallLimit ballLimit(const std::array<Degrees, 3>& ranges) {
  BallLimit limit;
  for (int k = 0; k < 2; ++k) {  // swing coordinates are 2 sin(angle / 2)
    const double lower = 2.0 * std::sin(0.5 * radians(ranges[k].lower)),
                 upper = 2.0 * std::sin(0.5 * radians(ranges[k].upper));
    limit.swingCentre[k] = 0.5 * (lower + upper);
    limit.swingRadii[k] = 0.5 * (upper - lower);
  }
  limit.twistLower = radians(ranges[2].lower);
  limit.twistUpper = radians(ranges[2].upper);
  return limit;
}

void addMotion(const Row& row, const RestPose& rest, Joint& joint) {
  switch (row.kind) {
    case Kind::Free:
      for (int k = 0; k < 3; ++k) joint.axes.push_back({AxisDof::Kind::Translation, Vector3d::Unit(k)});
      joint.ball = true;
      break;
    case Kind::Ball:
      joint.ball = true;
      joint.ballLimit = ballLimit(row.ranges);
      break;
    case Kind::Hinge: joint.axes = {turn(Vector3d::UnitX(), row.ranges[0])}; break;
    case Kind::Saddle:
      joint.axes = {turn(Vector3d::UnitX(), row.ranges[0]), turn(Vector3d::UnitY(), row.ranges[1])};
      break;
    case Kind::Ankle: {
      Vector3d ahead = rest.worldFromJoint.transpose() * Vector3d::UnitZ();
      ahead.x() = 0.0;
      joint.axes = {turn(Vector3d::UnitX(), row.ranges[0]), turn(ahead.normalized(), row.ranges[1])};
      break;
    }
    case Kind::Elbow:
      joint.axes = {turn(Vector3d::UnitX(), row.ranges[0]), turn(Vector3d::UnitZ(), row.ranges[1])};
      break;
    case Kind::End: break;
  }
}

struct PlacedJoint {
  Joint joint;
  std::vector<double> rest;
};

PlacedJoint place(const Row& row, int parent) {
  const RestPose rest = restPose(row);
  PlacedJoint placed{.joint = {.name = std::string(row.name), .parent = parent}, .rest = {}};
  const Matrix3d parentFromWorld = row.parent.empty()
                                       ? Matrix3d(Matrix3d::Identity())
                                       : Matrix3d(restPose(*find(row.parent)).worldFromJoint.transpose());
  const Matrix3d jointFromZero =
      rest.ball.toRotationMatrix() * expRotation({rest.flexion, 0, 0}).toRotationMatrix();
  placed.joint.parentFromZero.linear() = parentFromWorld * rest.worldFromJoint * jointFromZero.transpose();
  const Vector3d origin = row.parent.empty() ? Vector3d(Vector3d::Zero()) : position(*find(row.parent));
  placed.joint.parentFromZero.translation() = parentFromWorld * (position(row) - origin);
  addMotion(row, rest, placed.joint);

  placed.rest.assign(placed.joint.axes.size(), 0.0);
  if (row.zero == Zero::Straight) placed.rest[0] = rest.flexion;
  if (placed.joint.ball)
    placed.rest.insert(placed.rest.end(), {rest.ball.w(), rest.ball.x(), rest.ball.y(), rest.ball.z()});
  return placed;
}

std::string rightName(std::string_view left) {
  return sided(left) ? std::string(left.substr(0, left.size() - 1)) + "r" : std::string(left);
}

/// The right partner of a left joint: frames F become S F S with S = diag(-1, 1, 1), so angles about x stay
/// and those about y and z change sign.
PlacedJoint mirrored(PlacedJoint left, int parent) {
  left.joint.name = rightName(left.joint.name);
  left.joint.parent = parent;
  const Matrix3d S = Vector3d(-1.0, 1.0, 1.0).asDiagonal();
  left.joint.parentFromZero.linear() = S * left.joint.parentFromZero.linear() * S;
  left.joint.parentFromZero.translation() = S * left.joint.parentFromZero.translation();
  for (std::size_t k = 0; k < left.joint.axes.size(); ++k) {
    AxisDof& dof = left.joint.axes[k];
    if (dof.axis.x() != 0.0) continue;  // flexion
    dof = {dof.kind, dof.axis, -dof.upper, -dof.lower};
    left.rest[k] = -left.rest[k];
  }
  if (!left.joint.ball) return left;
  BallLimit& limit = *left.joint.ballLimit;
  limit.swingCentre.y() = -limit.swingCentre.y();
  limit = {limit.swingCentre, limit.swingRadii, -limit.twistUpper, -limit.twistLower};
  left.rest[2] = -left.rest[2];
  left.rest[3] = -left.rest[3];
  return left;
}

}  // namespace

Skeleton mannequin() {
  std::vector<Joint> joints;
  std::vector<double> rest;
  const auto indexOf = [&](std::string_view name) {
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (joints[i].name == name) return static_cast<int>(i);
    return -1;
  };
  const auto append = [&](const PlacedJoint& placed) {
    joints.push_back(placed.joint);
    rest.insert(rest.end(), placed.rest.begin(), placed.rest.end());
  };
  constexpr std::size_t count = std::size(rows);
  for (std::size_t begin = 0; begin < count;) {  // limb by limb: the whole left one, then the whole right one
    std::size_t end = begin + 1;
    if (sided(rows[begin].name))
      while (end < count && sided(rows[end].name)) ++end;
    for (std::size_t i = begin; i < end; ++i) append(place(rows[i], indexOf(rows[i].parent)));
    for (std::size_t i = begin; i < end && sided(rows[i].name); ++i)
      append(mirrored(place(rows[i], -1), indexOf(rightName(rows[i].parent))));
    begin = end;
  }
  return Skeleton(std::move(joints),
                  Eigen::Map<Eigen::VectorXd>(rest.data(), static_cast<Eigen::Index>(rest.size())));
}

std::vector<std::string> mannequinHandles() {
  return {"hand_l", "hand_r", "foot_l", "foot_r", "head", "pelvis"};
}

}  // namespace gelenk
