#include "skinning/gpu/skinned_mesh_gl.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <stdexcept>
#include <string>

#include "skinning/coarse_surface.h"
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
struct LayerVertex {
  float place[3], weight;  ///< x, y in the section, metres, and w
  float normal[3];
  std::uint16_t planeRow, linkRow;  ///< of SkinPose::layers
  std::uint16_t endJoint, unused;   ///< E of the displacement form
};
struct SlopeVertex {
  float weightsU[3], centreX;  ///< slopes of the first three weights along the first tangent
  float weightsV[3], centreY;
  float centreU[3], centreZ;
  float centreV[3];
};
struct SculptureVertex {
  float columns[4][3];  ///< displacement, d/dx, d/dy, d/dw
};
static_assert(sizeof(ShapeVertex) == 24 && sizeof(InfluenceVertex) == 24 && sizeof(LayerVertex) == 36 &&
              sizeof(SculptureVertex) == 48);

template <class T>
void fill(GLenum target, const GlBuffer& buffer, const std::vector<T>& data, GLenum usage = GL_STATIC_DRAW) {
  glBindBuffer(target, buffer);
  glBufferData(target, static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), usage);
}

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

std::vector<LayerVertex> layerVertices(const MuscleSkin& body, const std::vector<int>& ends) {
  std::vector<LayerVertex> vertices(body.vertices.size(),
                                    LayerVertex{{0, 0, 0}, 0.0f, {0, 0, 0}, 0, 0, 0, 0});
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const LimbVertex& from = body.vertices[v];
    if (from.limb < 0) continue;
    const int volumes = 2 * static_cast<int>(body.limbs[from.limb].shape.links.size());
    const int end = 3 * volumes + 1;  // the planes of the rigid ends follow the limb's own
    const int plane = from.volume == LimbVertex::beyondNear  ? end
                      : from.volume == LimbVertex::beyondFar ? end + 4
                                                             : 3 * from.volume;
    LayerVertex& to = vertices[v];
    to.weight = static_cast<float>(from.weight);
    to.planeRow = static_cast<std::uint16_t>(firstLayerRow(body, from.limb) + 3 * plane);
    to.linkRow = static_cast<std::uint16_t>(firstLinkRow(body, from.limb) + 3 * std::max(from.volume / 2, 0));
    if (!ends.empty()) to.endJoint = static_cast<std::uint16_t>(ends[v]);
    Eigen::Vector3d place = from.uvw, normal = from.normal;
    if (from.volume >= 0) {
      const LimbShape& shape = body.limbs[from.limb].shape;
      const Eigen::Vector2d size = shape.sectionUpper - shape.sectionLower;
      place.head<2>() = shape.sectionLower + place.head<2>().cwiseProduct(size);
      normal.head<2>() = normal.head<2>().cwiseQuotient(size);
    }
    for (int k = 0; k < 3; ++k) {
      to.place[k] = static_cast<float>(place[k]);
      to.normal[k] = static_cast<float>(normal[k]);
    }
  }
  return vertices;
}

std::vector<SlopeVertex> slopeVertices(const PreparedSkin& prepared) {
  std::vector<SlopeVertex> vertices(prepared.slopes.size(), SlopeVertex{});
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    SlopeVertex& to = vertices[v];
    for (int k = 0; k < 3; ++k) {
      to.weightsU[k] = static_cast<float>(prepared.slopes[v](k, 0));
      to.weightsV[k] = static_cast<float>(prepared.slopes[v](k, 1));
      if (prepared.centres.empty()) continue;
      to.centreU[k] = static_cast<float>(prepared.centreSlopes[v](k, 0));
      to.centreV[k] = static_cast<float>(prepared.centreSlopes[v](k, 1));
    }
    if (prepared.centres.empty()) continue;
    to.centreX = static_cast<float>(prepared.centres[v].x());
    to.centreY = static_cast<float>(prepared.centres[v].y());
    to.centreZ = static_cast<float>(prepared.centres[v].z());
  }
  return vertices;
}

/// The displaced control points of every volume of every limb; empty where there are none.
std::vector<FfdLattice> displacementLattices(const MuscleRig& rig) {
  std::vector<FfdLattice> lattices;
  bool any = false;
  for (std::size_t l = 0; l < rig.controls().size(); ++l) {
    std::vector<MuscleState> states = rig.controls()[l].sculpted;
    states.resize(rig.body().limbs[l].shape.links.size());
    for (const MuscleState& state : states) {
      any = any || !state.plane2.displacement.empty() || !state.plane4.displacement.empty();
      for (const int half : {0, 1}) lattices.push_back(displacementLattice(state, half));
    }
  }
  return any ? lattices : std::vector<FfdLattice>{};
}

