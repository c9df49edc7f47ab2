#pragma once

#include <imgui.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/lecture/example.h"
#include "apps/render/lecture_drawing.h"
#include "apps/sandbox/sandbox.h"

/// The scene of every topic of lectureTopics(), by its id; in lecture_*_scenes.cpp.
#define GELENK_LECTURE_SCENES(ROW)              \
  ROW("planar-fk", makeForwardScene)            \
  ROW("two-link", makeTwoLinkScene)             \
  ROW("newton-1d", makeOneDimensionScene)       \
  ROW("newton-square", makeNewtonSquareScene)   \
  ROW("pseudo-inverse", makePseudoInverseScene) \
  ROW("shortest", makeShortestScene)            \
  ROW("rotations", makeRotationsScene)          \
  ROW("dh", makeDhScene)                        \
  ROW("leg", makeLegScene)

namespace gelenk {

/// One example of the lecture as a scene: it opens its model, shows its drawing in the view and its controls
/// in the inspector. Called by the Lecture panel alone.
class LectureScene {
 public:
  virtual ~LectureScene() = default;

  virtual void open(Sandbox& sandbox) = 0;                    ///< model, pose, goals, camera
  virtual void step(Sandbox&, double /*seconds*/) {}          ///< before the frame's solve
  virtual bool moves(const Sandbox&) const { return false; }  ///< something changes by itself
  virtual void drawInspector(Sandbox&) {}                     ///< values and controls
  virtual bool hasPlot() const { return false; }
  /// The example's derivation with the values of the scene as it stands (derivations.h).
  virtual std::string derivation(Sandbox&) = 0;
  virtual void drawPlot(Sandbox&) {}                    ///< left of the derivation in the bottom strip
  virtual bool takesAnyModel() const { return false; }  ///< else only one with the joints of its own
  virtual bool changesModel() const { return false; }   ///< true while the scene itself opens another model
  virtual LectureDrawing& drawing() = 0;                ///< what it shows in the view, with its state
  /// As long as nobody turns or zooms the camera, what the scene framed stays in view, whatever its size.
  void keepInView(Sandbox& sandbox);
  virtual void taken(Sandbox&) {}  ///< after the drawing took up a document's state

 protected:
  /// Moves the camera so that the box fills the view.
  void frameView(Sandbox& sandbox, const Eigen::AlignedBox3d& box);

 private:
  struct Framed {
    Eigen::AlignedBox3d box;
    Camera camera;
    Viewport viewport;
  };
  std::optional<Framed> framed_;
};

/// The scene of a topic of lectureTopics(). Throws std::invalid_argument for another id.
std::unique_ptr<LectureScene> makeLectureScene(const std::string& topic);

#define GELENK_DECLARE(id, make) std::unique_ptr<LectureScene> make();
GELENK_LECTURE_SCENES(GELENK_DECLARE)
#undef GELENK_DECLARE

// Small things that the scenes share.

/// "phi_1   34.38" as a row: name dim on the left, value on the right.
void valueRow(Sandbox& sandbox, const std::string& name, const std::string& value);
void headingRow(Sandbox& sandbox, const char* words);
/// A matrix as aligned columns.
void matrixRows(Sandbox& sandbox, const std::string& name, const Eigen::MatrixXd& m, const char* format);
}  // namespace gelenk
