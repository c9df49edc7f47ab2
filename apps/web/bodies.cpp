// Makes the figure's body and packs it for the page: bodies FOLDER FILE, the folder for what is kept while
// building.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "apps/document/model_files.h"
#include "apps/web/packed_body.h"
#include "kinematics/io/text_file.h"

int main(int argc, char** argv) {
  try {
    if (argc != 3) throw std::invalid_argument("usage: bodies FOLDER FILE");
    setenv("XDG_CACHE_HOME", argv[1], 1);
    const gelenk::Model model = gelenk::readModel({.nameOrFile = "figure"});
    const std::string packed = gelenk::packBody(*model.skin, model.skeleton);
    const gelenk::Skin again = gelenk::unpackBody(packed, model.skeleton);
    if (again.mesh.triangles != model.skin->mesh.triangles) throw std::runtime_error("other triangles");
    double place = 0.0, weight = 0.0;
    for (std::size_t v = 0; v < again.mesh.positions.size(); ++v) {
      place = std::max(place, (again.mesh.positions[v] - model.skin->mesh.positions[v]).norm());
      for (int j = 0; j < again.jointCount(); ++j) {
        double difference = 0.0;
        for (int k = 0; k < 4; ++k) {
          const gelenk::Influences &a = again.influences[v], &b = model.skin->influences[v];
          difference += (a.joints[k] == j) * a.weights[k] - (b.joints[k] == j) * b.weights[k];
        }
        weight = std::max(weight, std::abs(difference));
      }
    }
    std::printf("figure: %zu bytes, places within %.1f um, weights within %.1e\n", packed.size(), 1e6 * place,
                weight);
    if (place > 1e-5 || weight > 1e-4) throw std::runtime_error("the packed body differs from the body");
    gelenk::writeFile(argv[2], packed);
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
