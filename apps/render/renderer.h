#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "apps/document/camera.h"
#include "apps/document/theme.h"
#include "apps/render/overlay.h"
#include "apps/render/scene_label.h"
#include "skinning/gpu/mesh_look_gl.h"
#include "skinning/gpu/skinned_mesh_gl.h"

namespace gelenk {

enum class SurfaceColour {
  Clay,   ///< the body's tint
  Vertex  ///< SkinnedMeshGl::setColours
};

/// One posed body. Mesh and pose must live until Renderer::draw returns.
struct BodyInstance {
  const SkinnedMeshGl* mesh = nullptr;
  const SkinPose* pose = nullptr;
  Colour tint = {0.88f, 0.83f, 0.77f,
                 1.0f};  ///< alpha < 1: a ghost, drawn after the solid bodies, without a shadow
  SurfaceColour surface = SurfaceColour::Clay;
  bool wireframe = false;  ///< the triangles' edges over the surface
  /// Colours of its parts, instead of the tint; parts of these names are not drawn.
  const MeshLookGl* look = nullptr;
  const std::set<std::string>* hidden = nullptr;
  float seeThrough = 1.0f;  ///< how far a translucent body gives way where it faces the viewer, 0 to 1
};

struct GroundLook {
  bool visible = true;
  bool grid = true;
  double height = 0.0;  ///< along the camera's up
};

/// Everything that a picture shows, apart from the camera.
struct RenderScene {
  std::vector<BodyInstance> bodies = {};
  Eigen::AlignedBox3d bounds =
      {};  ///< of what casts shadows, in its present pose (PosedBounds); sets shadow and depth range
  /// Typical length of the scene, which sets grid spacing and softness of light; 0: the diagonal of bounds.
  /// Give the rest pose's, so that the grid stays when bodies move.
  double size = 0.0;
  Overlay overlay = {};       ///< hidden by bodies in front of it
  Overlay overlayOnTop = {};  ///< seen through everything
  GroundLook ground = {};
  Theme theme = Theme::Light;
  /// Written over the picture by who shows it (label_writer.h).
  std::vector<SceneLabel> labels = {};
  bool xray = false;  ///< bodies become translucent, so that an overlay within them shows
  bool shadows = true;
  bool lightFromViewer =
      false;  ///< the key light stands to the viewer's upper left, not to that of the front view
};

/// Draws scenes with light, shadow, ground and gradient background. Needs a current OpenGL 3.3 core context,
/// which must also be current when it is destroyed.
///
/// State: draw() leaves `framebuffer` bound with the viewport over the whole of it; depth test, blending,
/// culling, scissor and sRGB encoding off; no program, vertex array or texture bound: as Dear ImGui expects
/// to find it.
class Renderer {
 public:
  Renderer();
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// The picture is made in a target of the renderer's own and copied, sRGB encoded, into `framebuffer` (0:
  /// the window): a plain 8-bit one that is not multisampled, at least as large as the viewport. pixelScale:
  /// pixels of the picture for one pixel of an overlay's width (the display's scale).
  void draw(const RenderScene& scene, const Camera& camera, const Viewport& viewport, unsigned framebuffer,
            float pixelScale = 1.0f);

  /// Multisampling of the renderer's own target; initially 4 on hardware and 0 on a software renderer.
  void setSamples(int samples);
  int samples() const;
  /// Draws n times as large both ways and averages: smooth edges for still pictures on any renderer. 1
  /// (initially) to 4.
  void setSupersampling(int n);
  /// While something moves on a software renderer: the ground's light in fewer texels.
  void setQuick(bool quick);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gelenk
