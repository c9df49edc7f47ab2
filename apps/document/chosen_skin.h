#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "apps/document/model.h"
#include "apps/document/muscle_settings.h"
#include "skinning/muscles/layered_blend.h"

namespace gelenk {

/// A skin by a choice of method and muscle layers, ready to be posed: what bakes, tables, comparisons and
/// points of the skin stand on.
class ChosenSkin {
 public:
  /// skin: of the model, or the same with edited weights. settings: proportions and muscles of the layers
  /// where the choice has any; null: the limbs' defaults. cache: see cachedPreparedSkin. Throws
  /// std::invalid_argument where layers are asked for and the model has no limb of a known name.
  ChosenSkin(const Model& model, const Skin& skin, const SkinChoice& choice,
             const MuscleSettings* settings = nullptr, const std::string& cache = "");

  const PreparedSkin& prepared() const { return *prepared_; }  ///< its layers left out
  const MuscleRig* rig() const { return rig_.get(); }          ///< null: without layers
  const LayeredSkin* layered() const { return layered_ ? &*layered_ : nullptr; }
  int jointCount() const { return prepared_->skin.jointCount(); }

  /// The same limbs with the same proportions, their muscles as set now.
  void setControls(const MuscleSettings& settings) {
    if (rig_) applyControls(*rig_, settings);
  }

  /// Positions and unit normals, world, metres. q: the configuration of the frames, where it is known.
  void pose(const Frames& worldFromJoint, const Eigen::VectorXd* q, SkinnedVertices& out,
            SkinNormals normals = SkinNormals::Gradients) const;
  /// The same of some vertices alone.
  ChosenSkin verticesOf(std::span<const int> vertices) const;

 private:
  ChosenSkin() = default;
  std::optional<PreparedSkin> prepared_;
  std::shared_ptr<MuscleRig> rig_;  ///< shared by all that were taken from it
  std::optional<LayeredSkin> layered_;
};

}  // namespace gelenk