std::vector<SculptureVertex> sculptureVertices(const MuscleSkin& body,
                                               const std::vector<FfdLattice>& lattices) {
  std::vector<std::size_t> firstOfLimb{0};
  for (const Limb& limb : body.limbs) firstOfLimb.push_back(firstOfLimb.back() + 2 * limb.shape.links.size());
  std::vector<SculptureVertex> vertices(body.vertices.size(), SculptureVertex{});
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const LimbVertex& from = body.vertices[v];
    if (from.limb < 0 || from.volume < 0) continue;
    FfdSample at = lattices[firstOfLimb[from.limb] + from.volume].evaluate(from.uvw);
    const LimbShape& shape = body.limbs[from.limb].shape;
    at.derivatives.leftCols<2>() *= (shape.sectionUpper - shape.sectionLower).cwiseInverse().asDiagonal();
    for (int k = 0; k < 3; ++k) {
      vertices[v].columns[0][k] = static_cast<float>(at.position[k]);
      for (int c = 0; c < 3; ++c) vertices[v].columns[c + 1][k] = static_cast<float>(at.derivatives(k, c));
    }
  }
  return vertices;
}

/// A triangle's k-th corner is its vertex in the k-th copy of all vertices.
template <class Triangle>
std::vector<Triangle> indicesByCorner(std::vector<Triangle> triangles, int vertexCount) {
  for (Triangle& triangle : triangles)
    for (int k = 1; k < 3; ++k) triangle[k] += k * vertexCount;
  return triangles;
}

}  // namespace

PoseStorage poseStorage(const SkinPose& pose) {
  return pose.rowCount() <= maxBlockRows ? PoseStorage::UniformBlock : PoseStorage::Texture;
}

namespace {

/// Floats into a uniform block of so many bytes, which must be backed in full.
void writeBlock(GlBuffer& buffer, GLsizeiptr whole, const std::vector<float>& data) {
  const bool isNew = buffer == 0;
  if (isNew) buffer = GlBuffer::create();
  glBindBuffer(GL_UNIFORM_BUFFER, buffer);
  if (isNew) glBufferData(GL_UNIFORM_BUFFER, whole, nullptr, GL_STREAM_DRAW);
  glBufferSubData(GL_UNIFORM_BUFFER, 0, static_cast<GLsizeiptr>(data.size() * sizeof(float)), data.data());
  glBindBuffer(GL_UNIFORM_BUFFER, 0);
}

/// A texture of so many lines of 341 joints.
GlTexture poseTexture(int lines) {
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  if (lines > limit)
    throw std::runtime_error("this renderer's textures hold " + std::to_string(limit * maxBlockJoints) +
                             " joints, the skeleton has more");
  GlTexture texture = GlTexture::create();
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 3 * maxBlockJoints, lines, 0, GL_RGBA, GL_FLOAT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  return texture;
}

}  // namespace

void PoseGl::upload(const SkinPose& pose) {
  if (!pose.layers.empty()) writeBlock(layers_, maxLayerRows * 16, pose.layers);
  storage_ = poseStorage(pose);
  if (storage_ == PoseStorage::UniformBlock) return writeBlock(block_, maxBlockJoints * 48, pose.rows);
  const int full = pose.rowCount() / maxBlockRows, rest = pose.rowCount() % maxBlockRows;
  if (textureLines_ < full + 1) {
    texture_ = poseTexture(full + 1);
    textureLines_ = full + 1;
  }
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, maxBlockRows, full, GL_RGBA, GL_FLOAT, pose.rows.data());
  if (rest > 0)
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, full, rest, 1, GL_RGBA, GL_FLOAT,
                    &pose.rows[4 * static_cast<std::size_t>(full) * maxBlockRows]);
  glBindTexture(GL_TEXTURE_2D, 0);
}

void PoseGl::bind() const {
  if (layers_ != 0) glBindBufferBase(GL_UNIFORM_BUFFER, SkinnedMeshGl::layerBinding, layers_);
  if (storage_ == PoseStorage::UniformBlock) {
    glBindBufferBase(GL_UNIFORM_BUFFER, blockBinding, block_);
  } else {
    glActiveTexture(GL_TEXTURE0 + textureUnit);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glActiveTexture(GL_TEXTURE0);
  }
}

