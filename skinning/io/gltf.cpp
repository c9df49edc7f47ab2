#include "skinning/io/gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>
#include <sstream>

#include "kinematics/configuration.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

[[noreturn]] void fail(const std::string& file, const std::string& expected, const std::string& found) {
  throw ParseError(file, 0, expected, found);
}

bool skipImage(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int,
               void*) {
  return true;
}

tinygltf::Model load(std::string_view bytes, const std::string& file, const std::string& folder) {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(skipImage, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  const bool binary = bytes.substr(0, 4) == "glTF";
  if (bytes.size() > 0xfffffff0u) fail(file, "a file below 4 GB", std::to_string(bytes.size()) + " bytes");
  bool loaded = false;
  try {
    const auto size = static_cast<unsigned>(bytes.size());
    loaded = binary ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                                  reinterpret_cast<const unsigned char*>(bytes.data()), size,
                                                  folder)
                    : loader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, folder);
  } catch (const std::exception& exception) {  // of the JSON library
    error = exception.what();
  }
  if (!loaded) {
    error = error.substr(0, error.find('\n'));
    fail(file, "glTF 2.0", error.empty() ? "something else" : error);
  }
  return model;
}

/// The numbers of an accessor, element after element; normalised integers become fractions. Every index and
/// size is checked here, because the library does not.
std::vector<double> numbers(const tinygltf::Model& model, int index, int components, const std::string& what,
                            const std::string& file) {
  const auto wrong = [&](const std::string& found) {
    fail(file, what + " within the file's buffers", found);
  };
  if (index < 0 || index >= static_cast<int>(model.accessors.size()))
    wrong("accessor " + std::to_string(index));
  const tinygltf::Accessor& accessor = model.accessors[index];
  if (accessor.sparse.isSparse) wrong("a sparse accessor");
  const int found = tinygltf::GetNumComponentsInType(accessor.type),
            size = tinygltf::GetComponentSizeInBytes(accessor.componentType);
  if (found != components)
    wrong(std::to_string(found) + " components instead of " + std::to_string(components));
  if (size <= 0) wrong("an unknown type of numbers");
  if (accessor.bufferView < 0 || accessor.bufferView >= static_cast<int>(model.bufferViews.size()))
    wrong("no buffer view");
  const tinygltf::BufferView& view = model.bufferViews[accessor.bufferView];
  if (view.buffer < 0 || view.buffer >= static_cast<int>(model.buffers.size())) wrong("no buffer");
  const auto& data = model.buffers[view.buffer].data;
  const std::size_t element = static_cast<std::size_t>(size) * components,
                    stride = view.byteStride ? view.byteStride : element;
  if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
    wrong("a view beyond its buffer");
  if (accessor.count == 0) return {};
  if (stride < element || accessor.byteOffset > view.byteLength ||
      element > view.byteLength - accessor.byteOffset ||
      (accessor.count - 1) > (view.byteLength - accessor.byteOffset - element) / stride)
    wrong(std::to_string(accessor.count) + " elements in " + std::to_string(view.byteLength) + " bytes");

  std::vector<double> values;
  values.reserve(accessor.count * components);
  const auto read = [&](const unsigned char* at, auto zero, double largest) {
    std::memcpy(&zero, at, sizeof zero);
    const double value = static_cast<double>(zero);
    return accessor.normalized && largest > 0.0 ? std::max(-1.0, value / largest) : value;
  };
  for (std::size_t e = 0; e < accessor.count; ++e)
    for (int c = 0; c < components; ++c) {
      const unsigned char* at = data.data() + view.byteOffset + accessor.byteOffset + e * stride +
                                static_cast<std::size_t>(c) * size;
      double value = 0.0;
      switch (accessor.componentType) {
        case TINYGLTF_COMPONENT_TYPE_FLOAT: value = read(at, float{}, 0.0); break;
        case TINYGLTF_COMPONENT_TYPE_BYTE: value = read(at, std::int8_t{}, 127.0); break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: value = read(at, std::uint8_t{}, 255.0); break;
        case TINYGLTF_COMPONENT_TYPE_SHORT: value = read(at, std::int16_t{}, 32767.0); break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: value = read(at, std::uint16_t{}, 65535.0); break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: value = read(at, std::uint32_t{}, 0.0); break;
        default: wrong("an unknown type of numbers");
      }
      if (!std::isfinite(value)) fail(file, "finite numbers in " + what, "NaN or infinity");
      values.push_back(value);
    }
  return values;
}

