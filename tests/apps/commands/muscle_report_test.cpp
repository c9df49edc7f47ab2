#include "apps/commands/muscle_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "skinning/io/obj.h"
#include "skinning/muscles/muscle_fit.h"
#include "solvers/lab/report.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

const std::string bodies = testing::dataFolder() + "/characters/makehuman/";

/// A limb cut out of the trial body, with the artist's weights: three joints by name, resting as the rig
/// rests.
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

/// Per body vertex (joint of the chain, weight): joint 0 is the trunk, i + 1 the chain's i-th, and what lies
/// below the chain moves with its last joint.
SparseWeights readBodyWeights(const std::map<std::string, RigBone>& bones,
                              const std::vector<std::string>& chain, const std::vector<std::string>& below) {
  std::map<int, int> jointOfBone;
  for (std::size_t i = 0; i < chain.size(); ++i)
    jointOfBone[bones.at(chain[i]).index] = static_cast<int>(i) + 1;
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
    while (n-- > 0 && words >> bone >> weight)
      row.emplace_back(jointOfBone.count(bone) ? jointOfBone[bone] : 0, weight);
  }
  return weights;
}

TrialLimb trialLimb(const std::string& name, const std::vector<std::string>& chain,
                    const std::vector<std::string>& below) {
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

/// A sculpted muscle and what the three freedoms leave of its rms.
struct FittedMuscle {
  std::string name;
  MuscleFit scale, offset, points;
};

/// The trial body's sculpted muscles that move at least 50 vertices of the limb. check sees body,
/// displacement and fit of each.
std::vector<FittedMuscle> fitMuscles(const TrialCase& trial, const std::function<void(LimbShape&)>& vary,
                                     const std::function<void(const MuscleSkin&, const std::vector<Vector3d>&,
                                                              const FittedMuscle&)>& check = {}) {
  const TrialLimb trialBody = trialLimb(trial.name, trial.chain, trial.below);
  const Frames rest = restFrames(trialBody.skeleton);
  Limb limb = trial.limb(trialBody.skeleton);
  vary(limb.shape);
  const MuscleSkin body = bindMuscles(trialBody.skin, {limb}, rest);
  std::vector<int> source;
  std::ifstream map(bodies + trial.name + ".map.txt");
  for (std::string line; std::getline(map, line);)
    if (!line.starts_with('#')) source.push_back(std::stoi(line));
  std::vector<FittedMuscle> fitted;
  for (const auto& [name, morph] : readMorphs()) {
    std::vector<Vector3d> displacement(source.size(), Vector3d::Zero());
    for (std::size_t v = 0; v < source.size(); ++v)
      if (morph.count(source[v])) displacement[v] = morph.at(source[v]);
    const auto fit = [&](MuscleFreedom freedom) { return fitMuscle(body, 0, rest, displacement, freedom); };
    const MuscleFit scale = fit(MuscleFreedom::Scale);
    if (scale.vertices < 50) continue;
    fitted.push_back({name, scale, fit(MuscleFreedom::ScaleAndOffset), fit(MuscleFreedom::FreePoints)});
    if (check) check(body, displacement, fitted.back());
  }
  return fitted;
}

const TrialCase trialCases[] = {{"arm_left",
                                 {"upperarm_l", "lowerarm_l", "hand_l"},
                                 {"index", "middle", "ring", "pinky", "thumb"},
                                 elbowGap},
                                {"leg_left", {"thigh_l", "calf_l", "foot_l"}, {"ball"}, kneeGap}};

/// Three bars a muscle before the bands of the prototype.
std::string fitPlot(const std::vector<FittedMuscle>& muscles) {
  std::ostringstream script;
  script << "set title 'Sculpted muscle displacements: what the fit leaves'\nset ylabel '% of the "
            "displacement''s rms'\n"
            "set bmargin 4\nset yrange [0:90]\nset grid y lc rgb '#dddddd'\nset key inside top center "
            "horizontal\nset xtics scale 0\n"
            "set style fill solid 0.9 border rgb '#ffffff'\nset boxwidth 0.26\nset xrange [-0.6:"
         << muscles.size() - 0.4 << "]\n";
  const struct {
    const char *name, *colour;
    double lower, upper;
    MuscleFit FittedMuscle::*of;
  } freedoms[] = {{"scale", "#0072b2", 62, 72, &FittedMuscle::scale},
                  {"scale + offset", "#e69f00", 49, 63, &FittedMuscle::offset},
                  {"free control points", "#009e73", 13, 30, &FittedMuscle::points}};
  int object = 0;
  std::ostringstream plot;
  for (const auto& freedom : freedoms) {
    script << "set object " << ++object << " rectangle from graph 0, first " << freedom.lower
           << " to graph 1, first " << freedom.upper << " behind fillcolor rgb '" << freedom.colour
           << "' fillstyle solid 0.15 noborder\n";
    script << "$d" << object << " << EOD\n";
    for (std::size_t m = 0; m < muscles.size(); ++m) {
      std::string label = muscles[m].name;
      for (const auto& [theirs, ours] : {std::pair{"l-lowerarm", "forearm"},
                                         {"l-upperarm", "upper arm"},
                                         {"l-lowerleg", "shank"},
                                         {"l-upperleg", "thigh"},
                                         {"-muscle-incr", "\\nswelling"},
                                         {"-muscle-decr", "\\nshrinking"}})
        if (const auto at = label.find(theirs); at != std::string::npos)
          label.replace(at, std::string(theirs).size(), ours);
      script << m << ' ' << 100.0 * (muscles[m].*freedom.of).residual << " \"" << label << "\"\n";
    }
    script << "EOD\n";
    plot << (object == 1 ? "plot " : ", ") << "$d" << object << " using ($1"
         << (object == 1   ? "-0.28"
             : object == 2 ? "+0"
                           : "+0.28")
         << "):2" << (object == 2 ? ":xtic(3)" : "") << " with boxes lc rgb '" << freedom.colour
         << "' title '" << freedom.name << "'";
  }
  return script.str() + plot.str() +
         ", NaN with filledcurves lc rgb '#bbbbbb' title 'shaded: range of the prototype'\n";
}

/// GELENK_FIT_PLOT=FILE.svg draws the table.
TEST(TrialMuscles, MoreFreedomFitsTheSculptedMuscleBetter) {
  if (!std::filesystem::exists(bodies)) GTEST_SKIP() << "trial data not found in " << bodies;
  std::vector<FittedMuscle> all;
  for (const TrialCase& trial : trialCases) {
    const auto fitted = fitMuscles(
        trial, [](LimbShape&) {},
        [](const MuscleSkin& body, const std::vector<Vector3d>& displacement, const FittedMuscle& muscle) {
          EXPECT_LT(muscle.offset.residual, muscle.scale.residual);
          EXPECT_LT(muscle.points.residual, muscle.offset.residual);
          EXPECT_LT(muscle.points.residual, 0.5);
          // The states that come back do what the fit says: pose the limb with them and measure. The body
          // rests as it is bound.
          const Limb& limb = body.limbs[0];
          Frames rest;
          for (const Eigen::Isometry3d& jointFromWorld : body.skin.jointFromRestWorld)
            rest.push_back(jointFromWorld.inverse());
          const LimbPose pose = poseLimb(limb.shape, limbFrames(limb, rest), muscle.points.states);
          double left = 0.0, whole = 0.0;
          for (std::size_t v = 0; v < displacement.size(); ++v) {
            if (body.vertices[v].volume < 0 || body.vertices[v].limb != 0 || displacement[v].norm() == 0.0)
              continue;
            left += (deformLimbPoint(pose, body.vertices[v]) - body.skin.mesh.positions[v] - displacement[v])
                        .squaredNorm();
            whole += displacement[v].squaredNorm();
          }
          EXPECT_NEAR(std::sqrt(left / whole), muscle.points.residual, 1e-9);
        });
    EXPECT_EQ(fitted.size(), 4u);
    all.insert(all.end(), fitted.begin(), fitted.end());
  }
  for (const FittedMuscle& m : all)
    std::printf(
        "%-32s %4d vertices: residual of rms: scale %.1f %%, scale and offset %.1f %%, free points %.1f %%\n",
        m.name.c_str(), m.scale.vertices, 100 * m.scale.residual, 100 * m.offset.residual,
        100 * m.points.residual);
  if (const char* path = std::getenv("GELENK_FIT_PLOT")) {
    const std::string svg = plotSvg(fitPlot(all), 1000, 480);
    ASSERT_FALSE(svg.empty()) << "gnuplot is missing or failed";
    writeFile(path, svg);
  }
}

TEST(TrialMuscles, TheShankFitsBetterTheNearerItsFreePlanesStandToTheKnee) {
  if (!std::filesystem::exists(bodies)) GTEST_SKIP() << "trial data not found in " << bodies;
  const auto shank = [](double gap, double inner, double middle) {
    const auto fitted = fitMuscles(trialCases[1], [&](LimbShape& shape) {
      setJointGap(shape, gap);
      for (LimbShape::Link& link : shape.links) {
        link.inner = inner * link.length;
        link.middle = middle * link.length;
      }
    });
    const auto muscle = [&](const char* name) {
      return *std::ranges::find(fitted, std::string(name), &FittedMuscle::name);
    };
    const FittedMuscle calf = muscle("l-lowerleg-muscle-decr"), thigh = muscle("l-upperleg-muscle-incr");
    std::printf(
        "gap %.2f, inner %.3f L, middle %.2f L: shank %.1f %% and %.1f %%, thigh %.1f %% and %.1f %%\n", gap,
        inner, middle, 100 * calf.offset.residual, 100 * calf.points.residual, 100 * thigh.offset.residual,
        100 * thigh.points.residual);
    return calf.offset.residual;
  };
  const double asIs = shank(kneeGap, 0.1, 0.5);
  EXPECT_LT(shank(kneeGap, 0.125, 0.5), asIs);  // plane 2 nearer, plane 4 farther
  EXPECT_LT(shank(kneeGap, 0.1, 0.4), asIs - 0.05);
  EXPECT_LT(shank(kneeGap, 0.1, 0.35), asIs - 0.05);
  EXPECT_GT(shank(0.17, 0.1, 0.5), asIs + 0.05);  // plane 1, which cannot move, takes the place
}

INSTANTIATE_TEST_SUITE_P(OfTheTrialBody, TrialLimbs, ::testing::ValuesIn(trialCases),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace gelenk