/// One buffer's attributes of a vertex, each a place in it.
struct SkinnedMeshGl::Attributes {
  struct One {
    GLuint location;
    GLint components;
    GLenum type;  ///< GL_FLOAT, or GL_UNSIGNED_SHORT for whole numbers
    std::size_t at;
  };
  GLuint buffer;
  GLsizei stride;
  std::vector<One> each;
};

std::vector<SkinnedMeshGl::Attributes> SkinnedMeshGl::attributes(bool layered) const {
  std::vector<Attributes> all = {
      {shape_,
       sizeof(ShapeVertex),
       {{0, 3, GL_FLOAT, offsetof(ShapeVertex, position)}, {1, 3, GL_FLOAT, offsetof(ShapeVertex, normal)}}},
      {layered && outside_ != 0 ? outside_ : influences_,
       sizeof(InfluenceVertex),
       {{2, 4, GL_UNSIGNED_SHORT, offsetof(InfluenceVertex, joints)},
        {3, 4, GL_FLOAT, offsetof(InfluenceVertex, weights)}}},
      {colours_, sizeof(Eigen::Vector3f), {{4, 3, GL_FLOAT, 0}}}};
  if (layered)
    all.push_back({layers_,
                   sizeof(LayerVertex),
                   {{5, 4, GL_FLOAT, offsetof(LayerVertex, place)},
                    {6, 3, GL_FLOAT, offsetof(LayerVertex, normal)},
                    {7, 3, GL_UNSIGNED_SHORT, offsetof(LayerVertex, planeRow)}}});
  if (slopes_ != 0)
    all.push_back({slopes_,
                   sizeof(SlopeVertex),
                   {{12, 4, GL_FLOAT, offsetof(SlopeVertex, weightsU)},
                    {13, 4, GL_FLOAT, offsetof(SlopeVertex, weightsV)},
                    {14, 4, GL_FLOAT, offsetof(SlopeVertex, centreU)},
                    {15, 3, GL_FLOAT, offsetof(SlopeVertex, centreV)}}});
  if (layered && sculpture_ != 0)
    all.push_back(
        {sculpture_,
         sizeof(SculptureVertex),
         {{8, 3, GL_FLOAT, 0}, {9, 3, GL_FLOAT, 12}, {10, 3, GL_FLOAT, 24}, {11, 3, GL_FLOAT, 36}}});
  return all;
}