/// A rotation, a place and one scale.
struct Similarity {
  Quaterniond rotation = Quaterniond::Identity();
  Vector3d translation = Vector3d::Zero();
  double scale = 1.0;
};

Similarity similarity(const Matrix4d& matrix, const std::string& file, const std::string& node) {
  const Matrix3d A = matrix.topLeftCorner<3, 3>();
  const double scale = std::cbrt(A.determinant());
  const bool fits = matrix.allFinite() && std::isfinite(scale) && scale > 1e-12 &&
                    (A * A.transpose() / (scale * scale)).isIdentity(1e-4);
  if (!fits)
    fail(file, "nodes with rotation, translation and one positive scale",
         "shear, a mirror or unequal scales in node '" + node + "'");
  return {Quaterniond(Matrix3d(A / scale)).normalized(), matrix.topRightCorner<3, 1>(), scale};
}

Similarity localTransform(const tinygltf::Node& node, const std::string& file) {
  Matrix4d matrix = Matrix4d::Identity();
  if (node.matrix.size() == 16) {
    matrix = Eigen::Map<const Matrix4d>(node.matrix.data());
  } else {
    if (node.rotation.size() == 4) {
      const Quaterniond q(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
      if (!(std::abs(q.norm() - 1.0) < 1e-2))
        fail(file, "unit quaternions", "length " + exactNumber(q.norm()) + " in node '" + node.name + "'");
      matrix.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
    }
    if (node.scale.size() == 3)
      for (int k = 0; k < 3; ++k) matrix.col(k).head<3>() *= node.scale[k];
    if (node.translation.size() == 3)
      matrix.topRightCorner<3, 1>() = Vector3d(node.translation[0], node.translation[1], node.translation[2]);
  }
  return similarity(matrix, file, node.name);
}

struct Sampler {
  std::vector<double> times, values;
  int components = 0;
  bool step = false;
};

/// Linear (quaternions: along the shorter arc) between keys, constant outside.
template <class Result>
Result keyed(const Sampler& sampler, double seconds, Result (*mix)(const double*, const double*, double)) {
  const auto after = std::upper_bound(sampler.times.begin(), sampler.times.end(), seconds);
  const std::size_t b = std::min<std::size_t>(after - sampler.times.begin(), sampler.times.size() - 1);
  const std::size_t a =
      after == sampler.times.begin() ? 0 : static_cast<std::size_t>(after - sampler.times.begin()) - 1;
  const double span = sampler.times[b] - sampler.times[a];
  const double s =
      span > 0.0 && !sampler.step ? std::clamp((seconds - sampler.times[a]) / span, 0.0, 1.0) : 0.0;
  return mix(&sampler.values[a * sampler.components], &sampler.values[b * sampler.components], s);
}
Vector3d mixVector(const double* a, const double* b, double s) {
  return (1.0 - s) * Eigen::Map<const Vector3d>(a) + s * Eigen::Map<const Vector3d>(b);
}
Quaterniond mixRotation(const double* a, const double* b, double s) {
  const Quaterniond p(a[3], a[0], a[1], a[2]), q(b[3], b[0], b[1], b[2]);
  return p.normalized().slerp(s, q.normalized());
}

class Reader {
 public:
  Reader(const tinygltf::Model& model, const std::string& file) : model_(model), file_(file) {}

  GltfModel read() {
    findUses();
    visitNodes();
    makeSkeleton();
    readMeshes();
    for (const tinygltf::Animation& animation : model_.animations) readAnimation(animation);
    return std::move(result_);
  }

 private:
  int nodeCount() const { return static_cast<int>(model_.nodes.size()); }
  void checkNode(int n, const std::string& what) const {
    if (n < 0 || n >= nodeCount())
      fail(file_, what + " among the " + std::to_string(nodeCount()) + " nodes", std::to_string(n));
  }

  /// Which nodes turn (joints of skins, animated rotations) and which move.
  void findUses() {
    turns_.assign(nodeCount(), false);
    moves_.assign(nodeCount(), false);
    for (const tinygltf::Skin& skin : model_.skins)
      for (const int n : skin.joints) checkNode(n, "a skin's joints"), turns_[n] = true;
    for (const tinygltf::Animation& animation : model_.animations)
      for (const tinygltf::AnimationChannel& channel : animation.channels) {
        if (channel.target_node < 0) continue;
        checkNode(channel.target_node, "an animation's node");
        if (channel.target_path == "rotation") turns_[channel.target_node] = true;
        if (channel.target_path == "translation") moves_[channel.target_node] = true;
      }
  }

  void visitNodes() {
    std::vector<int> parent(nodeCount(), -1);
    for (int n = 0; n < nodeCount(); ++n)
      for (const int child : model_.nodes[n].children) {
        checkNode(child, "a node's children");
        if (parent[child] >= 0)
          fail(file_, "nodes with one parent", "a second one for node " + std::to_string(child));
        parent[child] = n;
      }
    std::vector<int> roots;
    const int scene = model_.defaultScene >= 0 ? model_.defaultScene : 0;
    if (scene < static_cast<int>(model_.scenes.size())) {
      for (const int n : model_.scenes[scene].nodes) checkNode(n, "a scene's nodes"), roots.push_back(n);
    } else {
      for (int n = 0; n < nodeCount(); ++n)
        if (parent[n] < 0) roots.push_back(n);
    }
    // A mesh that a skin moves stands nowhere itself: its node, without children, is no joint.
    const auto isJoint = [&](int n) {
      const tinygltf::Node& node = model_.nodes[n];
      return !(node.mesh >= 0 && node.skin >= 0 && node.children.empty() && !turns_[n]) &&
             !(node.camera >= 0 && node.children.empty());
    };
    std::erase_if(roots, [&](int n) { return !isJoint(n); });
    if (roots.empty()) fail(file_, "at least one node that can be a joint", "none");
    jointOfNode_.assign(nodeCount(), -1);
    std::vector<std::pair<int, int>> open;
    if (roots.size() > 1) order_.push_back(-1), parents_.push_back(-1);  // a joint above all roots
    for (auto root = roots.rbegin(); root != roots.rend(); ++root)
      open.emplace_back(*root, roots.size() > 1 ? 0 : -1);
    while (!open.empty()) {
      const auto [n, up] = open.back();
      open.pop_back();
      if (jointOfNode_[n] >= 0)
        fail(file_, "nodes that form trees", "node " + std::to_string(n) + " twice (a cycle?)");
      jointOfNode_[n] = static_cast<int>(order_.size());
      order_.push_back(n);
      parents_.push_back(up);
      const auto& children = model_.nodes[n].children;
      for (auto child = children.rbegin(); child != children.rend(); ++child)
        if (isJoint(*child)) open.emplace_back(*child, jointOfNode_[n]);
    }
    for (const tinygltf::Skin& skin : model_.skins)
      for (const int n : skin.joints)
        if (jointOfNode_[n] < 0) fail(file_, "a skin's joints within the scene", "node " + std::to_string(n));
  }

  void makeSkeleton() {
    std::vector<Joint> joints;
    std::set<std::string> names;
    for (std::size_t j = 0; j < order_.size(); ++j) {
      const int n = order_[j];
      std::string name = n < 0                          ? "scene"
                         : model_.nodes[n].name.empty() ? "node" + std::to_string(n)
                                                        : model_.nodes[n].name;
      for (int k = 2; !names.insert(name).second; ++k)
        name = (n < 0 ? "scene" : model_.nodes[n].name) + "_" + std::to_string(k);
      Similarity local = n < 0 ? Similarity{} : localTransform(model_.nodes[n], file_);
      const double above = parents_[j] < 0 ? 1.0 : scale_[parents_[j]];
      local.translation *= above;
      scale_.push_back(above * local.scale);
      rest_.push_back(local);
      if (!local.translation.allFinite() || !std::isfinite(scale_.back()))
        fail(file_, "finite node transforms", "an overflow");
      Joint joint{.name = name, .parent = parents_[j]};
      joint.parentFromZero.linear() = local.rotation.toRotationMatrix();
      joint.parentFromZero.translation() = local.translation;
      joint.ball = n >= 0 && turns_[n];
      if (n >= 0 && (moves_[n] || (j == 0 && turns_[n])))
        for (int k = 0; k < 3; ++k)  // along the parent's axes
          joint.axes.push_back(
              {AxisDof::Kind::Translation, (local.rotation.conjugate() * Vector3d::Unit(k)).normalized()});
      joints.push_back(std::move(joint));
    }
    result_.skeleton = Skeleton(std::move(joints));
    restFrames_ = restFrames(result_.skeleton);
  }

  Matrix4d worldFromNode(int joint) const {
    Matrix4d matrix = restFrames_[joint].matrix();
    matrix.topLeftCorner<3, 3>() *= scale_[joint];
    return matrix;
  }

  void readMeshes() {
    Mesh mesh;
    SparseWeights weights;
    std::vector<Isometry3d> bind(result_.skeleton.jointCount());
    for (int j = 0; j < result_.skeleton.jointCount(); ++j) bind[j] = restFrames_[j].inverse(Eigen::Isometry);
    const bool direct = bindMatricesAreRigid(bind);
    for (int n = 0; n < nodeCount(); ++n) {
      const tinygltf::Node& node = model_.nodes[n];
      if (node.mesh < 0) continue;
      if (node.mesh >= static_cast<int>(model_.meshes.size()))
        fail(file_, "a mesh among " + std::to_string(model_.meshes.size()), std::to_string(node.mesh));
      if (node.skin >= static_cast<int>(model_.skins.size()))
        fail(file_, "a skin among " + std::to_string(model_.skins.size()), std::to_string(node.skin));
      if (node.skin < 0 && jointOfNode_[n] < 0) continue;  // not in the scene
      for (const tinygltf::Primitive& primitive : model_.meshes[node.mesh].primitives)
        readPrimitive(node, n, primitive, direct, mesh, weights);
    }
    if (mesh.triangles.empty()) return;
    WeightLoss loss;
    auto influences = fourLargest(weights, result_.skeleton.jointCount(), &loss);
    if (loss.verticesOverFour > 0)
      tell(result_.notes, "weights-lost",
           "vertices have more than four weights; at most " +
               exactNumber(std::round(1000.0 * loss.max) / 10.0) + " % of the weight is lost",
           loss.verticesOverFour);
    result_.skin = bindSkin(std::move(mesh), restFrames_, std::move(influences));
    if (direct) result_.skin->jointFromRestWorld = bind;
  }

  /// True if the only skin's inverse bind matrices are rigid and no node is scaled: then they are kept, so
  /// that a bind pose other than the file's own pose survives. bind: filled with them.
  bool bindMatricesAreRigid(std::vector<Isometry3d>& bind) const {
    if (model_.skins.size() != 1) return false;
    for (const double s : scale_)
      if (std::abs(s - 1.0) > 1e-6) return false;
    std::vector<Isometry3d> candidate = bind;
    const auto matrices = bindMatrices(model_.skins[0]);
    for (std::size_t k = 0; k < matrices.size(); ++k) {
      const Matrix3d A = matrices[k].topLeftCorner<3, 3>();
      if (!(A * A.transpose()).isIdentity(1e-4) || A.determinant() < 0.0) return false;
      Isometry3d& frame = candidate[jointOfNode_[model_.skins[0].joints[k]]];
      frame = Isometry3d::Identity();
      frame.linear() = Quaterniond(A).normalized().toRotationMatrix();
      frame.translation() = matrices[k].topRightCorner<3, 1>();
    }
    for (const tinygltf::Node& node : model_.nodes)
      if (node.mesh >= 0 && node.skin < 0) return false;  // rigid meshes are placed by their nodes
    bind = candidate;
    return true;
  }

  std::vector<Matrix4d> bindMatrices(const tinygltf::Skin& skin) const {
    std::vector<Matrix4d> matrices(skin.joints.size(), Matrix4d::Identity());
    if (skin.inverseBindMatrices < 0) return matrices;
    const auto values = numbers(model_, skin.inverseBindMatrices, 16, "inverse bind matrices", file_);
    if (values.size() < 16 * matrices.size())
      fail(file_, std::to_string(matrices.size()) + " inverse bind matrices",
           std::to_string(values.size() / 16));
    for (std::size_t k = 0; k < matrices.size(); ++k)
      matrices[k] = Eigen::Map<const Matrix4d>(&values[16 * k]);
    return matrices;
  }

  void readPrimitive(const tinygltf::Node& node, int n, const tinygltf::Primitive& primitive, bool direct,
                     Mesh& mesh, SparseWeights& weights) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES) {
      tell(result_.notes, "primitives-skipped", "points, lines or triangle strips are passed over");
      return;
    }
    const auto attribute = [&](const std::string& name) {
      const auto at = primitive.attributes.find(name);
      return at == primitive.attributes.end() ? -1 : at->second;
    };
    if (attribute("POSITION") < 0) fail(file_, "positions in every mesh", "none");
    const auto positions = numbers(model_, attribute("POSITION"), 3, "positions", file_);
    const std::size_t count = positions.size() / 3, base = mesh.positions.size();
    SparseWeights own(count);
    if (node.skin >= 0) {
      const tinygltf::Skin& skin = model_.skins[node.skin];
      const auto matrices = bindMatrices(skin);
      for (const std::string set : {"0", "1"}) {
        if (attribute("JOINTS_" + set) < 0) continue;
        const auto joints = numbers(model_, attribute("JOINTS_" + set), 4, "joint indices", file_);
        const auto values = numbers(model_, attribute("WEIGHTS_" + set), 4, "weights", file_);
        if (joints.size() != 4 * count || values.size() != 4 * count)
          fail(file_, "four joints and weights a vertex", "other counts");
        for (std::size_t i = 0; i < 4 * count; ++i) {
          if (values[i] == 0.0) continue;
          if (joints[i] < 0.0 || joints[i] >= static_cast<double>(skin.joints.size()))
            fail(file_, "joints among the skin's " + std::to_string(skin.joints.size()),
                 exactNumber(joints[i]));
          if (values[i] < 0.0) fail(file_, "weights that are not negative", exactNumber(values[i]));
          own[i / 4].emplace_back(static_cast<int>(joints[i]), values[i]);
        }
      }
      for (std::size_t v = 0; v < count; ++v) {
        if (own[v].empty())
          fail(file_, "weights at every vertex of a skinned mesh", "none at vertex " + std::to_string(v));
        const Vector3d p(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]);
        Vector3d world = Vector3d::Zero();
        double total = 0.0;
        for (auto& [joint, weight] : own[v]) {
          const int carrier = jointOfNode_[skin.joints[joint]];
          if (!direct)
            world += weight * (worldFromNode(carrier) * (matrices[joint] * p.homogeneous())).head<3>();
          total += weight;
          joint = carrier;
        }
        mesh.positions.push_back(direct ? p : Vector3d(world / total));
      }
    } else {
      const Matrix4d world = worldFromNode(jointOfNode_[n]);
      for (std::size_t v = 0; v < count; ++v) {
        mesh.positions.push_back(
            (world * Eigen::Vector4d(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2], 1.0))
                .head<3>());
        own[v].emplace_back(jointOfNode_[n], 1.0);
      }
    }
    for (std::size_t v = base; v < mesh.positions.size(); ++v)
      if (!mesh.positions[v].allFinite()) fail(file_, "finite positions", "an overflow");
    weights.insert(weights.end(), own.begin(), own.end());
    std::vector<double> indices;
    if (primitive.indices >= 0) {
      indices = numbers(model_, primitive.indices, 1, "indices of triangles", file_);
    } else {
      for (std::size_t v = 0; v < count; ++v) indices.push_back(static_cast<double>(v));
    }
    if (indices.size() % 3 != 0) fail(file_, "three indices a triangle", std::to_string(indices.size()));
    for (std::size_t i = 0; i < indices.size(); i += 3) {
      std::array<int, 3> triangle{};
      for (int k = 0; k < 3; ++k) {
        if (indices[i + k] < 0.0 || indices[i + k] >= static_cast<double>(count))
          fail(file_, "triangle corners below " + std::to_string(count), exactNumber(indices[i + k]));
        triangle[k] = static_cast<int>(base) + static_cast<int>(indices[i + k]);
      }
      mesh.triangles.push_back(triangle);
    }
  }

  Sampler sampler(const tinygltf::Animation& animation, const tinygltf::AnimationChannel& channel) {
    if (channel.sampler < 0 || channel.sampler >= static_cast<int>(animation.samplers.size()))
      fail(file_, "a sampler of the animation", std::to_string(channel.sampler));
    const tinygltf::AnimationSampler& source = animation.samplers[channel.sampler];
    Sampler result{.times = numbers(model_, source.input, 1, "key times", file_),
                   .values = {},
                   .components = channel.target_path == "rotation" ? 4 : 3};
    result.values = numbers(model_, source.output, result.components, "key values", file_);
    result.step = source.interpolation == "STEP";
    if (source.interpolation == "CUBICSPLINE") {  // (in-tangent, value, out-tangent) a key
      std::vector<double> keys;
      const std::size_t c = result.components;
      for (std::size_t k = 0; 3 * k * c + 2 * c <= result.values.size(); ++k)
        keys.insert(keys.end(), &result.values[(3 * k + 1) * c], &result.values[(3 * k + 1) * c] + c);
      result.values = keys;
    }
    if (result.times.empty() || result.values.size() != result.times.size() * result.components)
      fail(file_, "one value a key time",
           std::to_string(result.values.size() / result.components) + " values for " +
               std::to_string(result.times.size()));
    if (!std::is_sorted(result.times.begin(), result.times.end()))
      fail(file_, "key times in ascending order", "others");
    if (result.components == 4)
      for (std::size_t k = 0; k < result.values.size(); k += 4)
        if (!(Eigen::Map<const Eigen::Vector4d>(&result.values[k]).norm() > 1e-6))
          fail(file_, "unit quaternions", "zero");
    return result;
  }

  void readAnimation(const tinygltf::Animation& animation) {
    struct Track {
      int joint;
      bool rotation;
      Sampler keys;
    };
    std::vector<Track> tracks;
    std::set<double> times;
    for (const tinygltf::AnimationChannel& channel : animation.channels) {
      const int joint = channel.target_node < 0 ? -1 : jointOfNode_[channel.target_node];
      if (joint < 0) continue;
      if (channel.target_path == "scale") {
        const Sampler scales = sampler(animation, channel);
        for (std::size_t i = 0; i < scales.values.size(); ++i)
          if (std::abs(scales.values[i] - rest_[joint].scale) > 1e-3 * rest_[joint].scale) {
            tell(result_.notes, "scale-animation",
                 "animation '" + animation.name + "' changes the scale of '" +
                     result_.skeleton.joint(joint).name + "': passed over");
            break;
          }
        continue;
      }
      if (channel.target_path != "rotation" && channel.target_path != "translation") continue;
      tracks.push_back({joint, channel.target_path == "rotation", sampler(animation, channel)});
      times.insert(tracks.back().keys.times.begin(), tracks.back().keys.times.end());
    }
    if (tracks.empty()) return;
    const double first = *times.begin(), last = *times.rbegin();
    double rate = times.size() > 1 ? static_cast<double>(times.size() - 1) / (last - first) : 60.0;
    std::size_t k = 0;
    bool even = true;
    for (const double t : times)
      even = even && std::abs((t - first) * rate - static_cast<double>(k++)) < 0.02;
    if (!even) {
      rate = 60.0;
      tell(result_.notes, "resampled",
           "animation '" + animation.name + "': keys at uneven times, resampled at 60 Hz");
    }
    const double frames = std::floor((last - first) * rate + 0.5) + 1.0;
    if (!(frames < 1e6)) fail(file_, "an animation of fewer than a million frames", exactNumber(frames));
    const int count = static_cast<int>(frames);
    GltfClip clip{
        animation.name.empty() ? "animation" + std::to_string(result_.clips.size()) : animation.name,
        {.framesPerSecond = rate, .q = Eigen::MatrixXd(result_.skeleton.nq(), count)}};
    for (int f = 0; f < count; ++f) {
      Eigen::VectorXd q = neutral(result_.skeleton);
      for (const Track& track : tracks) {
        const Similarity& rest = rest_[track.joint];
        const double seconds = first + f / rate;
        if (track.rotation) {
          setBallRotation(result_.skeleton, q, track.joint,
                          (rest.rotation.conjugate() * keyed<Quaterniond>(track.keys, seconds, mixRotation))
                              .normalized());
        } else {
          const int up = parents_[track.joint];
          const Vector3d moved =
              (up < 0 ? 1.0 : scale_[up]) * keyed<Vector3d>(track.keys, seconds, mixVector) -
              rest.translation;
          if (!moved.allFinite()) fail(file_, "finite key values", "an overflow");
          q.segment<3>(result_.skeleton.qIndex(track.joint)) = moved;
        }
      }
      clip.clip.q.col(f) = q;
    }
    result_.clips.push_back(std::move(clip));
  }

  const tinygltf::Model& model_;
  const std::string& file_;
  GltfModel result_;
  std::vector<bool> turns_, moves_;
  std::vector<int> order_, parents_,
      jointOfNode_;               ///< order_: node of each joint, -1 for the joint above all roots
  std::vector<double> scale_;     ///< accumulated, one a joint
  std::vector<Similarity> rest_;  ///< local, translations in metres
  Frames restFrames_;
};

}  // namespace

