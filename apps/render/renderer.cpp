#include "apps/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <optional>

#include "apps/render/facts.h"
#include "apps/render/overlay_gl.h"
#include "skinning/gpu/driver.h"
#include "skinning/gpu/render_target.h"

namespace gelenk {

using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr GLuint frameBinding = 2;
constexpr int depthBits = 24;       // of the picture's depth buffer
constexpr double ghostStep = 3e-4;  // from ghost to ghost, of the model's size
enum TextureUnit : GLint {
  ShadowMapUnit = 0,
  ShadowDepthUnit = 1,
  ContactUnit = 2,
  GroundLightUnit = 3,
  PictureUnit = 4
};

/// Mirrors frame.glsl (std140: every member is a multiple of 16 bytes); GLM's types are laid out as GLSL's.
struct FrameBlock {
  glm::mat4 clipFromWorld, worldFromClip, shadowFromWorld;
  glm::vec4 eye, towardsViewer, up, groundX, groundY, groundPatch, keyDirection, fillDirection;
  glm::vec4 keyLight, fillLight, skyLight, bounceLight, rimLight;
  glm::vec4 backgroundTop, backgroundBottom, groundColour, gridColour;
  glm::vec4 pictureSize;
};

glm::vec4 vec4(const Vector3d& v, double w = 0.0) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
          static_cast<float>(w)};
}

glm::mat4 mat4(const Matrix4d& m) {
  glm::mat4 result;
  Eigen::Map<Eigen::Matrix4f, Eigen::Unaligned>(glm::value_ptr(result)) = m.cast<float>();
  return result;
}

glm::vec4 linear(const Colour& colour, float scale = 1.0f) {
  const Eigen::Vector3f light = scale * linearLight(colour);
  return {light.x(), light.y(), light.z(), colour.a};
}

/// Colours as a person picks them; alpha of ground and grid: how strongly they show.
struct Palette {
  Colour key, fill, sky, bounce, rim;
  float keyPower, fillPower, skyPower, bouncePower, rimPower;
  Colour backgroundTop, backgroundBottom, ground, grid;
};

Palette palette(Theme theme) {
  if (theme == Theme::Dark)
    return {.key = {1.00f, 0.95f, 0.88f},
            .fill = {0.75f, 0.84f, 1.00f},
            .sky = {0.72f, 0.82f, 1.00f},
            .bounce = {0.80f, 0.76f, 0.74f},
            .rim = {0.70f, 0.82f, 1.00f},
            .keyPower = 0.80f,
            .fillPower = 0.16f,
            .skyPower = 0.24f,
            .bouncePower = 0.10f,
            .rimPower = 0.22f,
            .backgroundTop = {0.105f, 0.115f, 0.135f},
            .backgroundBottom = {0.20f, 0.215f, 0.24f},
            .ground = {0.235f, 0.25f, 0.275f, 0.9f},
            .grid = {0.42f, 0.45f, 0.49f, 0.55f}};
  return {.key = {1.00f, 0.95f, 0.87f},
          .fill = {0.84f, 0.90f, 1.00f},
          .sky = {0.84f, 0.90f, 1.00f},
          .bounce = {0.95f, 0.90f, 0.85f},
          .rim = {0.92f, 0.96f, 1.00f},
          .keyPower = 0.98f,
          .fillPower = 0.16f,
          .skyPower = 0.32f,
          .bouncePower = 0.17f,
          .rimPower = 0.20f,
          .backgroundTop = {0.80f, 0.835f, 0.87f},
          .backgroundBottom = {0.925f, 0.93f, 0.935f},
          .ground = {0.945f, 0.945f, 0.94f, 0.9f},
          .grid = {0.58f, 0.61f, 0.65f, 0.70f}};
}

/// Where light comes from and what it falls on, in world coordinates.
struct Lighting {
  double size;  ///< typical length of the scene
  Vector3d up, groundX, groundY;
  double groundHeight;
  Vector3d keyDirection, fillDirection;  ///< towards the lights
  Matrix4d shadowFromWorld;              ///< onto [0, 1]^3
  double shadowTexel, shadowDepth;
  Vector2d patchCentre;  ///< ground coordinates
  double patchHalf;
};

