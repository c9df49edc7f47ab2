#include "apps/document/document.h"

#include <array>

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
      ViewOptionName{&ViewOptions::skin, "skin"},
      ViewOptionName{&ViewOptions::wireframe, "wireframe"},
      ViewOptionName{&ViewOptions::skeleton, "skeleton"},
      ViewOptionName{&ViewOptions::weights, "weights"},
      ViewOptionName{&ViewOptions::jointFrames, "joint_frames"},
      ViewOptionName{&ViewOptions::limits, "limits"},
      ViewOptionName{&ViewOptions::handles, "handles"},
      ViewOptionName{&ViewOptions::ground, "ground"},
      ViewOptionName{&ViewOptions::shadow, "shadow"},
  };
  return names;
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