GltfModel parseGltf(std::string_view bytes, const std::string& file, const std::string& folder) {
  const tinygltf::Model model = load(bytes, file, folder);
  return Reader(model, file).read();
}

GltfModel readGltf(const std::string& path) {
  return parseGltf(readFile(path), path, std::filesystem::path(path).parent_path().string());
}

namespace {

/// Appends data to the only buffer and describes it.
class Writer {
 public:
  Writer(const Skeleton& skeleton, const Skin* skin, const std::vector<GltfClip>& clips) {
    model_.asset.version = "2.0";
    model_.asset.generator = "gelenk";
    model_.buffers.resize(1);
    addNodes(skeleton);
    if (skin) addSkin(skeleton, *skin);
    for (const GltfClip& clip : clips) addClip(skeleton, clip);
    if (model_.buffers[0].data.empty()) model_.buffers.clear();
  }
  tinygltf::Model& model() { return model_; }

 private:
  template <class T>
  int add(const std::vector<T>& values, int type, int componentType, int components, int target = 0) {
    auto& data = model_.buffers[0].data;
    while (data.size() % 4 != 0) data.push_back(0);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = data.size();
    view.byteLength = values.size() * sizeof(T);
    view.target = target;
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    data.insert(data.end(), bytes, bytes + view.byteLength);
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size());
    accessor.componentType = componentType;
    accessor.type = type;
    accessor.count = values.size() / components;
    if (componentType == TINYGLTF_COMPONENT_TYPE_FLOAT && components <= 3)
      for (int c = 0; c < components; ++c) {
        double low = values[c], high = values[c];
        for (std::size_t i = c; i < values.size(); i += components)
          low = std::min<double>(low, values[i]), high = std::max<double>(high, values[i]);
        accessor.minValues.push_back(low);
        accessor.maxValues.push_back(high);
      }
    model_.bufferViews.push_back(view);
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  void addNodes(const Skeleton& skeleton) {
    const Frames rest = restFrames(skeleton);
    for (int i = 0; i < skeleton.jointCount(); ++i) {
      const int parent = skeleton.parent(i);
      const Isometry3d local = parent < 0 ? rest[i] : rest[parent].inverse(Eigen::Isometry) * rest[i];
      const Quaterniond r = Quaterniond(local.linear()).normalized();
      tinygltf::Node node;
      node.name = skeleton.joint(i).name;
      node.translation = {local.translation().x(), local.translation().y(), local.translation().z()};
      node.rotation = {r.x(), r.y(), r.z(), r.w()};
      node.children = skeleton.children(i);
      model_.nodes.push_back(node);
    }
    tinygltf::Scene scene;
    scene.nodes = {0};
    model_.scenes.push_back(scene);
    model_.defaultScene = 0;
  }

