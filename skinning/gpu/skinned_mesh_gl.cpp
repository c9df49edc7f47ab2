#include "skinning/gpu/skinned_mesh_gl.h"

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "skinning/gpu/shader_program.h"

namespace gelenk {
namespace {

struct ShapeVertex {
  float position[3], normal[3];
};
struct InfluenceVertex {
  std::uint16_t joints[4];
  float weights[4];
};
static_assert(sizeof(ShapeVertex) == 24 && sizeof(InfluenceVertex) == 24);

template <class T>
void fill(GLenum target, const GlBuffer& buffer, const std::vector<T>& data, GLenum usage = GL_STATIC_DRAW) {
  glBindBuffer(target, buffer);
  glBufferData(target, static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), usage);
}

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

std::vector<ShapeVertex> shapeVertices(const std::vector<Eigen::Vector3d>& positions,
                                       const std::vector<Eigen::Vector3d>& normals) {
  std::vector<ShapeVertex> vertices(positions.size());
  for (std::size_t v = 0; v < vertices.size(); ++v)
    for (int k = 0; k < 3; ++k) {
      vertices[v].position[k] = static_cast<float>(positions[v][k]);
      vertices[v].normal[k] = static_cast<float>(normals[v][k]);
    }
  return vertices;
}

std::vector<InfluenceVertex> influenceVertices(const std::vector<Influences>& influences) {
  std::vector<InfluenceVertex> vertices(influences.size());
  for (std::size_t v = 0; v < vertices.size(); ++v)
    for (int k = 0; k < 4; ++k) {
      vertices[v].joints[k] = static_cast<std::uint16_t>(influences[v].joints[k]);
      vertices[v].weights[k] = static_cast<float>(influences[v].weights[k]);
    }
  return vertices;
}

void floatAttribute(GLuint location, GLint components, GLsizei stride, std::size_t at) {
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, components, GL_FLOAT, GL_FALSE, stride, offset(at));
}

}  // namespace

PoseStorage poseStorage(int jointCount) {
  return jointCount <= maxBlockJoints ? PoseStorage::UniformBlock : PoseStorage::TextureBuffer;
}

void PoseGl::upload(const SkinPose& pose) {
  const GLsizeiptr bytes = static_cast<GLsizeiptr>(pose.rows.size() * sizeof(float));
  storage_ = poseStorage(pose.jointCount());
  const bool inBlock = storage_ == PoseStorage::UniformBlock;
  const GLenum target = inBlock ? GL_UNIFORM_BUFFER : GL_TEXTURE_BUFFER;
  const GLsizeiptr needed = inBlock ? maxBlockJoints * 48 : bytes;  // a block must be backed in full
  if (buffer_ == 0) buffer_ = GlBuffer::create();
  glBindBuffer(target, buffer_);
  if (capacity_ < needed) {
    glBufferData(target, needed, nullptr, GL_STREAM_DRAW);
    capacity_ = needed;
  }
  glBufferSubData(target, 0, bytes, pose.rows.data());
  glBindBuffer(target, 0);
  if (inBlock || texture_ != 0) return;

  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
  if (bytes / 16 > limit)
    throw std::runtime_error("this renderer's texture buffers hold " + std::to_string(limit / 3) + " joints, the skeleton has " +
                             std::to_string(pose.jointCount()));
  texture_ = GlTexture::create();
  glBindTexture(GL_TEXTURE_BUFFER, texture_);
  glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, buffer_);
  glBindTexture(GL_TEXTURE_BUFFER, 0);
}

void PoseGl::bind() const {
  if (storage_ == PoseStorage::UniformBlock) {
    glBindBufferBase(GL_UNIFORM_BUFFER, blockBinding, buffer_);
  } else {
    glActiveTexture(GL_TEXTURE0 + textureUnit);
    glBindTexture(GL_TEXTURE_BUFFER, texture_);
    glActiveTexture(GL_TEXTURE0);
  }
}

