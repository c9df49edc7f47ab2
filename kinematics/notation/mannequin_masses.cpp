#include "kinematics/notation/mannequin_masses.h"

#include <string>

namespace gelenk {

using Eigen::Vector3d;

namespace {

constexpr double bodyMass = 73.0;                 // kg
constexpr double stature = 1.73, source = 1.741;  // metres: of the figure; of de Leva's males

/// A limb's segment between two joints of the figure.
struct Limb {
  const char* from;
  const char* to;
  double share;   ///< of the body's mass
  double centre;  ///< of the way from the upper end to the lower
};
constexpr Limb limbs[] = {
    {"upperarm", "lowerarm", 0.0271, 0.5772}, {"lowerarm", "hand", 0.0162, 0.4574},
    {"hand", "middle_01", 0.0061, 0.7900},    {"thigh", "calf", 0.1416, 0.4095},
    {"calf", "foot", 0.0433, 0.4459},
};
constexpr double footShare = 0.0137, footCentre = 0.4415, footLength = 0.2581 * stature / source;

/// The trunk above the hips' middle, part by part upwards: its length and where the centre lies from the
/// upper end.
struct TrunkPart {
  const char* joint;
  double length, share, centre;
};
constexpr TrunkPart trunk[] = {{"pelvis", 0.1457, 0.1117, 0.6115},
                               {"spine_02", 0.2155, 0.1633, 0.4502},
                               {"spine_03", 0.1707, 0.1596, 0.2999}};
constexpr double headShare = 0.0694, headCentre = 0.5002;  // from the vertex to the seventh vertebra

}  // namespace

Masses mannequinMasses(const Skeleton& skeleton) {
  const Frames rest = restFrames(skeleton);
  const auto n = static_cast<std::size_t>(skeleton.jointCount());
  Masses masses{std::vector<double>(n, 0.0), std::vector<Vector3d>(n, Vector3d::Zero())};
  const auto at = [&](const std::string& name) -> Vector3d {
    return rest[skeleton.jointIndex(name)].translation();
  };
  const auto put = [&](const std::string& name, double share, const Vector3d& centre) {
    const int joint = skeleton.jointIndex(name);
    masses.mass[joint] = share * bodyMass;
    masses.centre[joint] = rest[joint].inverse() * centre;
  };
  for (const std::string side : {"_l", "_r"}) {
    for (const Limb& limb : limbs) {
      const Vector3d from = at(limb.from + side), to = at(limb.to + side);
      put(limb.from + side, limb.share, from + limb.centre * (to - from));
    }
    const Vector3d toe = at("toe_end" + side), ankle = at("foot" + side);
    const Vector3d centre(0.5 * (toe.x() + ankle.x()), 0.5 * ankle.y(),
                          toe.z() - (1.0 - footCentre) * footLength);
    put("foot" + side, footShare, centre);
  }
  const Vector3d hips = 0.5 * (at("thigh_l") + at("thigh_r")), neck = at("neck_01");
  const Vector3d upwards = (neck - hips) / (neck - hips).y();  // a metre of height along the spine
  double height = 0.0;
  for (const TrunkPart& part : trunk) {
    const double length = part.length * stature / source;
    put(part.joint, part.share, hips + (height + (1.0 - part.centre) * length) * upwards);
    height += length;
  }
  const Vector3d top = at("head_end");
  put("head", headShare, top + headCentre * (neck - top));
  return masses;
}

std::vector<FootPoint> mannequinSoles(const Skeleton& skeleton) {
  constexpr double halfHeel = 0.03, halfBall = 0.045;  // metres, from the middle line
  const Frames rest = restFrames(skeleton);
  std::vector<FootPoint> points;
  for (const std::string side : {"_l", "_r"}) {
    const int foot = skeleton.jointIndex("foot" + side);
    const Vector3d ankle = rest[foot].translation(),
                   ball = rest[skeleton.jointIndex("ball" + side)].translation(),
                   toe = rest[skeleton.jointIndex("toe_end" + side)].translation();
    const double heel = toe.z() - footLength;
    for (const Vector3d& point :
         {Vector3d(ankle.x() - halfHeel, 0, heel), Vector3d(ankle.x() + halfHeel, 0, heel),
          Vector3d(ball.x() - halfBall, 0, ball.z()), Vector3d(ball.x() + halfBall, 0, ball.z()),
          Vector3d(toe.x(), 0, toe.z())})
      points.push_back({foot, rest[foot].inverse() * point});
  }
  return points;
}

}  // namespace gelenk