/// By the front view's axes with the given up, the key light comes from the viewer's left, above and before
/// the front.
Lighting lightingOf(const RenderScene& scene, const Camera& camera, int shadowPixels) {
  Lighting light{};
  const Eigen::AlignedBox3d box =
      scene.bounds.isEmpty()
          ? Eigen::AlignedBox3d(Vector3d(camera.target.array() - 0.5), Vector3d(camera.target.array() + 0.5))
          : scene.bounds;
  light.size = scene.size > 0.0 ? scene.size : std::max(box.diagonal().norm(), 1e-9);
  const Camera front = scene.lightFromViewer ? camera : Camera{.up = camera.up};
  const Eigen::Matrix3d axes = front.axes();
  light.up = camera.up;
  light.groundX = axes.col(0);
  light.groundY = -axes.col(2);
  light.groundHeight = scene.ground.height;
  light.keyDirection = (-0.52 * axes.col(0) + 1.05 * axes.col(1) + 0.62 * axes.col(2)).normalized();
  const Eigen::Matrix3d view = camera.axes();
  light.fillDirection = (0.75 * view.col(0) + 0.25 * view.col(1) + 0.6 * view.col(2)).normalized();

  // Shadow map: the box seen from the light, in steps so that it does not crawl when the box changes a
  // little.
  const Vector3d sx = light.up.cross(light.keyDirection).normalized(), sy = light.keyDirection.cross(sx);
  Eigen::AlignedBox3d inLight;
  Eigen::AlignedBox2d onGround;
  const double slope = light.keyDirection.dot(light.up);
  for (int i = 0; i < 8; ++i) {
    const Vector3d corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    inLight.extend(Vector3d(sx.dot(corner), sy.dot(corner), -light.keyDirection.dot(corner)));
    const double height = std::max(light.up.dot(corner) - light.groundHeight, 0.0);
    const Vector3d shadow = corner - height / slope * light.keyDirection;
    for (const Vector3d& p : {corner, shadow})
      onGround.extend(Vector2d(light.groundX.dot(p), light.groundY.dot(p)));
  }
  const double step = light.size / 16.0;
  const auto inSteps = [step](double length) { return step * std::ceil(length / step); };
  const double half = inSteps(0.5 * std::max(inLight.sizes().x(), inLight.sizes().y()) * 1.08);
  light.shadowTexel = 2.0 * half / shadowPixels;
  light.shadowDepth = 1.1 * inLight.sizes().z() + 1e-6 * light.size;
  Vector3d middle = inLight.center();
  for (int k = 0; k < 2; ++k) middle[k] = light.shadowTexel * std::round(middle[k] / light.shadowTexel);
  light.shadowFromWorld.setIdentity();
  light.shadowFromWorld.row(0) << sx.transpose() / (2.0 * half), 0.5 - middle.x() / (2.0 * half);
  light.shadowFromWorld.row(1) << sy.transpose() / (2.0 * half), 0.5 - middle.y() / (2.0 * half);
  light.shadowFromWorld.row(2) << -light.keyDirection.transpose() / light.shadowDepth,
      0.5 - middle.z() / light.shadowDepth;

  const double reach = 0.5 * onGround.sizes().maxCoeff() + 0.25 * light.size;
  light.patchHalf = inSteps(std::min(reach / 0.85, 4.0 * light.size));
  light.patchCentre = (onGround.center() / (step / 8.0)).array().round() * (step / 8.0);
  return light;
}

/// Half of what the picture shows upwards, at the distance of the box's nearest corner.
double nearestHalfHeight(const Camera& camera, const Eigen::AlignedBox3d& box) {
  if (camera.orthographic || box.isEmpty()) return camera.halfHeight();
  double nearest = camera.distance;
  for (int i = 0; i < 8; ++i)
    nearest = std::min(
        nearest,
        camera.axes().col(2).dot(camera.eye() - box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i))));
  return camera.halfHeight() * std::max(nearest, 1e-3 * camera.distance) / camera.distance;
}

Matrix4d clipOf(const RenderScene& scene, const Camera& camera, const Viewport& viewport,
                const Lighting& light) {
  return clipFromView(camera, viewport, depthRange(camera, scene.bounds, 6.0 * light.size)) *
         viewFromWorld(camera);
}

/// Units of glPolygonOffset for a metre at the camera's distance.
float depthUnits(const RenderScene& scene, const Camera& camera, const Lighting& light) {
  const DepthRange range = depthRange(camera, scene.bounds, 6.0 * light.size);
  const double near = range.near, far = range.far, d = camera.distance;
  const double perMetre = camera.orthographic ? 1.0 : near * far / (d * d);
  return static_cast<float>(std::ldexp(perMetre / (far - near), depthBits));
}

/// How far from the patch's centre the ground has faded: beyond what is below the eye, however far that is.
double groundRadius(const Lighting& light, const Camera& camera) {
  const Vector3d eye = camera.eye();
  const Vector2d below(light.groundX.dot(eye), light.groundY.dot(eye));
  return std::max(3.2 * light.size, camera.orthographic ? 0.0 : 1.5 * (below - light.patchCentre).norm());
}

