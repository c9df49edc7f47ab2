#pragma once

#include <vector>

#include "apps/document/camera.h"
#include "apps/render/label_places.h"
#include "apps/render/scene_label.h"
#include "apps/render/ui_style.h"

namespace gelenk {

/// What words over a picture are written with.
struct LabelPen {
  ImDrawList* draw;
  const Palette& colours;
  ImFont* font;
  float size;  ///< of the type, pixels
  float scale;
  LabelPlaces* places;
};

/// The colour of what words name, lighter where the panels are dark, so that they can be read: the blue of an
/// axis or of a solver.
ImVec4 inkOf(const ImVec4& colour, const Palette& palette);

/// Where there is room for words in a picture, which leave the edges of a planar one to its rulers. corner:
/// the picture's upper left one in what is drawn into, pixels.
LabelPlaces roomForLabels(ImVec2 corner, const Viewport& viewport, bool planar, float scale);

/// At the point, or as near to it as there is room; nothing where there is none.
void writeWords(const LabelPen& pen, ImVec2 at, const ImVec4& colour, const std::string& text,
                bool isFormula = false);
/// Beside the points, as the camera sees them.
void writeLabels(const LabelPen& pen, const std::vector<SceneLabel>& labels, const Camera& camera,
                 const Viewport& viewport, ImVec2 corner);

/// Writes the labels of a scene into a picture where no window does it. Needs a current context; no other
/// Dear ImGui may be in use.
class LabelWriter {
 public:
  LabelWriter(Theme theme, float scale);
  ~LabelWriter();
  LabelWriter(const LabelWriter&) = delete;
  LabelWriter& operator=(const LabelWriter&) = delete;

  /// framebuffer: a plain 8-bit one, as large as the viewport.
  void write(const std::vector<SceneLabel>& labels, const Camera& camera, const Viewport& viewport,
             bool planar, unsigned framebuffer);

 private:
  Theme theme_;
  float scale_;
  Fonts fonts_;
};

}  // namespace gelenk