SkinnedMeshGl::SkinnedMeshGl(const Skin& skin)
    : triangleArray_(GlVertexArray::create()),
      cornerArray_(GlVertexArray::create()),
      shape_(GlBuffer::create()),
      influences_(GlBuffer::create()),
      colours_(GlBuffer::create()),
      indices_(GlBuffer::create()),
      cornerIndices_(GlBuffer::create()),
      corners_(GlBuffer::create()),
      vertexCount_(static_cast<int>(skin.mesh.positions.size())),
      triangleCount_(static_cast<int>(skin.mesh.triangles.size())),
      jointCount_(skin.jointCount()) {
  if (skin.influences.size() != skin.mesh.positions.size() ||
      skin.mesh.normals.size() != skin.mesh.positions.size())
    throw std::invalid_argument("a skin needs one normal and one row of influences a vertex");
  fill(GL_ARRAY_BUFFER, shape_, shapeVertices(skin.mesh.positions, skin.mesh.normals));
  fill(GL_ARRAY_BUFFER, influences_, influenceVertices(skin.influences));
  fill(GL_ARRAY_BUFFER, colours_,
       std::vector<Eigen::Vector3f>(vertexCount_, Eigen::Vector3f::Constant(0.5f)));
  attach(false, triangleArray_);
  glBindVertexArray(triangleArray_);
  fill(GL_ELEMENT_ARRAY_BUFFER, indices_, skin.mesh.triangles);
  glBindVertexArray(cornerArray_);
  fill(GL_ELEMENT_ARRAY_BUFFER, cornerIndices_, indicesByCorner(skin.mesh.triangles, vertexCount_));
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

SkinnedMeshGl::SkinnedMeshGl(const MuscleSkin& body) : SkinnedMeshGl(body.skin) {
  outside_ = GlBuffer::create();
  fill(GL_ARRAY_BUFFER, outside_, influenceVertices(body.outside));
  addLayers(body, {});
}

SkinnedMeshGl::SkinnedMeshGl(const PreparedSkin& prepared) : SkinnedMeshGl(prepared.skin) {
  if (prepared.method->shader.empty())
    throw std::invalid_argument("the skinning method '" + std::string(prepared.method->name) +
                                "' is on the processor only");
  slopes_ = GlBuffer::create();
  fill(GL_ARRAY_BUFFER, slopes_, slopeVertices(prepared));
  attach(false, triangleArray_);
}

SkinnedMeshGl::SkinnedMeshGl(const LayeredSkin& layered, const MuscleSkin& body)
    : SkinnedMeshGl(layered.outside) {
  addLayers(body, layered.endJoint);
}

/// ends: E of every vertex in displacement form; empty: layers inside the sum.
void SkinnedMeshGl::addLayers(const MuscleSkin& body, const std::vector<int>& ends) {
  const int limbs = static_cast<int>(body.limbs.size());
  if (const int rows = firstLayerRow(body, limbs); rows > maxLayerRows)
    throw std::invalid_argument("the muscle layers of " + std::to_string(limbs) + " limbs need " +
                                std::to_string(rows) + " rows, the shader holds " +
                                std::to_string(maxLayerRows));
  layeredArray_ = GlVertexArray::create();
  layers_ = GlBuffer::create();
  fill(GL_ARRAY_BUFFER, layers_, layerVertices(body, ends));
  attach(true, layeredArray_);
  glBindVertexArray(layeredArray_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

/// Makes the vertex array read these attributes; all of them from the one buffer `copies`, a block after the
/// other, where that is given.
void SkinnedMeshGl::attach(bool layered, GLuint array, GLuint copies) const {
  glBindVertexArray(array);
  std::size_t begin = 0;
  for (const Attributes& from : attributes(layered)) {
    glBindBuffer(GL_ARRAY_BUFFER, copies != 0 ? copies : from.buffer);
    for (const auto& [location, components, type, at] : from.each) {
      const void* place = reinterpret_cast<const void*>(begin + at);
      glEnableVertexAttribArray(location);
      if (type == GL_FLOAT)
        glVertexAttribPointer(location, components, type, GL_FALSE, from.stride, place);
      else
        glVertexAttribIPointer(location, components, type, from.stride, place);
    }
    if (copies != 0) begin += 3 * static_cast<std::size_t>(from.stride) * vertexCount_;
  }
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void SkinnedMeshGl::setSculpture(const MuscleRig& rig) {
  requireOnePerVertex(rig.body().vertices.size());
  std::vector<FfdLattice> now = displacementLattices(rig);
  const auto same = [](const FfdLattice& a, const FfdLattice& b) { return a.points == b.points; };
  if (std::equal(now.begin(), now.end(), displacements_.begin(), displacements_.end(), same)) return;
  displacements_ = std::move(now);
  shapeVersion_ = newVersion();
  if (displacements_.empty()) return;  // poses are then drawn without SCULPTED
  const bool isNew = sculpture_ == 0;
  if (isNew) sculpture_ = GlBuffer::create();
  fill(GL_ARRAY_BUFFER, sculpture_, sculptureVertices(rig.body(), displacements_), GL_DYNAMIC_DRAW);
  if (isNew) attach(true, layeredArray_);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

int SkinnedMeshGl::newVersion() {
  static int last = 0;
  return ++last;
}

void SkinnedMeshGl::requireOnePerVertex(std::size_t count) const {
  if (count != static_cast<std::size_t>(vertexCount_))
    throw std::invalid_argument("the mesh has " + std::to_string(vertexCount_) +
                                " vertices, but values are given for " + std::to_string(count));
}

void SkinnedMeshGl::setColours(const std::vector<Eigen::Vector3f>& colours) {
  requireOnePerVertex(colours.size());
  fill(GL_ARRAY_BUFFER, colours_, colours, GL_DYNAMIC_DRAW);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void SkinnedMeshGl::setShape(const SkinnedVertices& deformed) {
  requireOnePerVertex(deformed.positions.size());
  requireOnePerVertex(deformed.normals.size());
  shapeVersion_ = newVersion();
  fill(GL_ARRAY_BUFFER, shape_, shapeVertices(deformed.positions, deformed.normals), GL_STREAM_DRAW);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void SkinnedMeshGl::setTriangles(const std::vector<std::array<int, 3>>& triangles) {
  if (static_cast<int>(triangles.size()) != triangleCount_)
    throw std::invalid_argument("a mesh of " + std::to_string(triangleCount_) + " triangles was given " +
                                std::to_string(triangles.size()));
  shapeVersion_ = newVersion();
  coarse_.reset();
  glBindVertexArray(triangleArray_);
  fill(GL_ELEMENT_ARRAY_BUFFER, indices_, triangles);
  glBindVertexArray(cornerArray_);
  fill(GL_ELEMENT_ARRAY_BUFFER, cornerIndices_, indicesByCorner(triangles, vertexCount_));
  glBindVertexArray(0);
}

void SkinnedMeshGl::drawTriangles(bool layered) const {
  glBindVertexArray(layered ? layeredArray_ : triangleArray_);
  glDrawElements(GL_TRIANGLES, 3 * triangleCount_, GL_UNSIGNED_INT, nullptr);
  glBindVertexArray(0);
}

void SkinnedMeshGl::drawTriangles(int first, int count, bool layered) const {
  glBindVertexArray(layered ? layeredArray_ : triangleArray_);
  glDrawElements(GL_TRIANGLES, 3 * count, GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(3 * sizeof(std::uint32_t) * static_cast<std::size_t>(first)));
  glBindVertexArray(0);
}

namespace {

constexpr std::size_t leastCoarseTriangles = 200;

template <class T>
std::vector<T> readBack(const GlBuffer& buffer, int count) {
  std::vector<T> data(count);
  glBindBuffer(GL_COPY_READ_BUFFER, buffer);
  glGetBufferSubData(GL_COPY_READ_BUFFER, 0, static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data());
  glBindBuffer(GL_COPY_READ_BUFFER, 0);
  return data;
}

}  // namespace

const SkinnedMeshGl::Coarse& SkinnedMeshGl::coarse() const {
  if (coarse_) return *coarse_;
  coarse_.emplace();
  const auto triangles = readBack<std::array<int, 3>>(indices_, triangleCount_);
  const auto shape = readBack<ShapeVertex>(shape_, vertexCount_);
  const auto at = [&](int v) { return Eigen::Map<const Eigen::Vector3f>(shape[v].position); };
  coarse_->isClosed = enclosesItsInside(triangles, vertexCount_, at);
  if (!coarse_->isClosed) return *coarse_;
  glBindVertexArray(triangleArray_);  // WebGL 2: indices that were filled at another target stay no indices
  for (auto fewer = coarseTriangles(triangles, vertexCount_); !fewer.empty();) {
    double squares = 0.0;
    for (const auto& t : fewer)
      for (int k = 0; k < 3; ++k) squares += (at(t[k]) - at(t[(k + 1) % 3])).squaredNorm();
    Coarse::Level& level = coarse_->levels.emplace_back();
    level.triangles = static_cast<int>(fewer.size());
    level.edge = static_cast<float>(std::sqrt(squares / static_cast<double>(3 * fewer.size())));
    level.indices = GlBuffer::create();
    fill(GL_ELEMENT_ARRAY_BUFFER, level.indices, fewer);
    auto next = coarseTriangles(fewer, vertexCount_);
    if (next.size() < leastCoarseTriangles || 2 * next.size() > fewer.size()) break;
    fewer = std::move(next);
  }
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  glBindVertexArray(0);
  return *coarse_;
}

bool SkinnedMeshGl::isClosed() const { return coarse().isClosed; }
float SkinnedMeshGl::coarseEdge(int level) const {
  const auto& levels = coarse().levels;
  return level < static_cast<int>(levels.size()) ? levels[level].edge : 0.0f;
}

bool SkinnedMeshGl::drawCoarse(float longestEdge, bool layered) const {
  const auto& levels = coarse().levels;
  const auto tooLong =
      std::find_if(levels.begin(), levels.end(), [&](const auto& l) { return l.edge >= longestEdge; });
  if (tooLong == levels.begin()) return false;
  const Coarse::Level& level = *std::prev(tooLong);
  glBindVertexArray(layered ? layeredArray_ : triangleArray_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, level.indices);
  glDrawElements(GL_TRIANGLES, 3 * level.triangles, GL_UNSIGNED_INT, nullptr);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  glBindVertexArray(0);
  return true;
}

void SkinnedMeshGl::drawPoints(bool layered) const {
  glBindVertexArray(layered ? layeredArray_ : triangleArray_);
  glDrawArrays(GL_POINTS, 0, vertexCount_);
  glBindVertexArray(0);
}

void SkinnedMeshGl::drawTrianglesByCorner(bool layered) const {
  // Three copies of all vertices, the k-th for the triangles' k-th corners.
  const std::vector<Attributes> all = attributes(layered);
  GLsizeiptr bytes = 0;
  for (const Attributes& from : all) bytes += 3 * static_cast<GLsizeiptr>(from.stride) * vertexCount_;
  glBindBuffer(GL_COPY_WRITE_BUFFER, corners_);
  glBufferData(GL_COPY_WRITE_BUFFER, bytes, nullptr, GL_STREAM_DRAW);
  GLintptr to = 0;
  for (const Attributes& from : all) {
    glBindBuffer(GL_COPY_READ_BUFFER, from.buffer);
    const GLsizeiptr size = static_cast<GLsizeiptr>(from.stride) * vertexCount_;
    for (int copy = 0; copy < 3; ++copy, to += size)
      glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, to, size);
  }
  glBindBuffer(GL_COPY_READ_BUFFER, 0);
  glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
  attach(layered, cornerArray_, corners_);
  glBindVertexArray(cornerArray_);
  glDrawElements(GL_TRIANGLES, 3 * triangleCount_, GL_UNSIGNED_INT, nullptr);
  for (GLuint location = 5; location < 12; ++location) glDisableVertexAttribArray(location);
  glBindVertexArray(0);
}

FeedbackSkinning::FeedbackSkinning(const SkinnedMeshGl& mesh, const SkinPose& kind)
    : mesh_(&mesh),
      layered_(mesh.hasLayers() && !kind.layers.empty()),
      captured_(GlBuffer::create()),
      unseen_(1, 1) {
  const std::string defines = poseDefines(kind, layered_);
  program_ = ShaderProgram({.folder = skinningShaders(),
                            .vertex = "read_back.vert",
                            .fragment = "nothing.frag",
                            .defines = defines,
                            .captured = {"posedPosition", "posedNormal"}});
  program_.bindBlock("Pose", PoseGl::blockBinding);
  program_.bindBlock("Layers", SkinnedMeshGl::layerBinding);
  program_.bindSampler("poseRows", PoseGl::textureUnit);
  glBindBuffer(GL_TRANSFORM_FEEDBACK_BUFFER, captured_);
  glBufferData(GL_TRANSFORM_FEEDBACK_BUFFER, 6 * static_cast<GLsizeiptr>(sizeof(float)) * mesh.vertexCount(),
               nullptr, GL_STREAM_READ);
  glBindBuffer(GL_TRANSFORM_FEEDBACK_BUFFER, 0);
  glUseProgram(0);
}

void FeedbackSkinning::run(const SkinPose& pose) {
  pose_.upload(pose);
  pose_.bind();
  program_.use();
  glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, captured_);
  GLint before = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &before);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, unseen_.framebuffer());
  glEnable(GL_RASTERIZER_DISCARD);
  glBeginTransformFeedback(GL_POINTS);
  mesh_->drawPoints(layered_);
  glEndTransformFeedback();
  glDisable(GL_RASTERIZER_DISCARD);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(before));
  glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
  glUseProgram(0);
}

ReadBackVertices FeedbackSkinning::read() const {
  const std::size_t count = mesh_->vertexCount();
  std::vector<float> numbers(6 * count);
  glBindBuffer(GL_TRANSFORM_FEEDBACK_BUFFER, captured_);
  glGetBufferSubData(GL_TRANSFORM_FEEDBACK_BUFFER, 0, static_cast<GLsizeiptr>(numbers.size() * sizeof(float)),
                     numbers.data());
  glBindBuffer(GL_TRANSFORM_FEEDBACK_BUFFER, 0);
  ReadBackVertices result;
  for (std::size_t v = 0; v < count; ++v) {
    const float* at = &numbers[6 * v];
    result.positions.push_back({at[0], at[1], at[2]});
    result.normals.push_back({at[3], at[4], at[5]});
  }
  return result;
}

ReadBackVertices skinOnGpu(const SkinnedMeshGl& mesh, const SkinPose& pose) {
  FeedbackSkinning skinning(mesh, pose);
  skinning.run(pose);
  return skinning.read();
}

std::vector<float> jointWeights(const Skin& skin, int joint) {
  std::vector<float> weights(skin.influences.size(), 0.0f);
  for (std::size_t v = 0; v < weights.size(); ++v)
    for (int k = 0; k < 4; ++k)
      if (skin.influences[v].joints[k] == joint)
        weights[v] += static_cast<float>(skin.influences[v].weights[k]);
  return weights;
}

}  // namespace gelenk
