#pragma once

#include <array>
#include <vector>

#include "skinning/gpu/gl_handle.h"
#include "skinning/gpu/shader_program.h"
#include "skinning/linear_blend.h"

namespace gelenk {

/// T_skin = T_anim T_rest^-1 of every joint as three rows of four floats (row-major 3x4), 12 floats a joint.
/// float begins here. A value: one mesh is drawn with as many poses as there are ghosts.
struct SkinPose {
  std::vector<float> rows;
  int jointCount() const { return static_cast<int>(rows.size()) / 12; }
};
SkinPose poseSkin(const Skin& skin, const Frames& worldFromJoint);
/// The same into existing storage; allocates only when the size changes.
void poseSkin(const Skin& skin, const Frames& worldFromJoint, SkinPose& out);

/// How the vertex shader gets the matrices: the block of 341 matrices that every GL 3.3 offers, or a texture of any length.
enum class PoseStorage { UniformBlock, TextureBuffer };
inline constexpr int maxBlockMatrices = 341;  ///< 16,384 bytes / 48

/// One pose in GPU memory, rewritten every frame.
class PoseGl {
 public:
  PoseGl() = default;
  void upload(const SkinPose& pose);
  PoseStorage storage() const { return storage_; }
  /// Binds for the skinning programs: uniform block binding 0 or texture unit 7.
  void bind() const;

  static constexpr GLuint blockBinding = 0;
  static constexpr GLint textureUnit = 7;

 private:
  PoseStorage storage_ = PoseStorage::UniformBlock;
  GlBuffer buffer_;
  GlTexture texture_;
  std::vector<float> padded_;
};

/// A skin's constant part in GPU memory: rest positions, normals, four joints and weights a vertex, triangles.
/// Vertex attributes: 0 position, 1 normal, 2 joints (uvec4), 3 weights, 4 free scalar a vertex in [0, 1].
/// Shaders include "skinning.glsl", whose `skinVertex` returns the posed position and normal; locations 5-7 are reserved for
/// layers that move inside the skinning sum.
class SkinnedMeshGl {
 public:
  explicit SkinnedMeshGl(const Skin& skin);

  int vertexCount() const { return vertexCount_; }
  int triangleCount() const { return triangleCount_; }
  int jointCount() const { return jointCount_; }
  /// The storage that poses of this mesh need (see PoseStorage); programs are compiled once for each.
  PoseStorage storage() const { return jointCount_ <= maxBlockMatrices ? PoseStorage::UniformBlock : PoseStorage::TextureBuffer; }

  /// Values in [0, 1] a vertex, shown as colours (weights of a bone, an error, a volume); one a vertex.
  void setScalars(const std::vector<float>& values);

  /// Issues the draw call with whatever program is current; a PoseGl must be bound.
  void drawTriangles() const;
  /// Every n-th vertex as a point.
  void drawPoints(int stride = 1) const;

 private:
  GlVertexArray vertices_, pointVertices_;
  GlBuffer attributes_, joints_, scalars_, indices_;
  int vertexCount_ = 0, triangleCount_ = 0, jointCount_ = 0;
};

/// The shader's own result, read back by transform feedback: for tests and benchmarks, not for drawing.
struct ReadBackVertices {
  std::vector<std::array<float, 3>> positions, normals;
};
ReadBackVertices skinOnGpu(const SkinnedMeshGl& mesh, const SkinPose& pose);

/// Weight of one joint at every vertex, for setScalars.
std::vector<float> jointWeights(const Skin& skin, int joint);

}  // namespace gelenk
