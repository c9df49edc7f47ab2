#include "apps/document/chosen_skin.h"

#include <stdexcept>

#include "skinning/io/prepared_cache.h"

namespace gelenk {

ChosenSkin::ChosenSkin(const Model& model, const Skin& skin, const SkinChoice& choice,
                       const MuscleSettings* given, const std::string& cache) {
  const Frames bound = bindFrames(model);
  prepared_ = cachedPreparedSkin(cache, model.name, skin, choice, model.skeleton, bound);
  if (choice.layers == SkinLayers::None) return;
  const std::vector<Limb> limbs = limbsOf(model);
  if (limbs.empty())
    throw std::invalid_argument("'" + toString(choice) + "': '" + model.name +
                                "' has no limb of a known name (upperarm_l, lowerarm_l, hand_l, ...)");
  MuscleSettings settings = given && !given->limbs.empty() ? *given : defaultMuscleSettings(limbs);
  if (choice.layers == SkinLayers::Volumes)
    for (std::size_t l = 0; l < limbs.size(); ++l)
      settings.limbs[l].second.control = noMuscleControl(limbs[l]);
  rig_ = std::make_shared<MuscleRig>(makeMuscleRig(model, prepared_->skin, settings));
  layered_ = prepareLayers(rig_->body(), *prepared_->method, bound, prepared_->spread);
}

void ChosenSkin::pose(const Frames& worldFromJoint, const Eigen::VectorXd* q, SkinnedVertices& out,
                      SkinNormals normals) const {
  if (layered_)
    skinWithMuscles(*layered_, worldFromJoint, rig_->pose(worldFromJoint, q), out, q, normals);
  else
    blendSkin(*prepared_, poseBones(*prepared_, worldFromJoint, q), out, normals);
}

ChosenSkin ChosenSkin::verticesOf(std::span<const int> vertices) const {
  ChosenSkin some;
  some.prepared_ = gelenk::verticesOf(*prepared_, vertices);
  some.rig_ = rig_;
  if (layered_) some.layered_ = gelenk::verticesOf(*layered_, vertices);
  return some;
}

}  // namespace gelenk