/// The rows of the picture, from the lowest on, that show ground or its shadow: those below the highest point
/// of the circle around both. All of them from below the ground and where rays are parallel.
int groundRows(const Lighting& light, const Camera& camera, const Viewport& viewport,
               const RenderScene& scene) {
  constexpr int corners = 64;
  if (camera.orthographic || light.up.dot(camera.eye()) <= light.groundHeight) return viewport.height;
  const Matrix4d clipFromWorld = clipOf(scene, camera, viewport, light);
  const double radius =
      std::max(groundRadius(light, camera), std::sqrt(2.0) * light.patchHalf) / std::cos(M_PI / corners);
  double top = -1.0;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2.0 * M_PI * k / corners;
    const Vector2d on = light.patchCentre + radius * Vector2d(std::cos(angle), std::sin(angle));
    const Vector3d p = on.x() * light.groundX + on.y() * light.groundY + light.groundHeight * light.up;
    const Eigen::Vector4d clip = clipFromWorld * p.homogeneous();
    if (clip.w() > 0.0) top = std::max(top, clip.y() / clip.w());
  }
  return static_cast<int>(
      std::clamp(std::ceil((0.5 + 0.5 * top) * viewport.height) + 1.0, 0.0, double(viewport.height)));
}

/// Ten cells or more along the scene: a power of ten.
double gridSpacing(double size) { return std::pow(10.0, std::floor(std::log10(0.5 * size) + 1e-9)); }

FrameBlock frameBlock(const RenderScene& scene, const Camera& camera, const Viewport& viewport,
                      float pixelScale, const Lighting& light, bool shadows) {
  const Eigen::Matrix3d axes = camera.axes();
  const Matrix4d clipFromWorld = clipOf(scene, camera, viewport, light);
  const Palette colours = palette(scene.theme);
  return {.clipFromWorld = mat4(clipFromWorld),
          .worldFromClip = mat4(clipFromWorld.inverse()),
          .shadowFromWorld = mat4(light.shadowFromWorld),
          .eye = vec4(camera.eye(), camera.orthographic),
          .towardsViewer = vec4(axes.col(2), pixelScale),
          .up = vec4(light.up, light.groundHeight),
          .groundX = vec4(light.groundX, gridSpacing(light.size)),
          .groundY = vec4(light.groundY, groundRadius(light, camera)),
          .groundPatch = vec4({light.patchCentre.x(), light.patchCentre.y(), light.patchHalf}, shadows),
          .keyDirection = vec4(light.keyDirection, light.shadowTexel),
          .fillDirection = vec4(light.fillDirection, light.size),
          .keyLight = linear(colours.key, colours.keyPower),
          .fillLight = linear(colours.fill, colours.fillPower),
          .skyLight = linear(colours.sky, colours.skyPower),
          .bounceLight = linear(colours.bounce, colours.bouncePower),
          .rimLight = linear(colours.rim, colours.rimPower),
          .backgroundTop = linear(colours.backgroundTop),
          .backgroundBottom = linear(colours.backgroundBottom),
          .groundColour = linear(colours.ground),
          .gridColour = linear(colours.grid),
          .pictureSize = {static_cast<float>(viewport.width), static_cast<float>(viewport.height),
                          scene.ground.visible ? (scene.ground.grid ? 2.0f : 1.0f) : 0.0f, 0.0f}};
}

GlTexture mapTexture(GLenum internal, int width, int height, GLenum format, GLenum filter) {
  GlTexture texture = GlTexture::create();
  glBindTexture(GL_TEXTURE_2D, texture);
  const GLenum type = format == GL_DEPTH_COMPONENT ? GL_UNSIGNED_INT : GL_UNSIGNED_BYTE;
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal), width, height, 0, format, type, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(filter));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(filter));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glBindTexture(GL_TEXTURE_2D, 0);
  return texture;
}

GlFramebuffer framebufferOf(const GlTexture& texture, GLenum attachment, const char* what) {
  GlFramebuffer framebuffer = GlFramebuffer::create();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture, 0);
  if (attachment == GL_DEPTH_ATTACHMENT) {
    const GLenum none = GL_NONE;
    glDrawBuffers(1, &none);
    glReadBuffer(GL_NONE);
  }
  requireCompleteFramebuffer(what);
  return framebuffer;
}

void bindTexture(TextureUnit unit, GLuint texture, GLuint sampler = 0) {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(GL_TEXTURE_2D, texture);
  glBindSampler(unit, sampler);
  glActiveTexture(GL_TEXTURE0);
}

bool isLayered(const BodyInstance& body) { return body.mesh->hasLayers() && !body.pose->layers.empty(); }

/// Calls draw(part) for what is seen of a body with a look.
template <class Draw>
void eachPart(const BodyInstance& body, Draw&& draw) {
  for (const MeshLook::Part& part : body.look->look().parts)
    if (part.shown && part.triangleCount > 0 && !(body.hidden && body.hidden->count(part.name) > 0))
      draw(part);
}

/// Lets closed surfaces be drawn without the side that is not wanted.
class Culling {
 public:
  Culling(const BodyInstance& body, GLenum side) : on_(!body.look && body.mesh->isClosed()) {
    if (!on_) return;
    glEnable(GL_CULL_FACE);
    glCullFace(side);
  }
  ~Culling() {
    if (!on_) return;
    glCullFace(GL_BACK);
    glDisable(GL_CULL_FACE);
  }
  Culling(const Culling&) = delete;
  Culling& operator=(const Culling&) = delete;

