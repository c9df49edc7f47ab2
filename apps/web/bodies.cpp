// Makes the figure's body and what its skinning method prepares, and packs both for the page: bodies FOLDER
// FILE, the folder for what is kept while building.
#include <cstdio>
#include <cstdlib>
#include <random>
#include <stdexcept>

#include "apps/document/model_files.h"
#include "apps/web/packed_body.h"
#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "skinning/blend/skin_choice.h"

using namespace gelenk;

namespace {

/// Largest differences: of places, and of the sums of absolute weight differences of a vertex.
struct Differences {
  double place = 0.0, weight = 0.0;

  void places(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
    for (std::size_t v = 0; v < a.size(); ++v) place = std::max(place, (a[v] - b.at(v)).norm());
  }
  void weights(const std::vector<Influences>& a, const std::vector<Influences>& b, int joints) {
    for (std::size_t v = 0; v < a.size(); ++v) {
      std::vector<double> difference(joints, 0.0);
      for (int k = 0; k < 4; ++k) {
        difference[a[v].joints[k]] += a[v].weights[k];
        difference[b.at(v).joints[k]] -= b[v].weights[k];
      }
      double sum = 0.0;
      for (const double d : difference) sum += std::abs(d);
      weight = std::max(weight, sum);
    }
  }
  void hold(const char* what, double placeBound, double weightBound) const {
    std::printf("%s: places within %.1f um, weights within %.1e\n", what, 1e6 * place, weight);
    if (!(place <= placeBound && weight <= weightBound))
      throw std::runtime_error("what was packed differs from what was made");
  }
};

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 3) throw std::invalid_argument("usage: bodies FOLDER FILE");
    setenv("XDG_CACHE_HOME", argv[1], 1);
    const Model model = readModel({.nameOrFile = "figure"});
    const std::string body = packBody(*model.skin);
    std::string_view rest = body;
    const Skin skin = unpackBody(rest, model.skeleton);
    if (skin.mesh.triangles != model.skin->mesh.triangles) throw std::runtime_error("other triangles");
    Differences made;
    made.places(skin.mesh.positions, model.skin->mesh.positions);
    made.weights(skin.influences, model.skin->influences, skin.jointCount());
    made.hold("body", 1e-5, 1e-4);

    // What the page would prepare of this body by itself.
    const PreparedSkin fresh = prepareSkin(skin, model.skinning, model.skeleton, bindFrames(model));
    const std::string packed = packPrepared(model.skinning, fresh);
    const auto [choice, again] = unpackPrepared(packed, skin, model.skeleton);
    if (choice != model.skinning) throw std::runtime_error("another skinning");
    PreparedSkin kept = fresh;
    kept.skin = again.skin;
    kept.centres = again.centres;
    kept.centreSlopes = again.centreSlopes;
    Differences prepared, posed;
    prepared.places(kept.centres, fresh.centres);
    prepared.weights(kept.skin.influences, fresh.skin.influences, skin.jointCount());
    prepared.hold("prepared", 1e-5, 1e-4);
    std::mt19937_64 random(1);
    const Frames pose = forwardKinematics(model.skeleton, randomWithinLimits(model.skeleton, random));
    posed.places(blendSkin(kept, pose).positions, blendSkin(fresh, pose).positions);
    posed.hold("posed", 2e-5, 0.0);

    writeFile(argv[2], body + packed);
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
