#pragma once

#include <memory>
#include <optional>

#include "apps/document/document.h"
#include "apps/document/model.h"
#include "apps/render/posed_bounds.h"
#include "apps/render/renderer.h"
#include "skinning/muscles/muscle_control.h"

namespace gelenk {

/// A model made ready to be drawn: its skin in GPU memory, the pose of the last picture, its size. Needs a
/// current context. The model must outlive it.
class ModelView {
 public:
  explicit ModelView(const Model& model);

  const Model& model() const { return *model_; }
  double size() const { return size_; }  ///< diagonal of the rest pose
  double groundHeight() const { return groundHeight_; }
  Eigen::AlignedBox3d bounds(const Frames& worldFromJoint) const;

  /// What the options ask for, in this pose: body, bones, joint frames, weights of the selected joint. q: nq.
  /// The scene points into this object and is valid until the next call.
  RenderScene compose(const Frames& worldFromJoint, const ViewOptions& options, Theme theme,
                      std::optional<int> selected = {});
  RenderScene compose(const Eigen::VectorXd& q, const ViewOptions& options, Theme theme,
                      std::optional<int> selected = {});

  /// Draws the skin with these muscle layers, and the lattice of every limb where asked for. nullptr:
  /// without.
  void setMuscles(std::shared_ptr<const MuscleRig> muscles, bool lattice);

  /// Seen from the model's usual direction (planar: from above), whole.
  Camera usualCamera(const Viewport& viewport) const;

 private:
  void showWeights(int joint);

  const Model* model_;
  std::optional<SkinnedMeshGl> mesh_;
  std::shared_ptr<const MuscleRig> muscles_;
  bool lattice_ = false;
  std::optional<PosedBounds> posedBounds_;
  SkinPose pose_;
  Eigen::AlignedBox3d restBounds_;
  double size_ = 1.0, groundHeight_ = 0.0;
  int shownWeights_ = -1;
};

}  // namespace gelenk