 private:
  const bool on_;
};

/// The triangles, whatever they look like: for shadows. longestEdge above 0: a quarter of them or less, up to
/// such edges (metres), where that is possible, and without the side that the other one hides.
void drawShape(const BodyInstance& body, double longestEdge, GLenum hiddenSide) {
  if (longestEdge > 0.0 && !body.look) {
    const Culling culling(body, hiddenSide);
    const float quarter = 1.01f * body.mesh->coarseEdge();
    if (body.mesh->drawCoarse(std::max(static_cast<float>(longestEdge), quarter), isLayered(body))) return;
  }
  if (!body.look) return body.mesh->drawTriangles(isLayered(body));
  eachPart(body, [&](const MeshLook::Part& part) {
    body.mesh->drawTriangles(part.firstTriangle, part.triangleCount, isLayered(body));
  });
}

void setMaterial(const ShaderProgram& program, const Material& material) {
  glUniform4f(program.uniform("materialColour"), material.colour.x(), material.colour.y(),
              material.colour.z(), material.colour.w());
  glUniform2f(program.uniform("pictureUse"), material.texture >= 0 ? 1.0f : 0.0f, material.cutOff);
  glUniform1f(program.uniform("gloss"), material.gloss);
}

}  // namespace

struct Renderer::State {
  const bool software = isSoftwareRenderer();
  int shadowPixels = 0, patchPixels = 0;  ///< set by prepareMaps
  int samples = software ? 0 : 4;
  int supersampling = 1;
  bool quick = false;
  float pixelsPerMetre = 0.0f;               ///< of the picture, at the nearest place of the bodies
  std::string shadowsFrom, groundLightFrom;  ///< what they were drawn of; empty: not known
  bool groundLightIsOld = false;             ///< a picture later than what it was drawn of
  Vector2d groundLightCentre = Vector2d::Zero();
  double groundLightHalf = 0.0;

  std::map<std::string, ShaderProgram> programs;  ///< variants, made when first needed
  OverlayGl overlay{frameBinding};
  GlBuffer frame = GlBuffer::create();
  GlVertexArray noVertices = GlVertexArray::create();
  std::vector<PoseGl> poses;

  GlTexture shadowMap, contact, noisyGroundLight, groundLight;
  GlFramebuffer shadowBuffer, contactBuffer, noisyGroundLightBuffer, groundLightBuffer;
  /// Sampler objects: the shadow map with and without comparison.
  GLuint comparing = 0, plain = 0;

  RenderTarget large, resolved;
  float ghostOffset = 0.0f;           ///< polygon offset of a ghost, units
  GlTexture noisyOpenness, openness;  ///< of still pictures, a pixel of the picture each
  GlFramebuffer noisyOpennessBuffer, opennessBuffer;
  Viewport opennessSize{0, 0};

  State();
  ~State();
  const ShaderProgram& program(const std::string& name, const ProgramText& text);
  const ShaderProgram& bodyProgram(const std::string& name, const BodyInstance& body, bool wireframe = false,
                                   bool pictured = false);
  void prepareMaps(const RenderScene& scene, const Camera& camera);
  void prepareLight(const RenderScene& scene, Lighting& light, bool shadows,
                    const std::function<void()>& upload);
  std::string castersOf(const RenderScene& scene, const Lighting& light) const;
  void prepareTargets(const Viewport& viewport);
  void drawShadowMap(const RenderScene& scene, const Lighting& light);
  void drawGroundLight(const RenderScene& scene, const Lighting& light);
  void drawBodies(const RenderScene& scene, bool translucent);
  void drawBody(const RenderScene& scene, std::size_t index, bool translucent);
  void drawClay(const BodyInstance& body) const;
  void drawBackdrop(const Viewport& size, int groundRows);
  const RenderTarget& singleSampled(GLbitfield part) const;
  void darkenFolds(const Viewport& viewport);
  void copyTo(GLuint framebuffer, const Viewport& viewport);
};

