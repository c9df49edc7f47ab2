#include "apps/commands/baked_skin.h"

#include <fmt/format.h>

#include <stdexcept>

#include "apps/document/chosen_skin.h"
#include "skinning/io/baked_gltf.h"

namespace gelenk {

void writeBakedSkin(const std::string& path, const Model& model, const MuscleSettings* muscles) {
  if (!path.ends_with(".glb")) throw std::invalid_argument("--bake-skin writes a .glb, not '" + path + "'");
  if (!model.skin)
    throw std::invalid_argument("'" + model.name + "' has no body whose vertices could be written");
  const MotionClip pose{.framesPerSecond = 30.0, .q = model.skeleton.rest()};
  const MotionClip clip = model.clip.value_or(pose);
  const ChosenSkin skin(model, *model.skin, model.skinning, muscles);
  writeBakedGltf(path, model.skin->mesh, clip.frameCount(), clip.framesPerSecond, [&](int frame) {
    const Eigen::VectorXd q = clip.q.col(frame);
    SkinnedVertices at;
    skin.pose(forwardKinematics(model.skeleton, q), &q, at);
    return at;
  });
  fmt::print("{}: {} vertices by {}, {} frame{} at {:.6g} Hz\n", path, model.skin->mesh.positions.size(),
             toString(model.skinning), clip.frameCount(), clip.frameCount() == 1 ? "" : "s",
             clip.framesPerSecond);
}

}  // namespace gelenk
