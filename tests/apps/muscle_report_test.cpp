#include "apps/muscle_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "kinematics/configuration.h"
#include "skinning/io/obj.h"
#include "skinning/muscle_fit.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

const std::string bodies = std::string(GELENK_DATA_DIR) + "/characters/makehuman/";

/// A limb cut out of the trial body, with the artist's weights: three joints by name, resting as the rig rests.
struct TrialLimb {
  Skeleton skeleton;
  Skin skin;
};

struct RigBone {
  int index;
  Vector3d head;
};

std::map<std::string, RigBone> readRig() {
  std::map<std::string, RigBone> bones;
  std::ifstream rig(bodies + "mh_male.game_engine.skel.txt");
  for (std::string line; std::getline(rig, line);) {
    std::istringstream words(line);
    int index, parent;
    std::string bone;
    Vector3d head;
    if (words >> index >> bone >> parent >> head.x() >> head.y() >> head.z()) bones[bone] = {index, head};
  }
  return bones;
}

/// Per body vertex (joint of the chain, weight): joint 0 is the trunk, i + 1 the chain's i-th, and what lies below the chain
/// moves with its last joint.
SparseWeights readBodyWeights(const std::map<std::string, RigBone>& bones, const std::vector<std::string>& chain,
                              const std::vector<std::string>& below) {
  std::map<int, int> jointOfBone;
  for (std::size_t i = 0; i < chain.size(); ++i) jointOfBone[bones.at(chain[i]).index] = static_cast<int>(i) + 1;
  for (const auto& [name, bone] : bones)
    for (const std::string& part : below)
      if (name.starts_with(part)) jointOfBone[bone.index] = static_cast<int>(chain.size());
  SparseWeights weights;
  std::ifstream file(bodies + "weights.game_engine.txt");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    int n = 0, bone = 0;
    double weight = 0.0;
    words >> n;
    auto& row = weights.emplace_back();
    while (n-- > 0 && words >> bone >> weight) row.emplace_back(jointOfBone.count(bone) ? jointOfBone[bone] : 0, weight);
  }
  return weights;
}

TrialLimb trialLimb(const std::string& name, const std::vector<std::string>& chain, const std::vector<std::string>& below) {
  const auto bones = readRig();
  std::vector<Joint> joints{Joint{.name = "trunk"}};
  joints[0].parentFromZero.translation() = bones.at(chain[0]).head;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    Joint joint{.name = chain[i], .parent = static_cast<int>(i), .ball = true};
    if (i > 0) joint.parentFromZero.translation() = bones.at(chain[i]).head - bones.at(chain[i - 1]).head;
    joints.push_back(joint);
  }
  const Skeleton skeleton(joints);

  const SparseWeights bodyWeights = readBodyWeights(bones, chain, below);
  const Mesh mesh = readObj(bodies + name + ".obj");
  SparseWeights weights;
  std::ifstream map(bodies + name + ".map.txt");
  for (std::string line; std::getline(map, line);) {
    if (line.starts_with('#')) continue;
    const int source = std::stoi(line);
    const Vector3d& x = mesh.positions[weights.size()];
    const bool top = (x - bones.at(chain.front()).head).norm() < (x - bones.at(chain.back()).head).norm();
    if (source >= 0)
      weights.push_back(bodyWeights[source]);
    else  // the middle of a cap: with the nearer end
      weights.push_back({{top ? 1 : static_cast<int>(chain.size()) - 1, 1.0}});
  }
  return {skeleton, bindSkin(mesh, restFrames(skeleton), fourLargest(weights, skeleton.jointCount()))};
}

struct TrialCase {
  const char* name;
  std::vector<std::string> chain, below;
  double gap;  ///< as standardLimbs gives arms and legs

  Limb limb(const Skeleton& skeleton) const {
    Limb made = makeLimb(skeleton, restFrames(skeleton), name, {1, 2, 3});
    setJointGap(made.shape, gap);
    return made;
  }
};

void PrintTo(const TrialCase& trial, std::ostream* out) { *out << trial.name; }

class TrialLimbs : public ::testing::TestWithParam<TrialCase> {};