Renderer::State::State() {
  glGenSamplers(1, &comparing);
  glGenSamplers(1, &plain);
  for (const GLuint sampler : {comparing, plain}) {
    // Casters end before the map's rim (lightingOf), so that what lies beyond is lit.
    glSamplerParameteri(sampler, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glSamplerParameteri(sampler, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glSamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, sampler == plain ? GL_NEAREST : GL_LINEAR);
    glSamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, sampler == plain ? GL_NEAREST : GL_LINEAR);
  }
  glSamplerParameteri(comparing, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glSamplerParameteri(comparing, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  glBindBuffer(GL_UNIFORM_BUFFER, frame);
  glBufferData(GL_UNIFORM_BUFFER, sizeof(FrameBlock), nullptr, GL_STREAM_DRAW);
  glBindBuffer(GL_UNIFORM_BUFFER, 0);
}

Renderer::State::~State() {
  glDeleteSamplers(1, &comparing);
  glDeleteSamplers(1, &plain);
}

const ShaderProgram& Renderer::State::program(const std::string& name, const ProgramText& text) {
  const auto known = programs.find(name);
  if (known != programs.end()) return known->second;
  ShaderProgram made(text);
  made.bindBlock("Pose", PoseGl::blockBinding);
  made.bindBlock("Layers", SkinnedMeshGl::layerBinding);
  made.bindBlock("Frame", frameBinding);
  made.bindSampler("poseRows", PoseGl::textureUnit);
  made.bindSampler("shadowMap", ShadowMapUnit);
  made.bindSampler("picture", PictureUnit);
  made.bindSampler("shadowDepth", ShadowDepthUnit);
  made.bindSampler("contact", ContactUnit);
  made.bindSampler("source", ContactUnit);
  made.bindSampler("depth", ContactUnit);
  made.bindSampler("groundLight", GroundLightUnit);
  return programs.emplace(name, std::move(made)).first->second;
}

/// name: the vertex shader, and but for depth the fragment shader. pictured: with texture or cut-outs.
const ShaderProgram& Renderer::State::bodyProgram(const std::string& name, const BodyInstance& body,
                                                  bool wireframe, bool pictured) {
  const std::string vertex = name + ".vert", fragment = (name == "depth" ? "nothing" : name) + ".frag";
  const bool withLook = name == "surface" && body.look && !wireframe;
  const std::string defines = (wireframe ? "WIREFRAME " : "") + std::string(withLook ? "LOOK " : "") +
                              (withLook && pictured ? "PICTURE " : "") +
                              poseDefines(*body.pose, isLayered(body));
  return program(name + " " + defines,
                 {.folder = rendererShaders(), .vertex = vertex, .fragment = fragment, .defines = defines});
}

/// Resolution of the light: fine for still pictures (supersampling) and on hardware, coarse where every texel
/// costs. In quick pictures a texel of the shadow need not be finer than a pixel.
void Renderer::State::prepareMaps(const RenderScene& scene, const Camera& camera) {
  constexpr int coarse = 512;
  const bool fine = !software || supersampling > 1;
  const double pixels = lightingOf(scene, camera, coarse).shadowTexel * pixelsPerMetre;
  const bool isEnough =
      quick && pixels < (shadowPixels == coarse ? 1.15 : 1.0);  // no flicker between the two
  const int shadow = fine ? 2048 : isEnough ? coarse : 1024, patch = fine ? 768 : quick ? 128 : 256;
  if (shadowPixels == shadow && patchPixels == patch) return;
  shadowsFrom.clear();
  groundLightFrom.clear();
  shadowPixels = shadow;
  patchPixels = patch;
  shadowMap = mapTexture(GL_DEPTH_COMPONENT24, shadowPixels, shadowPixels, GL_DEPTH_COMPONENT, GL_LINEAR);
  contact = mapTexture(GL_R8, patchPixels, patchPixels, GL_RED, GL_LINEAR);
  noisyGroundLight = mapTexture(GL_RG8, patchPixels, patchPixels, GL_RG, GL_LINEAR);
  groundLight = mapTexture(GL_RG8, patchPixels, patchPixels, GL_RG, GL_LINEAR);
  shadowBuffer = framebufferOf(shadowMap, GL_DEPTH_ATTACHMENT, "the shadow");
  contactBuffer = framebufferOf(contact, GL_COLOR_ATTACHMENT0, "the contact shadow");
  noisyGroundLightBuffer = framebufferOf(noisyGroundLight, GL_COLOR_ATTACHMENT0, "the ground's light");
  groundLightBuffer = framebufferOf(groundLight, GL_COLOR_ATTACHMENT0, "the ground's light");
}

void Renderer::State::prepareTargets(const Viewport& viewport) {
  const int n = supersampling, width = n * viewport.width, height = n * viewport.height;
  using Colour = RenderTarget::Colour;
  if (large.width() != width || large.height() != height || large.samples() != samples) {
    large = RenderTarget(width, height, Colour::Srgb8, samples);
    resolved = samples > 0 ? RenderTarget(width, height, Colour::Srgb8) : RenderTarget();
  }
}

void Renderer::State::drawShadowMap(const RenderScene& scene, const Lighting& light) {
  glBindFramebuffer(GL_FRAMEBUFFER, shadowBuffer);
  glViewport(0, 0, shadowPixels, shadowPixels);
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(2.0f, 2.0f);
  Matrix4d clipFromShadow = 2.0 * Matrix4d::Identity();
  clipFromShadow.col(3) << -1.0, -1.0, -1.0, 1.0;
  const glm::mat4 matrix = mat4(clipFromShadow * light.shadowFromWorld);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].tint.a < 1.0f) continue;
    const ShaderProgram& depth = bodyProgram("depth", scene.bodies[i]);
    depth.use();
    glUniformMatrix4fv(depth.uniform("clipFromWorldOfLight"), 1, GL_FALSE, glm::value_ptr(matrix));
    poses[i].bind();
    drawShape(scene.bodies[i], quick ? 8.0 * light.shadowTexel : 0.0, GL_BACK);
  }
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDisable(GL_DEPTH_TEST);
}

