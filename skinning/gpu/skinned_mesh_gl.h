#pragma once

#include <array>
#include <optional>
#include <vector>

#include "skinning/blend/linear_blend.h"
#include "skinning/gpu/gl_handle.h"
#include "skinning/gpu/render_target.h"
#include "skinning/gpu/shader_program.h"
#include "skinning/gpu/skin_pose.h"
#include "skinning/muscles/muscle_control.h"

namespace gelenk {

/// How the vertex shader gets the matrices: the block of 341 matrices that every GL 3.3 offers, or a texture
/// with so many in a line.
enum class PoseStorage { UniformBlock, Texture };
inline constexpr int maxBlockJoints = 341;  ///< 16,384 bytes / 48
PoseStorage poseStorage(const SkinPose& pose);

/// One pose in GPU memory, rewritten every frame.
class PoseGl {
 public:
  /// Throws std::runtime_error if the joints are more than a texture holds.
  void upload(const SkinPose& pose);
  /// Binds for the skinning programs: uniform block "Pose" at blockBinding, or sampler "poseRows" at
  /// textureUnit.
  void bind() const;

  static constexpr GLuint blockBinding = 0;
  static constexpr GLint textureUnit = 7;

 private:
  PoseStorage storage_ = PoseStorage::UniformBlock;
  int textureLines_ = 0;
  GlBuffer block_, layers_;
  GlTexture texture_;
};

/// A skin's constant part in GPU memory: rest positions, normals, four joints and weights a vertex,
/// triangles. Vertex attributes: 0 position, 1 normal, 2 joints (uvec4), 3 weights, 4 colour (linear). Vertex
/// shaders include "skinning.glsl", whose skinVertex() gives posed position and normal. With LAYERS defined,
/// muscle layers join the skinning sum: attributes 5 (u, v, w, W), 6 (m), 7 (rows of its planes and link), 2
/// and 3 then hold what is left of the influences. With SCULPTED, 8 to 11 hold what setSculpture() found.
class SkinnedMeshGl {
 public:
  /// Throws std::invalid_argument on a skin whose influences or normals do not match its vertices.
  explicit SkinnedMeshGl(const Skin& skin);
  /// The same, ready to be drawn with and without its muscle layers. Throws std::invalid_argument where the
  /// limbs need more rows than the shader holds (14 limbs of two links).
  explicit SkinnedMeshGl(const MuscleSkin& body);
  /// For the shader's part of a method: attributes 12 to 15 hold slopes of the weights and the centre of
  /// rotation. Poses come from poseSkin of the same skin. Throws std::invalid_argument for a method that the
  /// shader does not have.
  explicit SkinnedMeshGl(const PreparedSkin& prepared);
  /// The same with muscle layers in displacement form.
  SkinnedMeshGl(const LayeredSkin& layered, const MuscleSkin& body);

  bool hasLayers() const { return layeredArray_ != 0; }
  int vertexCount() const { return vertexCount_; }
  int triangleCount() const { return triangleCount_; }
  int jointCount() const { return jointCount_; }
  /// Another number for every mesh, and after every change of its shape: what was drawn of it still holds
  /// while the number and the pose are the same.
  int shapeVersion() const { return shapeVersion_; }

  /// One colour a vertex, linear light in [0, 1]: weights of a joint, an error, a volume. Grey until set.
  /// Throws std::invalid_argument on another length.
  void setColours(const std::vector<Eigen::Vector3f>& colours);
  /// Replaces positions and normals by vertices that were deformed on the CPU, in world coordinates: draw
  /// with unposed(). Throws std::invalid_argument on another length.
  void setShape(const SkinnedVertices& deformed);
  /// Replaces the triangles by as many others over the same vertices; a triangle of one vertex is not seen.
  /// Throws std::invalid_argument on another number.
  void setTriangles(const std::vector<std::array<int, 3>>& triangles);