  void addSkin(const Skeleton& skeleton, const Skin& skin) {
    std::vector<float> positions, normals, weights, matrices;
    std::vector<std::uint16_t> joints;
    for (std::size_t v = 0; v < skin.mesh.positions.size(); ++v) {
      for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(skin.mesh.positions[v][k]));
      for (int k = 0; k < 3; ++k) normals.push_back(static_cast<float>(skin.mesh.normals[v][k]));
      for (int k = 0; k < 4; ++k) joints.push_back(static_cast<std::uint16_t>(skin.influences[v].joints[k]));
      for (int k = 0; k < 4; ++k) weights.push_back(static_cast<float>(skin.influences[v].weights[k]));
    }
    std::vector<std::uint32_t> indices;
    for (const auto& triangle : skin.mesh.triangles)
      for (const int corner : triangle) indices.push_back(static_cast<std::uint32_t>(corner));
    for (const Isometry3d& frame : skin.jointFromRestWorld)
      for (int k = 0; k < 16; ++k) matrices.push_back(static_cast<float>(frame.matrix()(k % 4, k / 4)));

    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.attributes["POSITION"] =
        add(positions, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
    primitive.attributes["NORMAL"] =
        add(normals, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
    primitive.attributes["JOINTS_0"] = add(joints, TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                                           4, TINYGLTF_TARGET_ARRAY_BUFFER);
    primitive.attributes["WEIGHTS_0"] =
        add(weights, TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_FLOAT, 4, TINYGLTF_TARGET_ARRAY_BUFFER);
    primitive.indices = add(indices, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, 1,
                            TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    tinygltf::Mesh mesh;
    mesh.name = "body";
    mesh.primitives.push_back(primitive);
    model_.meshes.push_back(mesh);
    tinygltf::Skin bound;
    for (int j = 0; j < skeleton.jointCount(); ++j) bound.joints.push_back(j);
    bound.skeleton = 0;
    bound.inverseBindMatrices = add(matrices, TINYGLTF_TYPE_MAT4, TINYGLTF_COMPONENT_TYPE_FLOAT, 16);
    model_.skins.push_back(bound);
    tinygltf::Node node;
    node.name = "body";
    node.mesh = 0;
    node.skin = 0;
    model_.nodes.push_back(node);
    model_.scenes[0].nodes.push_back(static_cast<int>(model_.nodes.size()) - 1);
  }

  void addClip(const Skeleton& skeleton, const GltfClip& source) {
    validate(skeleton, source.clip);
    const int count = source.clip.frameCount();
    std::vector<float> times(count);
    for (int f = 0; f < count; ++f) times[f] = static_cast<float>(f / source.clip.framesPerSecond);
    std::vector<std::vector<float>> rotations(skeleton.jointCount()), translations(skeleton.jointCount());
    std::vector<Quaterniond> last(skeleton.jointCount(), Quaterniond::Identity());
    Frames frames;
    for (int f = 0; f < count; ++f) {
      forwardKinematics(skeleton, source.clip.q.col(f), frames);
      for (int i = 0; i < skeleton.jointCount(); ++i) {
        if (skeleton.vCount(i) == 0) continue;
        const int parent = skeleton.parent(i);
        const Isometry3d local = parent < 0 ? frames[i] : frames[parent].inverse(Eigen::Isometry) * frames[i];
        Quaterniond r = Quaterniond(local.linear()).normalized();
        if (r.dot(last[i]) < 0.0) r.coeffs() = -r.coeffs();
        last[i] = r;
        for (const double value : {r.x(), r.y(), r.z(), r.w()})
          rotations[i].push_back(static_cast<float>(value));
        for (int k = 0; k < 3; ++k) translations[i].push_back(static_cast<float>(local.translation()[k]));
      }
    }
    tinygltf::Animation animation;
    animation.name = source.name;
    const int input = add(times, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_FLOAT, 1);
    const auto addChannel = [&](int node, const std::string& path, int output) {
      tinygltf::AnimationSampler sampler;
      sampler.input = input;
      sampler.output = output;
      sampler.interpolation = "LINEAR";
      tinygltf::AnimationChannel channel;
      channel.sampler = static_cast<int>(animation.samplers.size());
      channel.target_node = node;
      channel.target_path = path;
      animation.samplers.push_back(sampler);
      animation.channels.push_back(channel);
    };
    for (int i = 0; i < skeleton.jointCount(); ++i) {
      if (skeleton.vCount(i) == 0) continue;
      const auto& axes = skeleton.joint(i).axes;
      const bool moves = std::any_of(axes.begin(), axes.end(), [](const AxisDof& dof) {
        return dof.kind == AxisDof::Kind::Translation;
      });
      const bool turns = skeleton.joint(i).ball ||
                         std::any_of(axes.begin(), axes.end(),
                                     [](const AxisDof& dof) { return dof.kind == AxisDof::Kind::Rotation; });
      if (turns)
        addChannel(i, "rotation", add(rotations[i], TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_FLOAT, 4));
      if (moves)
        addChannel(i, "translation",
                   add(translations[i], TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, 3));
    }
    if (!animation.channels.empty()) model_.animations.push_back(animation);
  }

  tinygltf::Model model_;
};

std::string format(const Skeleton& skeleton, const Skin* skin, const std::vector<GltfClip>& clips,
                   bool binary) {
  Writer writer(skeleton, skin, clips);
  tinygltf::TinyGLTF out;
  std::ostringstream stream;
  if (!out.WriteGltfSceneToStream(&writer.model(), stream, !binary, binary))
    throw std::runtime_error("the glTF library could not write the model");
  return stream.str();
}

}  // namespace

std::string formatGlb(const Skeleton& skeleton, const Skin* skin, const std::vector<GltfClip>& clips) {
  return format(skeleton, skin, clips, true);
}

void writeGltf(const std::string& path, const Skeleton& skeleton, const Skin* skin,
               const std::vector<GltfClip>& clips) {
  writeFile(path, format(skeleton, skin, clips, !path.ends_with(".gltf")));
}

}  // namespace gelenk