void Renderer::State::drawGroundLight(const RenderScene& scene, const Lighting& light) {
  glBindFramebuffer(GL_FRAMEBUFFER, contactBuffer);
  glViewport(0, 0, patchPixels, patchPixels);
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glClear(GL_COLOR_BUFFER_BIT);
  glEnable(GL_BLEND);
  glBlendEquation(GL_MAX);
  const double texel = 2.0 * light.patchHalf / patchPixels;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].tint.a < 1.0f) continue;
    bodyProgram("contact", scene.bodies[i]).use();
    poses[i].bind();
    drawShape(scene.bodies[i], quick ? 2.0 * texel : 0.0, GL_FRONT);  // the lower side counts
  }
  glBlendEquation(GL_FUNC_ADD);
  glDisable(GL_BLEND);
  bindTexture(ContactUnit, contact);

  glBindFramebuffer(GL_FRAMEBUFFER, noisyGroundLightBuffer);
  const ShaderProgram& shade =
      program("ground_light",
              {.folder = rendererShaders(), .vertex = "screen.vert", .fragment = "ground_light.frag"});
  shade.use();
  glUniform1f(shade.uniform("depthRange"), static_cast<float>(light.shadowDepth));
  glUniform1i(shade.uniform("taps"), shadowPixels > 1024 ? 32 : quick ? 8 : 12);
  glBindVertexArray(noVertices);
  glDrawArrays(GL_TRIANGLES, 0, 3);

  glBindFramebuffer(GL_FRAMEBUFFER, groundLightBuffer);
  program("blur", {.folder = rendererShaders(), .vertex = "screen.vert", .fragment = "blur.frag"}).use();
  bindTexture(ContactUnit, noisyGroundLight);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

/// The shadow map and the ground's light for the picture, each drawn only where it would not be as it is. In
/// quick pictures the ground's light comes for two pictures at a time, and `light` then tells its place.
void Renderer::State::prepareLight(const RenderScene& scene, Lighting& light, bool shadows,
                                   const std::function<void()>& upload) {
  const std::string casters = shadows ? castersOf(scene, light) : std::string();
  const bool onGround = shadows && scene.ground.visible;
  bool newGround = onGround && casters != groundLightFrom;
  if (newGround && quick && !groundLightIsOld && !groundLightFrom.empty()) {
    newGround = false;
    groundLightIsOld = true;
    light.patchCentre = groundLightCentre;
    light.patchHalf = groundLightHalf;
  }
  upload();
  if (shadows && casters != shadowsFrom) {
    drawShadowMap(scene, light);
    shadowsFrom = casters;
  }
  bindTexture(ShadowMapUnit, shadowMap, comparing);
  bindTexture(ShadowDepthUnit, shadowMap, plain);
  if (newGround) {
    drawGroundLight(scene, light);
    groundLightFrom = casters;
    groundLightIsOld = false;
    groundLightCentre = light.patchCentre;
    groundLightHalf = light.patchHalf;
  } else if (!shadows) {
    glBindFramebuffer(GL_FRAMEBUFFER, groundLightBuffer);
    glClearColor(1.0f, 1.0f, 1.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    groundLightFrom.clear();
  }
  bindTexture(GroundLightUnit, groundLight);
}

/// All that shadows follow from.
std::string Renderer::State::castersOf(const RenderScene& scene, const Lighting& light) const {
  Facts facts;
  facts.add(quick, light.size, light.up, light.groundX, light.groundY, light.groundHeight,
            light.shadowFromWorld, light.patchCentre, light.patchHalf);
  for (const BodyInstance& body : scene.bodies) {
    if (body.tint.a < 1.0f) continue;
    facts.add(body.mesh->shapeVersion(), body.look, body.pose->sculpted);
    facts.addAll(body.pose->method);
    facts.addAll(body.pose->rows);
    facts.addAll(body.pose->layers);
    if (body.hidden)
      for (const std::string& part : *body.hidden) facts.addAll(part);
  }
  return facts.bytes();
}

/// In quick pictures without what faces away, and with fewer triangles where those are a few pixels large.
void Renderer::State::drawClay(const BodyInstance& body) const {
  constexpr float largest = 5.0f;  // pixels
  if (!quick || !body.mesh->isClosed()) return body.mesh->drawTriangles(isLayered(body));
  const Culling culling(body, GL_BACK);
  if (!body.mesh->drawCoarse(largest / pixelsPerMetre, isLayered(body)))
    body.mesh->drawTriangles(isLayered(body));
}

void Renderer::State::drawBody(const RenderScene& scene, std::size_t index, bool translucent) {
  const BodyInstance& body = scene.bodies[index];
  const bool throughSkin = scene.xray && body.tint.a >= 1.0f;
  poses[index].bind();
  const auto use = [&](const Material& material) {
    const ShaderProgram& surface =
        bodyProgram("surface", body, body.wireframe, material.texture >= 0 || material.cutOff > 0.0f);
    surface.use();
    const Eigen::Vector3f tint = linearLight(body.tint);
    glUniform4f(surface.uniform("tint"), tint.x(), tint.y(), tint.z(), throughSkin ? 0.90f : body.tint.a);
    glUniform1f(surface.uniform("vertexColourShare"),
                body.look || body.surface == SurfaceColour::Vertex ? 1.0f : 0.0f);
    glUniform1f(surface.uniform("packedColours"),
                body.look && !body.look->look().coordinates.empty() ? 1.0f : 0.0f);
    glUniform1f(surface.uniform("seeThrough"), translucent ? body.seeThrough : 0.0f);
    glUniform1i(surface.uniform("taps"), supersampling > 1 ? 12 : 4);
    glUniform1i(surface.uniform("vertexCount"), body.mesh->vertexCount());
    setMaterial(surface, material);
  };
  const auto drawAll = [&] {
    if (body.wireframe || !body.look) use({});
    if (body.wireframe) return body.mesh->drawTrianglesByCorner(isLayered(body));
    if (!body.look) return drawClay(body);
    eachPart(body, [&](const MeshLook::Part& part) {
      const Material& material = body.look->look().materials[part.material];
      use(material);
      bindTexture(PictureUnit, body.look->texture(material));
      if (!material.doubleSided) glEnable(GL_CULL_FACE);
      body.mesh->drawTriangles(part.firstTriangle, part.triangleCount, isLayered(body));
      glDisable(GL_CULL_FACE);
    });
  };
  if (!translucent) return drawAll();
  // A ghost stands behind a solid body in the same place: what two poses share is drawn once. Along its
  // outline its own far side would come before the near one.
  std::optional<Culling> culling;
  if (!throughSkin) {
    glEnable(GL_POLYGON_OFFSET_FILL);
    culling.emplace(body, GL_BACK);
  }
  // Farther back than corners of round parts that were turned stick out, and each behind the one before.
  glPolygonOffset(1.0f, (5.0f + static_cast<float>(index)) * ghostOffset);
  // Depth first, so that only the nearest layer of a translucent body is seen.
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  drawAll();
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  drawAll();
  glDisable(GL_POLYGON_OFFSET_FILL);
}

void Renderer::State::drawBodies(const RenderScene& scene, bool translucent) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const bool isTranslucent = scene.xray || scene.bodies[i].tint.a < 1.0f;
    if (isTranslucent == translucent) drawBody(scene, i, translucent);
  }
}