TEST_P(TrialLimbs, LayerKeepsWhatLinearBlendingLoses) {
  if (!std::filesystem::exists(bodies)) GTEST_SKIP() << "trial data not found in " << bodies;
  const TrialLimb limb = trialLimb(GetParam().name, GetParam().chain, GetParam().below);
  const Limb layer = GetParam().limb(limb.skeleton);
  const auto rows = measureLimb(limb.skeleton, limb.skin, layer, [](double) {});
  if (std::getenv("GELENK_PRINT")) std::printf("%s", toCsv(rows).c_str());
  const auto at = [&](const char* motion, const char* method, double degrees) {
    return *std::find_if(rows.begin(), rows.end(), [&](const DeformationRow& row) {
      return row.motion == motion && row.method == method && row.degrees == degrees;
    });
  };
  EXPECT_GT(at("bend", "lbs", 90).intersectingPairs, 0);
  for (double degrees = 0; degrees <= 130; degrees += 10)
    for (const char* method : {"ffd", "ffd-volume", "ffd-muscle"}) {
      EXPECT_EQ(at("bend", method, degrees).intersectingPairs, 0) << method << " at " << degrees;
      EXPECT_GT(at("bend", method, degrees).smallestDet, 0.0) << method << " at " << degrees;
    }
  for (const DeformationRow& row : rows)
    if (row.method == "ffd-volume" || row.method == "ffd-muscle") {
      EXPECT_NEAR(row.volume, 1.0, 1e-6) << row.motion << " " << row.degrees;
    }
  EXPECT_GT(at("twist-second", "ffd", 170).smallestSection, at("twist-second", "lbs", 170).smallestSection);
}

/// Sculpted displacements of the trial body by name, then by body vertex.
std::map<std::string, std::map<int, Vector3d>> readMorphs() {
  std::map<std::string, std::map<int, Vector3d>> morphs;
  std::ifstream file(bodies + "muscle_morphs.txt");
  std::map<int, Vector3d>* current = nullptr;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string first, name;
    int vertex = 0;
    Vector3d d;
    if (line.starts_with("morph") && words >> first >> name)
      current = &morphs[name];
    else if (current && words >> vertex >> d.x() >> d.y() >> d.z())
      (*current)[vertex] = d;
  }
  return morphs;
}

TEST_P(TrialLimbs, MoreFreedomFitsTheSculptedMuscleBetter) {
  if (!std::filesystem::exists(bodies)) GTEST_SKIP() << "trial data not found in " << bodies;
  const TrialLimb limb = trialLimb(GetParam().name, GetParam().chain, GetParam().below);
  const Frames rest = restFrames(limb.skeleton);
  const MuscleSkin body = bindMuscles(limb.skin, {GetParam().limb(limb.skeleton)}, rest);
  std::vector<int> source;
  std::ifstream map(bodies + GetParam().name + ".map.txt");
  for (std::string line; std::getline(map, line);)
    if (!line.starts_with('#')) source.push_back(std::stoi(line));
  int fitted = 0;
  for (const auto& [name, morph] : readMorphs()) {
    std::vector<Vector3d> displacement(source.size(), Vector3d::Zero());
    for (std::size_t v = 0; v < source.size(); ++v)
      if (morph.count(source[v])) displacement[v] = morph.at(source[v]);
    const auto fit = [&](MuscleFreedom freedom) { return fitMuscle(body, 0, rest, displacement, freedom); };
    const MuscleFit scale = fit(MuscleFreedom::Scale);
    if (scale.vertices < 50) continue;
    ++fitted;
    const MuscleFit offset = fit(MuscleFreedom::ScaleAndOffset), points = fit(MuscleFreedom::FreePoints);
    std::printf("%-32s %4d vertices: residual of rms: scale %.1f %%, scale and offset %.1f %%, free points %.1f %%\n", name.c_str(),
                scale.vertices, 100 * scale.residual, 100 * offset.residual, 100 * points.residual);
    EXPECT_LT(offset.residual, scale.residual);
    EXPECT_LT(points.residual, offset.residual);
    EXPECT_LT(points.residual, 0.5);

    // The states that come back do what the fit says: pose the limb with them and measure.
    const LimbPose pose = poseLimb(body.limbs[0].shape, limbFrames(body.limbs[0], rest), points.states);
    double left = 0.0, all = 0.0;
    for (std::size_t v = 0; v < source.size(); ++v) {
      if (body.vertices[v].volume < 0 || body.vertices[v].limb != 0 || displacement[v].norm() == 0.0) continue;
      left += (deformLimbPoint(pose, body.vertices[v]) - body.skin.mesh.positions[v] - displacement[v]).squaredNorm();
      all += displacement[v].squaredNorm();
    }
    EXPECT_NEAR(std::sqrt(left / all), points.residual, 1e-9);
  }
  EXPECT_GT(fitted, 0);
}

INSTANTIATE_TEST_SUITE_P(OfTheTrialBody, TrialLimbs,
                         ::testing::Values(TrialCase{"arm_left", {"upperarm_l", "lowerarm_l", "hand_l"},
                                                     {"index", "middle", "ring", "pinky", "thumb"}, elbowGap},
                                           TrialCase{"leg_left", {"thigh_l", "calf_l", "foot_l"}, {"ball"}, kneeGap}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace gelenk
