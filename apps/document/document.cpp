#include "apps/document/document.h"

#include <array>
#include <stdexcept>
#include <utility>

namespace gelenk {

const char* toString(GoalState state) {
  switch (state) {
    case GoalState::Free: return "free";
    case GoalState::Held: return "held";
    case GoalState::Dragged: return "dragged";
    case GoalState::Pinned: return "pinned";
  }
  return "?";
}

std::span<const ViewOptionName> viewOptionNames() {
  static constexpr std::array names{
      ViewOptionName{&ViewOptions::skin, "skin", "skin"},
      ViewOptionName{&ViewOptions::wireframe, "wireframe", "wireframe"},
      ViewOptionName{&ViewOptions::skeleton, "skeleton", "skeleton"},
      ViewOptionName{&ViewOptions::weights, "weights", "weights"},
      ViewOptionName{&ViewOptions::jointFrames, "joint_frames", "joint frames"},
      ViewOptionName{&ViewOptions::limits, "limits", "limits"},
      ViewOptionName{&ViewOptions::handles, "handles", "handles"},
      ViewOptionName{&ViewOptions::ground, "ground", "ground"},
      ViewOptionName{&ViewOptions::shadow, "shadow", "shadow"},
      ViewOptionName{&ViewOptions::velocityEllipsoid, "velocity_ellipsoid", "velocity ellipsoid"},
      ViewOptionName{&ViewOptions::forceEllipsoid, "force_ellipsoid", "force ellipsoid"},
      ViewOptionName{&ViewOptions::reachable, "reachable", "reachable set"},
      ViewOptionName{&ViewOptions::solutions, "solutions", "all solutions"},
      ViewOptionName{&ViewOptions::nullSpace, "null_space", "self-motion (null space)"},
      ViewOptionName{&ViewOptions::convergence, "convergence", "convergence map"},
  };
  return names;
}

bool ViewOptions::*viewOption(const std::string& name) {
  std::string known;
  for (const ViewOptionName& shown : viewOptionNames()) {
    if (name == shown.name) return shown.option;
    known += (known.empty() ? "" : ", ") + std::string(shown.name);
  }
  throw std::invalid_argument("'" + name + "' cannot be shown; there are: " + known);
}

void chooseSkin(Document& document, const Model& model, SkinChoice choice) {
  const SkinLayers layers = std::exchange(choice.layers, SkinLayers::None);
  if (layers != SkinLayers::None) {
    if (!document.edits.muscles)
      throw std::invalid_argument("'" + model.name +
                                  "' has no limb of a known name (upperarm_l, lowerarm_l, hand_l, ...) that "
                                  "could carry layers");
    MuscleSettings settings = *document.edits.muscles;
    settings.enabled = true;
    if (layers == SkinLayers::Volumes) {
      const std::vector<Limb> limbs = limbsOf(model);
      for (std::size_t l = 0; l < limbs.size(); ++l)
        settings.limbs[l].second.control = noMuscleControl(limbs[l]);
    }
    document.edits.muscles = std::make_shared<MuscleSettings>(std::move(settings));
  }
  document.skin = choice;
}

SkinChoice chosenSkin(const Document& document) {
  SkinChoice choice = document.skin;
  const auto& muscles = document.edits.muscles;
  if (muscles && muscles->enabled) choice.layers = SkinLayers::Muscles;
  return choice;
}

Document newDocument(const Model& model, ModelReference reference) {
  Document document{.model = std::move(reference)};
  document.edits.q = model.skeleton.rest();
  document.skin = model.skinning;
  if (model.skin) {
    document.edits.weights = SharedRows<Influences>(model.skin->influences);
    if (auto muscles = defaultMuscleSettings(limbsOf(model)); !muscles.limbs.empty())
      document.edits.muscles = std::make_shared<MuscleSettings>(std::move(muscles));
  }
  document.view.show.skeleton = !model.skin;
  document.view.show.ground = !model.planar;
  document.view.camera.up = model.planar ? Eigen::Vector3d::UnitZ() : model.up;
  document.view.camera.orthographic = model.planar;
  document.view.camera =
      lookFrom(document.view.camera, model.planar ? StandardView::Top : StandardView::ThreeQuarter);
  return document;
}

}  // namespace gelenk