/// Gradient, and in the lowest rows of the picture the ground; pixels.
void Renderer::State::drawBackdrop(const Viewport& size, int groundRows) {
  glDepthMask(GL_FALSE);
  glEnable(GL_SCISSOR_TEST);
  glBindVertexArray(noVertices);
  const auto draw = [&](const char* defines, int low, int high) {
    if (low >= high) return;
    glScissor(0, low, size.width, high - low);
    program(std::string("backdrop ") + defines, {.folder = rendererShaders(),
                                                 .vertex = "backdrop.vert",
                                                 .fragment = "backdrop.frag",
                                                 .defines = defines})
        .use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
  };
  draw("GROUND", 0, groundRows);
  draw("", groundRows, size.height);
  glDisable(GL_SCISSOR_TEST);
  glDepthMask(GL_TRUE);
}

/// What was drawn so far, one sample a pixel: the picture itself where it has no more, else a copy of the
/// named part.
const RenderTarget& Renderer::State::singleSampled(GLbitfield part) const {
  if (samples == 0) return large;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, large.framebuffer());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved.framebuffer());
  glBlitFramebuffer(0, 0, large.width(), large.height(), 0, 0, large.width(), large.height(), part,
                    GL_NEAREST);
  return resolved;
}

/// Where parts of bodies come near each other less light gets in: found in the depths of what was drawn so
/// far, for still pictures.
void Renderer::State::darkenFolds(const Viewport& viewport) {
  const RenderTarget& drawn = singleSampled(GL_DEPTH_BUFFER_BIT);
  if (opennessSize.width != viewport.width || opennessSize.height != viewport.height) {
    noisyOpenness = mapTexture(GL_RG8, viewport.width, viewport.height, GL_RG, GL_LINEAR);
    openness = mapTexture(GL_RG8, viewport.width, viewport.height, GL_RG, GL_LINEAR);
    noisyOpennessBuffer = framebufferOf(noisyOpenness, GL_COLOR_ATTACHMENT0, "the folds");
    opennessBuffer = framebufferOf(openness, GL_COLOR_ATTACHMENT0, "the folds");
    opennessSize = viewport;
  }
  const auto pass = [&](GLuint framebuffer, const char* name, GLuint source) {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    program(name,
            {.folder = rendererShaders(), .vertex = "screen.vert", .fragment = std::string(name) + ".frag"})
        .use();
    bindTexture(ContactUnit, source);
    glBindVertexArray(noVertices);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  };
  encodeSrgbTargets(false);
  glDisable(GL_DEPTH_TEST);
  glViewport(0, 0, viewport.width, viewport.height);
  pass(noisyOpennessBuffer, "occlusion", drawn.depthTexture());
  pass(opennessBuffer, "blur", noisyOpenness);
  encodeSrgbTargets(true);
  glViewport(0, 0, large.width(), large.height());
  glEnable(GL_BLEND);
  glBlendFunc(GL_DST_COLOR, GL_ZERO);
  pass(large.framebuffer(), "openness", openness);
  bindTexture(ContactUnit, 0);
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
}