SkinnedMeshGl::SkinnedMeshGl(const Skin& skin)
    : triangleArray_(GlVertexArray::create()),
      shape_(GlBuffer::create()),
      influences_(GlBuffer::create()),
      colours_(GlBuffer::create()),
      indices_(GlBuffer::create()),
      vertexCount_(static_cast<int>(skin.mesh.positions.size())),
      triangleCount_(static_cast<int>(skin.mesh.triangles.size())),
      jointCount_(skin.jointCount()) {
  if (skin.influences.size() != skin.mesh.positions.size() || skin.mesh.normals.size() != skin.mesh.positions.size())
    throw std::invalid_argument("a skin needs one normal and one row of influences a vertex");
  glBindVertexArray(triangleArray_);

  fill(GL_ARRAY_BUFFER, shape_, shapeVertices(skin.mesh.positions, skin.mesh.normals));
  floatAttribute(0, 3, sizeof(ShapeVertex), offsetof(ShapeVertex, position));
  floatAttribute(1, 3, sizeof(ShapeVertex), offsetof(ShapeVertex, normal));

  fill(GL_ARRAY_BUFFER, influences_, influenceVertices(skin.influences));
  glEnableVertexAttribArray(2);
  glVertexAttribIPointer(2, 4, GL_UNSIGNED_SHORT, sizeof(InfluenceVertex), offset(offsetof(InfluenceVertex, joints)));
  floatAttribute(3, 4, sizeof(InfluenceVertex), offsetof(InfluenceVertex, weights));

  fill(GL_ARRAY_BUFFER, colours_, std::vector<Eigen::Vector3f>(vertexCount_, Eigen::Vector3f::Constant(0.5f)));
  floatAttribute(4, 3, sizeof(Eigen::Vector3f), 0);

  fill(GL_ELEMENT_ARRAY_BUFFER, indices_, skin.mesh.triangles);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void SkinnedMeshGl::requireOnePerVertex(std::size_t count) const {
  if (count != static_cast<std::size_t>(vertexCount_))
    throw std::invalid_argument("the mesh has " + std::to_string(vertexCount_) + " vertices, but values are given for " +
                                std::to_string(count));
}

void SkinnedMeshGl::setColours(const std::vector<Eigen::Vector3f>& colours) {
  requireOnePerVertex(colours.size());
  fill(GL_ARRAY_BUFFER, colours_, colours, GL_DYNAMIC_DRAW);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void SkinnedMeshGl::setShape(const SkinnedVertices& deformed) {
  requireOnePerVertex(deformed.positions.size());
  requireOnePerVertex(deformed.normals.size());
  fill(GL_ARRAY_BUFFER, shape_, shapeVertices(deformed.positions, deformed.normals), GL_STREAM_DRAW);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void SkinnedMeshGl::drawTriangles() const {
  glBindVertexArray(triangleArray_);
  glDrawElements(GL_TRIANGLES, 3 * triangleCount_, GL_UNSIGNED_INT, nullptr);
  glBindVertexArray(0);
}

void SkinnedMeshGl::drawPoints() const {
  glBindVertexArray(triangleArray_);
  glDrawArrays(GL_POINTS, 0, vertexCount_);
  glBindVertexArray(0);
}

ReadBackVertices skinOnGpu(const SkinnedMeshGl& mesh, const SkinPose& pose) {
  const ShaderProgram program({.folder = skinningShaders(),
                               .vertex = "read_back.vert",
                               .defines = mesh.storage() == PoseStorage::TextureBuffer ? "POSE_IN_TEXTURE" : "",
                               .captured = {"posedPosition", "posedNormal"}});
  program.bindBlock("Pose", PoseGl::blockBinding);
  program.bindSampler("poseRows", PoseGl::textureUnit);
  PoseGl poseGl;
  poseGl.upload(pose);
  poseGl.bind();

  const std::size_t count = mesh.vertexCount();
  std::vector<float> captured(6 * count);
  const GlBuffer buffer = GlBuffer::create();
  glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
  glBufferData(GL_TRANSFORM_FEEDBACK_BUFFER, captured.size() * sizeof(float), nullptr, GL_STREAM_READ);
  program.use();
  glEnable(GL_RASTERIZER_DISCARD);
  glBeginTransformFeedback(GL_POINTS);
  mesh.drawPoints();
  glEndTransformFeedback();
  glDisable(GL_RASTERIZER_DISCARD);
  glGetBufferSubData(GL_TRANSFORM_FEEDBACK_BUFFER, 0, captured.size() * sizeof(float), captured.data());
  glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
  glUseProgram(0);

  ReadBackVertices result;
  for (std::size_t v = 0; v < count; ++v) {
    const float* at = &captured[6 * v];
    result.positions.push_back({at[0], at[1], at[2]});
    result.normals.push_back({at[3], at[4], at[5]});
  }
  return result;
}

std::vector<float> jointWeights(const Skin& skin, int joint) {
  std::vector<float> weights(skin.influences.size(), 0.0f);
  for (std::size_t v = 0; v < weights.size(); ++v)
    for (int k = 0; k < 4; ++k)
      if (skin.influences[v].joints[k] == joint) weights[v] += static_cast<float>(skin.influences[v].weights[k]);
  return weights;
}

}  // namespace gelenk
