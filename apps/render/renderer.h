#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "apps/camera.h"
#include "apps/theme.h"
#include "skinning/gpu/skinned_mesh_gl.h"

namespace gelenk {

/// Linear-light or sRGB is a matter of where a colour is used: these are sRGB values in [0, 1], as a person picks them.
struct Colour {
  float r = 0, g = 0, b = 0, a = 1;
};

enum class SurfaceColour {
  Clay,    ///< the body's tint
  Scalars  ///< SkinnedMeshGl::setScalars through viridis
};

/// One posed body. The mesh must outlive the call of Renderer::draw.
struct BodyInstance {
  const SkinnedMeshGl* mesh = nullptr;
  const SkinPose* pose = nullptr;
  Colour tint = {0.80f, 0.76f, 0.71f, 1.0f};  ///< a < 1: a ghost, drawn after the solid bodies, without shadow
  SurfaceColour surface = SurfaceColour::Clay;
  bool wireframe = false;                     ///< the triangles' edges over the surface
  bool castsShadow = true;
};

/// Coloured geometry on top of or within the scene: bones, frames, cones, trails, handles, shaded areas. Widths are pixels of a
/// picture at scale 1. Within one list things are drawn in the order fills, lines, points.
class Overlay {
 public:
  enum class Point { Disc, Ring, Square };

  void line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Colour& colour, float width = 1.5f);
  void polyline(const std::vector<Eigen::Vector3d>& points, const Colour& colour, float width = 1.5f, bool closed = false);
  /// Dashes of equal length in the world, starting with a dash at a.
  void dashedLine(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double dash, const Colour& colour, float width = 1.5f);
  void point(const Eigen::Vector3d& at, const Colour& colour, float diameter = 8.0f, Point shape = Point::Disc);
  /// Unlit, two-sided.
  void triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Colour& colour);
  /// A fan around `centre`: limit cones, annulus sectors come from triangles and quads.
  void fan(const Eigen::Vector3d& centre, const std::vector<Eigen::Vector3d>& rim, const Colour& colour, bool closed = true);

  // Larger signs, made of the above.
  /// A slim octahedral bone, shaded by its own faces so that its form shows through a body.
  void bone(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double thickness, const Colour& colour);
  /// Red, green and blue axes of a frame.
  void axes(const Eigen::Isometry3d& worldFromFrame, double length, float width = 2.0f);
  /// A filled ring in the plane of u and v (unit, perpendicular): workspace annulus. inner may be 0; angles in radians.
  void annulus(const Eigen::Vector3d& centre, const Eigen::Vector3d& u, const Eigen::Vector3d& v, double inner, double outer,
               const Colour& colour, double fromAngle = 0.0, double toAngle = 6.283185307179586);

  void clear();
  bool empty() const { return fillVertices.empty() && lineSegments.empty() && points.empty(); }

  struct Vertex {
    float position[3];
    float colour[4];  ///< sRGB, straight alpha
  };
  struct Segment {
    Vertex a, b;
    float width;
  };
  struct Mark {
    Vertex at;
    float diameter;
    float shape;
  };
  std::vector<Vertex> fillVertices;  ///< three a triangle
  std::vector<Segment> lineSegments;
  std::vector<Mark> points;
};

struct GroundLook {
  bool visible = true;
  double height = 0.0;  ///< along the camera's up
  bool grid = true;
};

/// Everything that a picture shows, apart from the camera. Pointers must live until draw returns.
struct RenderScene {
  std::vector<BodyInstance> bodies;
  Eigen::AlignedBox3d bounds;       ///< of the bodies in their present pose; sets grid spacing, shadow and depth range
  Overlay overlay;                  ///< hidden by bodies in front of it
  Overlay overlayOnTop;             ///< drawn through everything
  GroundLook ground;
  Theme theme = Theme::Light;
  bool xray = false;                ///< bodies become translucent, so that an overlay within them shows
  bool shadows = true;
};

/// Draws a scene with light, shadow, ground and gradient background. Needs a current GL 3.3 core context, which must also be
/// current when it is destroyed.
/// State: draw() leaves the target framebuffer bound, the viewport set to the whole of it, and depth test, blending, culling,
/// scissor and sRGB encoding off, program, vertex array and textures unbound: what Dear ImGui expects to find.
class Renderer {
 public:
  Renderer();
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Draws into `framebuffer` (0: the window), which needs no depth buffer of its own: the picture is made in a target of the
  /// renderer's and copied, sRGB-encoded, so the framebuffer may be a plain 8-bit one. uiScale scales pixel widths.
  void draw(const RenderScene& scene, const Camera& camera, const Viewport& viewport, unsigned framebuffer, float uiScale = 1.0f);

  /// Multisampling of the renderer's own target: by default 4 on hardware, 0 on a software renderer.
  void setSamples(int samples);
  int samples() const;
  /// Draws at n times the size and averages: anti-aliasing for still pictures where there is no multisampling. 1 or 2.
  void setSupersampling(int n);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Box of the body in a pose, from one box a joint around the vertices that it carries mainly: cheap, and never much larger or
/// smaller than the exact box.
class PosedBounds {
 public:
  explicit PosedBounds(const Skin& skin);
  Eigen::AlignedBox3d operator()(const SkinPose& pose) const;

 private:
  std::vector<Eigen::AlignedBox3f> restBoxes_;  ///< of the vertices that each joint carries mainly; empty: none
};

/// viridis at t in [0, 1], sRGB: the perceptually uniform map of weights, residuals and manipulability.
Colour viridis(float t);

}  // namespace gelenk