void Renderer::State::copyTo(GLuint framebuffer, const Viewport& viewport) {
  const RenderTarget& picture = singleSampled(GL_COLOR_BUFFER_BIT);
  encodeSrgbTargets(false);  // average.frag does it, for a target that keeps what is written
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, viewport.width, viewport.height);
  glBindVertexArray(noVertices);
#ifndef __EMSCRIPTEN__
  if (supersampling == 1) {  // nothing to average: the bytes as they are
    glBindFramebuffer(GL_READ_FRAMEBUFFER, picture.framebuffer());
    glBlitFramebuffer(0, 0, viewport.width, viewport.height, 0, 0, viewport.width, viewport.height,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    return;
  }
#endif
  const ShaderProgram& average =
      program("average", {.folder = rendererShaders(), .vertex = "screen.vert", .fragment = "average.frag"});
  average.use();
  glUniform1i(average.uniform("large"), ContactUnit);
  glUniform1i(average.uniform("factor"), supersampling);
  bindTexture(ContactUnit, picture.texture());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Renderer::Renderer() : state_(std::make_unique<State>()) {}
Renderer::~Renderer() = default;

void Renderer::setSamples(int samples) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  state_->samples = std::clamp(samples, 0, static_cast<int>(most));
}
int Renderer::samples() const { return state_->samples; }
void Renderer::setSupersampling(int n) { state_->supersampling = std::clamp(n, 1, 4); }
void Renderer::setQuick(bool quick) { state_->quick = quick; }

void Renderer::draw(const RenderScene& scene, const Camera& camera, const Viewport& viewport,
                    unsigned framebuffer, float pixelScale) {
  State& gl = *state_;
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LEQUAL);
  gl.prepareTargets(viewport);
  gl.poses.resize(std::max(gl.poses.size(), scene.bodies.size()));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) gl.poses[i].upload(*scene.bodies[i].pose);

  const int n = gl.supersampling;
  const Viewport enlarged{n * viewport.width, n * viewport.height};
  gl.pixelsPerMetre = static_cast<float>(0.5 * enlarged.height / nearestHalfHeight(camera, scene.bounds));
  gl.prepareMaps(scene, camera);
  const bool shadows = scene.shadows && !scene.bodies.empty();
  Lighting light = lightingOf(scene, camera, gl.shadowPixels);
  gl.prepareLight(scene, light, shadows, [&] {
    const FrameBlock block =
        frameBlock(scene, camera, enlarged, static_cast<float>(n) * pixelScale, light, shadows);
    glBindBuffer(GL_UNIFORM_BUFFER, gl.frame);
    glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, &block);
    glBindBufferBase(GL_UNIFORM_BUFFER, frameBinding, gl.frame);
  });

  glBindFramebuffer(GL_FRAMEBUFFER, gl.large.framebuffer());
  glViewport(0, 0, enlarged.width, enlarged.height);
  encodeSrgbTargets(true);
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  gl.drawBodies(scene, false);
  gl.drawBackdrop(enlarged, scene.ground.visible ? groundRows(light, camera, enlarged, scene) : 0);
  if (gl.supersampling > 1 && !scene.bodies.empty() && !scene.xray) gl.darkenFolds(viewport);
  glEnable(GL_BLEND);
  // The picture stays opaque: what shows it may blend it over something else.
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl.overlay.draw(scene.overlay);
  gl.ghostOffset = static_cast<float>(ghostStep * scene.size) * depthUnits(scene, camera, light);
  gl.drawBodies(scene, true);
  if (!scene.overlayOnTop.empty()) {
    glClear(GL_DEPTH_BUFFER_BIT);
    gl.overlay.draw(scene.overlayOnTop);
  }
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  gl.copyTo(framebuffer, viewport);

  glBindVertexArray(0);
  glUseProgram(0);
  for (const TextureUnit unit : {ShadowMapUnit, ShadowDepthUnit, ContactUnit, GroundLightUnit, PictureUnit})
    bindTexture(unit, 0);
}

}  // namespace gelenk