  /// Control points displaced by hand: what they do to each vertex in its link's own frame, position and
  /// three derivatives. Computed and uploaded only where they changed since the last call. rig: of the body
  /// this mesh was made from.
  void setSculpture(const MuscleRig& rig);

  /// Issues the draw call with whatever program is current; a PoseGl must be bound. Leaves no vertex array
  /// bound. layered: the program has LAYERS defined.
  void drawTriangles(bool layered = false) const;
  /// Fewer triangles, over the same vertices, for pictures in which those are smaller than pixels and for
  /// shadows: of every vertex and its neighbours one remains, which leaves about a quarter of the triangles,
  /// and so on from these. Draws the coarsest with edges (root mean square at rest, metres) shorter than
  /// longestEdge; false, and nothing is drawn, where none are, or the surface is not closed with its outside
  /// outwards. Made when first asked for.
  bool drawCoarse(float longestEdge, bool layered = false) const;
  /// The same surface may be drawn without what faces away.
  bool isClosed() const;
  /// Length of those edges, level 0 about a quarter of the triangles, 1 a sixteenth; 0: there are none.
  float coarseEdge(int level = 0) const;
  /// So many of them from one on.
  void drawTriangles(int first, int count, bool layered) const;
  /// Every vertex once, as a point.
  void drawPoints(bool layered = false) const;
  /// The triangles, where the program asks which corner of its triangle a vertex is: gl_VertexID /
  /// vertexCount(), 0 to 2. The vertices are copied for it within the GPU's memory.
  void drawTrianglesByCorner(bool layered = false) const;

  static constexpr GLuint layerBinding = 1;

 private:
  struct Attributes;  ///< a buffer of them, and how a vertex array reads it
  std::vector<Attributes> attributes(bool layered) const;
  void attach(bool layered, GLuint array, GLuint copies = 0) const;
  void addLayers(const MuscleSkin& body, const std::vector<int>& ends);
  void requireOnePerVertex(std::size_t count) const;
  /// Of the rest surface, read back when first needed.
  struct Coarse {
    Coarse() {}  // clang 14 makes no implicit one for an optional of the same class
    struct Level {
      GlBuffer indices;
      int triangles = 0;
      float edge = 0.0f;
    };
    std::vector<Level> levels;
    bool isClosed = false;
  };
  const Coarse& coarse() const;

  GlVertexArray triangleArray_, layeredArray_, cornerArray_;
  GlBuffer shape_, influences_, colours_, indices_, outside_, layers_, slopes_, sculpture_, cornerIndices_,
      corners_;
  mutable std::optional<Coarse> coarse_;
  std::vector<FfdLattice> displacements_;  ///< that sculpture_ holds
  int vertexCount_ = 0, triangleCount_ = 0, jointCount_ = 0;
  static int newVersion();
  int shapeVersion_ = newVersion();
};

/// The shader's own result, read back by transform feedback: for tests and benchmarks, not for drawing.
struct ReadBackVertices {
  std::vector<std::array<float, 3>> positions, normals;
};
/// Skins every vertex of a mesh into a buffer by transform feedback. The mesh must outlive it.
class FeedbackSkinning {
 public:
  /// kind: any pose of the kind that will be run, with or without muscle layers.
  FeedbackSkinning(const SkinnedMeshGl& mesh, const SkinPose& kind);
  void run(const SkinPose& pose);
  ReadBackVertices read() const;

 private:
  const SkinnedMeshGl* mesh_;
  bool layered_;
  ShaderProgram program_;
  PoseGl pose_;
  GlBuffer captured_;
  RenderTarget unseen_;  ///< drawing needs a complete framebuffer, even where nothing is rasterised
};
ReadBackVertices skinOnGpu(const SkinnedMeshGl& mesh, const SkinPose& pose);

/// Weight of one joint at every vertex.
std::vector<float> jointWeights(const Skin& skin, int joint);

}  // namespace gelenk
