#include "skinning/io/gltf.h"

#include <tiny_gltf.h>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/rotation.h"
#include "skinning/io/gltf_joints.h"
#include "skinning/io/gltf_key_times.h"
#include "skinning/io/picture.h"

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

/// A picture that cannot be decoded is left empty: it changes nothing but colours, and a note tells.
bool decodeImage(tinygltf::Image* image, int index, std::string*, std::string* warning, int width, int height,
                 const unsigned char* bytes, int size, void* user) {
  std::string error;
  if (!tinygltf::LoadImageData(image, index, &error, warning, width, height, bytes, size, user))
    image->image.clear();
  return true;
}

/// What a file must not do without, but this reader does: by name, since the library says something else or
/// nothing. Extensions of materials, textures and lights change colours only: a note tells them.
void refuseRequiredExtensions(std::string_view bytes, bool binary, const std::string& file) {
  std::string_view text = bytes;
  if (binary) {  // a head of 12 bytes, then the length and the type of the chunk of JSON
    std::uint32_t length = 0;
    if (bytes.size() < 20) return;
    std::memcpy(&length, bytes.data() + 12, sizeof length);
    text = bytes.substr(20, length);
  }
  if (text.find("extensionsRequired") == std::string_view::npos) return;
  const auto root = nlohmann::json::parse(text, nullptr, false);
  if (!root.is_object()) return;  // the library tells what is wrong
  const auto required = root.find("extensionsRequired");
  if (required == root.end() || !required->is_array()) return;
  for (const auto& entry : *required) {
    const std::string name = entry.is_string() ? entry.get<std::string>() : "";
    const bool harmless = name == "KHR_mesh_quantization" || name.starts_with("KHR_materials_") ||
                          name.starts_with("KHR_texture_") || name.starts_with("EXT_texture_") ||
                          name.starts_with("MSFT_texture_") || name.starts_with("KHR_lights_") ||
                          name.starts_with("EXT_lights_") || name == "KHR_xmp" || name == "KHR_xmp_json_ld";
    if (!harmless)
      fail(file, "a glTF that needs no extension of meshes, nodes or animations",
           "that it needs " + name + ", which is not read");
  }
}

tinygltf::Model load(std::string_view bytes, const std::string& file, const std::string& folder) {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(decodeImage, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  const bool binary = bytes.substr(0, 4) == "glTF";
  if (!binary) bytes = plainText(bytes, file);
  if (bytes.size() > 0xfffffff0u) fail(file, "a file below 4 GB", std::to_string(bytes.size()) + " bytes");
  refuseRequiredExtensions(bytes, binary, file);
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

/// Numbers that lie in a buffer view, element after element; normalised integers become fractions. Every
/// index and size is checked here, because the library does not.
std::vector<double> numbersInView(const tinygltf::Model& model, int viewIndex, std::size_t byteOffset,
                                  std::size_t count, int componentType, bool normalised, int components,
                                  const std::string& what, const std::string& file) {
  const auto wrong = [&](const std::string& found) {
    fail(file, what + " within the file's buffers", found);
  };
  const int size = tinygltf::GetComponentSizeInBytes(componentType);
  if (size <= 0) wrong("an unknown type of numbers");
  if (viewIndex < 0 || viewIndex >= static_cast<int>(model.bufferViews.size())) wrong("no buffer view");
  const tinygltf::BufferView& view = model.bufferViews[viewIndex];
  if (view.buffer < 0 || view.buffer >= static_cast<int>(model.buffers.size())) wrong("no buffer");
  const auto& data = model.buffers[view.buffer].data;
  const std::size_t element = static_cast<std::size_t>(size) * components,
                    stride = view.byteStride ? view.byteStride : element;
  if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
    wrong("a view beyond its buffer");
  if (count == 0) return {};
  if (stride < element || byteOffset > view.byteLength || element > view.byteLength - byteOffset ||
      (count - 1) > (view.byteLength - byteOffset - element) / stride)
    wrong(std::to_string(count) + " elements in " + std::to_string(view.byteLength) + " bytes");

  std::vector<double> values;
  values.reserve(count * components);
  const auto read = [&](const unsigned char* at, auto zero, double largest) {
    std::memcpy(&zero, at, sizeof zero);
    const double value = static_cast<double>(zero);
    return normalised && largest > 0.0 ? std::max(-1.0, value / largest) : value;
  };
  for (std::size_t e = 0; e < count; ++e)
    for (int c = 0; c < components; ++c) {
      const unsigned char* at =
          data.data() + view.byteOffset + byteOffset + e * stride + static_cast<std::size_t>(c) * size;
      double value = 0.0;
      switch (componentType) {
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

/// The numbers of an accessor: of its view (zeros where it has none), with sparse ones put in their places.
std::vector<double> numbers(const tinygltf::Model& model, int index, int components, const std::string& what,
                            const std::string& file) {
  const auto wrong = [&](const std::string& found) {
    fail(file, what + " within the file's buffers", found);
  };
  if (index < 0 || index >= static_cast<int>(model.accessors.size()))
    wrong("accessor " + std::to_string(index));
  const tinygltf::Accessor& accessor = model.accessors[index];
  const int found = tinygltf::GetNumComponentsInType(accessor.type);
  if (found != components)
    wrong(std::to_string(found) + " components instead of " + std::to_string(components));
  const auto& sparse = accessor.sparse;
  std::vector<double> values;
  if (accessor.bufferView >= 0) {
    values = numbersInView(model, accessor.bufferView, accessor.byteOffset, accessor.count,
                           accessor.componentType, accessor.normalized, components, what, file);
  } else {
    if (!sparse.isSparse) wrong("no buffer view");
    if (accessor.count > 1'000'000u) wrong(std::to_string(accessor.count) + " elements without a buffer");
    values.assign(accessor.count * components, 0.0);
  }
  if (!sparse.isSparse) return values;
  if (sparse.count < 0) wrong("a negative number of sparse elements");
  const auto at = numbersInView(model, sparse.indices.bufferView, sparse.indices.byteOffset, sparse.count,
                                sparse.indices.componentType, false, 1, what, file);
  const auto replaced = numbersInView(model, sparse.values.bufferView, sparse.values.byteOffset, sparse.count,
                                      accessor.componentType, accessor.normalized, components, what, file);
  for (std::size_t e = 0; e < at.size(); ++e) {
    if (!(at[e] >= 0.0 && at[e] < static_cast<double>(accessor.count)))
      wrong("sparse element " + exactNumber(at[e]));
    std::copy_n(&replaced[e * components], components, &values[static_cast<std::size_t>(at[e]) * components]);
  }
  return values;
}

/// A node's place: rotation * stretch, then translation. The stretch is a scale for most nodes; unequal
/// scales, mirrors and shear are kept in it.
struct Placement {
  Quaterniond rotation = Quaterniond::Identity();
  Vector3d translation = Vector3d::Zero();
  Matrix3d stretch = Matrix3d::Identity();
  bool even = true;  ///< stretch = scale * identity, scale > 0
  double scale = 1.0;
};

/// A = rotation * stretch with the rotation nearest to A.
void splitRotation(const Matrix3d& A, Placement& place) {
  const Eigen::JacobiSVD<Matrix3d> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) = -U.col(2);
  const Matrix3d R = U * svd.matrixV().transpose();
  place.rotation = Quaterniond(R).normalized();
  place.stretch = place.rotation.toRotationMatrix().transpose() * A;
}

/// rotation: the node's own, which is kept where the scales are unequal.
Placement placement(const Matrix4d& matrix, const std::optional<Quaterniond>& rotation,
                    const std::string& file, const std::string& node) {
  Placement place;
  if (!matrix.allFinite()) fail(file, "finite node transforms", "none in node '" + node + "'");
  const Matrix3d A = matrix.topLeftCorner<3, 3>();
  place.translation = matrix.topRightCorner<3, 1>();
  place.scale = std::cbrt(A.determinant());
  place.even = std::isfinite(place.scale) && place.scale > 1e-12 &&
               (A * A.transpose() / (place.scale * place.scale)).isIdentity(1e-4);
  if (place.even) {
    place.rotation = Quaterniond(Matrix3d(A / place.scale)).normalized();
    place.stretch = place.scale * Matrix3d::Identity();
  } else if (rotation) {
    place.rotation = *rotation;
    place.stretch = place.rotation.toRotationMatrix().transpose() * A;
  } else {
    splitRotation(A, place);
  }
  return place;
}

Placement localPlacement(const tinygltf::Node& node, const std::string& file) {
  if (node.matrix.size() == 16)
    return placement(Eigen::Map<const Matrix4d>(node.matrix.data()), {}, file, node.name);
  Matrix4d matrix = Matrix4d::Identity();
  Quaterniond rotation = Quaterniond::Identity();
  if (node.rotation.size() == 4) {
    const Quaterniond q(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    if (!(std::abs(q.norm() - 1.0) < 1e-2))
      fail(file, "unit quaternions", "length " + exactNumber(q.norm()) + " in node '" + node.name + "'");
    rotation = q.normalized();
    matrix.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
  }
  if (node.scale.size() == 3)
    for (int k = 0; k < 3; ++k) matrix.col(k).head<3>() *= node.scale[k];
  if (node.translation.size() == 3)
    matrix.topRightCorner<3, 1>() = Vector3d(node.translation[0], node.translation[1], node.translation[2]);
  return placement(matrix, rotation, file, node.name);
}

enum class Between { Line, Step, Spline };

struct Sampler {
  std::vector<double> times, values;
  std::vector<double> tangents = {};  ///< Spline: in and out of every key, in units a second
  int components = 0;
  Between between = Between::Line;
};

/// The keys before and after a time, and where it lies between them, 0 to 1.
struct Span {
  std::size_t a, b;
  double s, seconds;  ///< seconds: from a to b
};
Span spanAt(const Sampler& sampler, double seconds) {
  // A frame that is meant to lie on a key may miss it by the rounding of floats.
  if (sampler.between != Between::Line) {
    const auto near = std::lower_bound(sampler.times.begin(), sampler.times.end(), seconds);
    const double tolerance = std::max(1e-6, 4e-7 * std::abs(seconds));
    if (near != sampler.times.end() && *near - seconds < tolerance) seconds = *near;
  }
  const auto after = std::upper_bound(sampler.times.begin(), sampler.times.end(), seconds);
  const std::size_t b = std::min<std::size_t>(after - sampler.times.begin(), sampler.times.size() - 1);
  const std::size_t a =
      after == sampler.times.begin() ? 0 : static_cast<std::size_t>(after - sampler.times.begin()) - 1;
  const double span = sampler.times[b] - sampler.times[a];
  const double s = span > 0.0 && sampler.between != Between::Step
                       ? std::clamp((seconds - sampler.times[a]) / span, 0.0, 1.0)
                       : 0.0;
  return {a, b, s, span};
}

/// Cubic Hermite spline of glTF 2.0, appendix C, component by component.
template <int n>
Eigen::Matrix<double, n, 1> spline(const Sampler& sampler, const Span& at) {
  using Vector = Eigen::Matrix<double, n, 1>;
  const auto value = [&](std::size_t k) -> Vector { return Vector::Map(&sampler.values[n * k]); };
  const auto tangent = [&](std::size_t k) -> Vector { return Vector::Map(&sampler.tangents[n * k]); };
  const double s = at.s, s2 = s * s, s3 = s2 * s;
  return (2.0 * s3 - 3.0 * s2 + 1.0) * value(at.a) +
         at.seconds * (s3 - 2.0 * s2 + s) * tangent(2 * at.a + 1) + (3.0 * s2 - 2.0 * s3) * value(at.b) +
         at.seconds * (s3 - s2) * tangent(2 * at.b);
}

Vector3d vectorAt(const Sampler& sampler, double seconds) {
  const Span at = spanAt(sampler, seconds);
  if (sampler.between == Between::Spline) return spline<3>(sampler, at);
  return (1.0 - at.s) * Eigen::Map<const Vector3d>(&sampler.values[3 * at.a]) +
         at.s * Eigen::Map<const Vector3d>(&sampler.values[3 * at.b]);
}

/// Lines are great arcs, along the shorter way.
Quaterniond rotationAt(const Sampler& sampler, double seconds) {
  const Span at = spanAt(sampler, seconds);
  const double* a = &sampler.values[4 * at.a];
  const double* b = &sampler.values[4 * at.b];
  const Quaterniond p(a[3], a[0], a[1], a[2]), q(b[3], b[0], b[1], b[2]);
  if (sampler.between == Between::Spline) {
    const Eigen::Vector4d v = spline<4>(sampler, at);
    if (v.norm() > 1e-9) return Quaterniond(v[3], v[0], v[1], v[2]).normalized();
  }
  return p.normalized().slerp(at.s, q.normalized());
}

class Reader {
 public:
  Reader(const tinygltf::Model& model, const std::string& file, const GltfOptions& options)
      : model_(model), file_(file), options_(options) {}

  GltfModel read() {
    tellRequiredExtensions();
    findUses();
    visitNodes();
    makeSkeleton();
    readMeshes();
    for (const tinygltf::Animation& animation : model_.animations) readAnimation(animation);
    return std::move(result_);
  }

 private:
  /// Those that refuseRequiredExtensions lets pass, without the ones that are read or mean nothing here.
  void tellRequiredExtensions() {
    std::vector<std::string> unread;
    for (const std::string& name : model_.extensionsRequired)
      if (name != "KHR_mesh_quantization" && !name.starts_with("KHR_xmp")) unread.push_back(name);
    if (!unread.empty())
      tell(result_.notes, "extension-unread",
           "the file needs extensions that are not read, so that colours differ: " + listed(unread),
           static_cast<int>(unread.size()));
  }

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

  /// Axes and limits that this program wrote beside the node: the node's frame is where they rest.
  bool takeMotion(const tinygltf::Node& node, Joint& joint, std::vector<double>& rest) const {
    try {
      const auto motion = motionOf(node.extras);
      if (!motion) return false;
      joint.axes = motion->axes;
      joint.ball = motion->ball;
      joint.ballLimit = motion->ballLimit;
      Joint alone = joint;
      alone.parent = -1;
      alone.parentFromZero.setIdentity();
      const Eigen::VectorXd q = Eigen::VectorXd::Map(motion->rest.data(), motion->rest.size());
      const Isometry3d turned = jointMotion(Skeleton({alone}, q), q, 0);
      joint.parentFromZero = joint.parentFromZero * turned.inverse(Eigen::Isometry);
      rest.insert(rest.end(), motion->rest.begin(), motion->rest.end());
      return true;
    } catch (const std::invalid_argument& wrong) {
      fail(file_, "the motion of node '" + node.name + "' in its extras", wrong.what());
    }
  }

  void makeSkeleton() {
    std::vector<Joint> joints;
    std::vector<double> rest;
    std::set<std::string> names;
    for (std::size_t j = 0; j < order_.size(); ++j) {
      const int n = order_[j];
      std::string name = n < 0                          ? "scene"
                         : model_.nodes[n].name.empty() ? "node" + std::to_string(n)
                                                        : model_.nodes[n].name;
      for (int k = 2; !names.insert(name).second; ++k)
        name = (n < 0 ? "scene" : model_.nodes[n].name) + "_" + std::to_string(k);
      Placement local = n < 0 ? Placement{} : localPlacement(model_.nodes[n], file_);
      if (parents_[j] >= 0) placeBelow(world_[parents_[j]], n, local);
      if (!local.translation.allFinite() || !local.stretch.allFinite())
        fail(file_, "finite node transforms", "an overflow");
      world_.push_back(local);
      Joint joint{.name = name, .parent = parents_[j]};
      joint.parentFromZero.linear() = local.rotation.toRotationMatrix();
      joint.parentFromZero.translation() = local.translation;
      joint.ball = n >= 0 && turns_[n];
      if (n >= 0 && model_.animations.empty() && takeMotion(model_.nodes[n], joint, rest)) {
        joints.push_back(std::move(joint));
        continue;
      }
      if (n >= 0 && (moves_[n] || (j == 0 && turns_[n])))
        for (int k = 0; k < 3; ++k)  // along the parent's axes
          joint.axes.push_back(
              {AxisDof::Kind::Translation, (local.rotation.conjugate() * Vector3d::Unit(k)).normalized()});
      rest.insert(rest.end(), joint.axes.size(), 0.0);
      if (joint.ball) rest.insert(rest.end(), {1.0, 0.0, 0.0, 0.0});
      joints.push_back(std::move(joint));
    }
    result_.skeleton = Skeleton(std::move(joints), Eigen::VectorXd::Map(rest.data(), rest.size()));
    restFrames_ = restFrames(result_.skeleton);
  }

  /// From a node's own placement to its joint's: what stretches above it goes through to its offset and
  /// below.
  void placeBelow(const Placement& above, int n, Placement& local) const {
    if (above.even) {
      local.translation *= above.scale;
      local.scale *= above.scale;
      local.stretch *= above.scale;
      return;
    }
    if (turns_[n])
      fail(file_, "one positive scale above nodes that turn",
           "unequal scales, a mirror or shear above node '" + model_.nodes[n].name + "'");
    local.translation = above.stretch * local.translation;
    splitRotation(above.stretch * local.rotation.toRotationMatrix() * local.stretch, local);
    local.even = false;
  }

  Matrix4d worldFromNode(int joint) const {
    Matrix4d matrix = restFrames_[joint].matrix();
    if (world_[joint].even)
      matrix.topLeftCorner<3, 3>() *= world_[joint].scale;
    else
      matrix.topLeftCorner<3, 3>() *= world_[joint].stretch;
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
    const auto vertices = mesh.positions.size();
    result_.skin = bindSkin(std::move(mesh), restFrames_, std::move(influences));
    readMaterials(vertices);
    if (direct) result_.skin->jointFromRestWorld = bind;
  }

  /// True if the only skin's inverse bind matrices are rigid and no node is scaled: then they are kept, so
  /// that a bind pose other than the file's own pose survives. bind: filled with them. False also where the
  /// bind pose is the file's own pose moved as a whole, as below a turned node: the body then stands as in
  /// the scene.
  bool bindMatricesAreRigid(std::vector<Isometry3d>& bind) const {
    if (model_.skins.size() != 1) return false;
    for (const Placement& node : world_)
      if (!node.even || std::abs(node.scale - 1.0) > 1e-6) return false;
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
    const auto& carriers = model_.skins[0].joints;
    const auto moved = [&](int n) {
      return Matrix4d((restFrames_[jointOfNode_[n]] * candidate[jointOfNode_[n]]).matrix());
    };
    if (!carriers.empty() && !moved(carriers[0]).isIdentity(1e-5) &&
        std::all_of(carriers.begin(), carriers.end(),
                    [&](int n) { return (moved(n) - moved(carriers[0])).cwiseAbs().maxCoeff() < 1e-5; }))
      return false;
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
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
        mode != TINYGLTF_MODE_TRIANGLE_FAN) {
      tell(result_.notes, "primitives-skipped", "points or lines are passed over");
      return;
    }
    if (!primitive.targets.empty())
      tell(result_.notes, "morph-targets", "morph targets of a mesh are passed over");
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
        if (own[v].empty()) {
          if (skin.joints.empty()) fail(file_, "a skin with joints", "none");
          tell(result_.notes, "weightless-vertices",
               "vertices of a skinned mesh without weights are held by the skin's first joint");
          own[v].emplace_back(0, 1.0);
        }
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
    const int firstTriangle = static_cast<int>(mesh.triangles.size());
    readPaint(primitive, base, count);
    std::vector<double> indices;
    if (primitive.indices >= 0) {
      indices = numbers(model_, primitive.indices, 1, "indices of triangles", file_);
    } else {
      for (std::size_t v = 0; v < count; ++v) indices.push_back(static_cast<double>(v));
    }
    if (mode == TINYGLTF_MODE_TRIANGLES && indices.size() % 3 != 0)
      fail(file_, "three indices a triangle", std::to_string(indices.size()));
    const bool mirrored =
        node.skin < 0 && worldFromNode(jointOfNode_[n]).topLeftCorner<3, 3>().determinant() < 0.0;
    for (const std::array<std::size_t, 3>& corners : cornersOf(mode, indices.size())) {
      std::array<int, 3> triangle{};
      for (int k = 0; k < 3; ++k) {
        const double index = indices[corners[k]];
        if (index < 0.0 || index >= static_cast<double>(count))
          fail(file_, "triangle corners below " + std::to_string(count), exactNumber(index));
        triangle[k] = static_cast<int>(base) + static_cast<int>(index);
      }
      if (mirrored) std::swap(triangle[1], triangle[2]);
      const bool flat =
          triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
      if (mode == TINYGLTF_MODE_TRIANGLES || !flat)
        mesh.triangles.push_back(triangle);  // strips turn by these
    }
    look_.parts.push_back({.name = node.name.empty() ? model_.meshes[node.mesh].name : node.name,
                           .firstTriangle = firstTriangle,
                           .triangleCount = static_cast<int>(mesh.triangles.size()) - firstTriangle,
                           .material = materialIndex(primitive)});
  }

  /// Materials of the file in its order, then one for what has none.
  int materialIndex(const tinygltf::Primitive& primitive) const {
    const int count = static_cast<int>(model_.materials.size());
    return primitive.material >= 0 && primitive.material < count ? primitive.material : count;
  }

  /// Texture coordinates and colours of one part's vertices.
  void readPaint(const tinygltf::Primitive& primitive, std::size_t base, std::size_t count) {
    const auto accessor = [&](const std::string& name) {
      const auto at = primitive.attributes.find(name);
      return at == primitive.attributes.end() ? -1 : at->second;
    };
    int set = 0;
    if (const int m = materialIndex(primitive); m < static_cast<int>(model_.materials.size()))
      set = model_.materials[m].pbrMetallicRoughness.baseColorTexture.texCoord;
    if (const int at = accessor("TEXCOORD_" + std::to_string(set)); at >= 0) {
      const auto values = numbers(model_, at, 2, "texture coordinates", file_);
      if (values.size() != 2 * count) fail(file_, "one texture coordinate a vertex", "another count");
      look_.coordinates.resize(base + count, Eigen::Vector2f::Zero());
      for (std::size_t v = 0; v < count; ++v)
        look_.coordinates[base + v] = {static_cast<float>(values[2 * v]),
                                       static_cast<float>(values[2 * v + 1])};
    }
    if (const int at = accessor("COLOR_0"); at >= 0 && at < static_cast<int>(model_.accessors.size())) {
      const int components = model_.accessors[at].type == TINYGLTF_TYPE_VEC4 ? 4 : 3;
      const auto values = numbers(model_, at, components, "vertex colours", file_);
      if (values.size() != components * count) fail(file_, "one colour a vertex", "another count");
      look_.colours.resize(base + count, Eigen::Vector3f::Ones());
      for (std::size_t v = 0; v < count; ++v)
        for (int k = 0; k < 3; ++k)
          look_.colours[base + v][k] = std::clamp(
              static_cast<float>(values[components * v + static_cast<std::size_t>(k)]), 0.0f, 1.0f);
    }
  }

  void readMaterials(std::size_t vertices) {
    if (!look_.coordinates.empty()) look_.coordinates.resize(vertices, Eigen::Vector2f::Zero());
    if (!look_.colours.empty()) look_.colours.resize(vertices, Eigen::Vector3f::Ones());
    std::vector<int> textureOfImage(model_.images.size(), -1);
    for (const tinygltf::Material& source : model_.materials) {
      Material material{.name = source.name, .doubleSided = source.doubleSided};
      const auto& factor = source.pbrMetallicRoughness.baseColorFactor;
      for (int k = 0; k < 4 && factor.size() == 4; ++k)
        material.colour[k] = std::clamp(static_cast<float>(factor[k]), 0.0f, 1.0f);
      if (source.alphaMode == "MASK") material.cutOff = static_cast<float>(source.alphaCutoff);
      if (source.alphaMode == "BLEND") material.cutOff = blendCutOff;
      if (source.alphaMode == "OPAQUE") material.colour.w() = 1.0f;
      material.gloss =
          static_cast<float>(std::clamp(0.4 * (1.0 - source.pbrMetallicRoughness.roughnessFactor), 0.0, 1.0));
      const int t = source.pbrMetallicRoughness.baseColorTexture.index;
      const int image =
          t >= 0 && t < static_cast<int>(model_.textures.size()) ? model_.textures[t].source : -1;
      if (image >= 0 && image < static_cast<int>(model_.images.size()) && look_.coordinates.size() > 0)
        material.texture = textureOf(model_.images[image], textureOfImage[image]);
      look_.materials.push_back(std::move(material));
    }
    look_.materials.push_back({.name = "none"});
    result_.look = std::make_shared<const MeshLook>(std::move(look_));
  }

  /// Index among the look's textures, -1 where the picture could not be read.
  int textureOf(const tinygltf::Image& image, int& known) {
    if (known >= 0) return known;
    const int bytes = image.bits / 8;
    const auto pixels = static_cast<std::size_t>(std::max(0, image.width)) * std::max(0, image.height);
    if (pixels == 0 || bytes < 1 || image.component < 1 ||
        image.image.size() < pixels * bytes * image.component) {
      tell(result_.notes, "texture-missing",
           "textures that could not be read: their surfaces have one colour");
      return -1;
    }
    Texture texture{
        .width = image.width, .height = image.height, .rgba = std::vector<std::uint8_t>(4 * pixels)};
    for (std::size_t p = 0; p < pixels; ++p)
      for (int k = 0; k < 4; ++k) {
        const bool grey = image.component < 3;
        const int from = k == 3 ? image.component - 1 : grey ? 0 : k;
        const bool opaque = k == 3 && image.component % 2 == 1;
        texture.rgba[4 * p + k] =
            opaque ? 255 : image.image[(p * image.component + from) * bytes + (bytes - 1)];
      }
    if (!image.uri.empty() && !image.uri.starts_with("data:"))
      texture.file = (std::filesystem::path(file_).parent_path() / image.uri).string();
    known = static_cast<int>(look_.textures.size());
    look_.textures.push_back(std::make_shared<const Texture>(std::move(texture)));
    return known;
  }

  /// Which places in the list of indices make each triangle, counter-clockwise all of them.
  static std::vector<std::array<std::size_t, 3>> cornersOf(int mode, std::size_t count) {
    std::vector<std::array<std::size_t, 3>> corners;
    if (mode == TINYGLTF_MODE_TRIANGLES)
      for (std::size_t i = 0; i + 2 < count; i += 3) corners.push_back({i, i + 1, i + 2});
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
      for (std::size_t i = 0; i + 2 < count; ++i) corners.push_back({i, i + 1 + i % 2, i + 2 - i % 2});
    if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
      for (std::size_t i = 1; i + 1 < count; ++i) corners.push_back({i, i + 1, 0});
    return corners;
  }

  Sampler sampler(const tinygltf::Animation& animation, const tinygltf::AnimationChannel& channel) {
    if (channel.sampler < 0 || channel.sampler >= static_cast<int>(animation.samplers.size()))
      fail(file_, "a sampler of the animation", std::to_string(channel.sampler));
    const tinygltf::AnimationSampler& source = animation.samplers[channel.sampler];
    Sampler result{.times = numbers(model_, source.input, 1, "key times", file_),
                   .values = {},
                   .components = channel.target_path == "rotation" ? 4 : 3};
    result.values = numbers(model_, source.output, result.components, "key values", file_);
    if (source.interpolation == "STEP") {
      result.between = Between::Step;
    } else if (source.interpolation == "CUBICSPLINE") {  // (in-tangent, value, out-tangent) a key
      result.between = Between::Spline;
      const auto c = static_cast<std::ptrdiff_t>(result.components);
      if (result.values.size() != 3 * c * result.times.size())
        fail(file_, "two tangents and one value a key time",
             std::to_string(result.values.size() / c) + " for " + std::to_string(result.times.size()));
      std::vector<double> keys;
      for (auto at = result.values.begin(); at != result.values.end(); at += 3 * c) {
        result.tangents.insert(result.tangents.end(), at, at + c);
        keys.insert(keys.end(), at + c, at + 2 * c);
        result.tangents.insert(result.tangents.end(), at + 2 * c, at + 3 * c);
      }
      result.values = std::move(keys);
    } else if (source.interpolation != "LINEAR" && !source.interpolation.empty()) {
      fail(file_, "LINEAR, STEP or CUBICSPLINE as interpolation", "'" + source.interpolation + "'");
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
        const auto& own = model_.nodes[channel.target_node].scale;
        const Vector3d rest = own.size() == 3 ? Vector3d(own[0], own[1], own[2]) : Vector3d::Ones();
        for (std::size_t i = 0; i < scales.values.size(); ++i)
          if (std::abs(scales.values[i] - rest[i % 3]) > 1e-3 * std::abs(rest[i % 3])) {
            tell(result_.notes, "scale-animation",
                 "animation '" + animation.name + "' changes the scale of '" +
                     result_.skeleton.joint(joint).name + "': passed over");
            break;
          }
        continue;
      }
      if (channel.target_path == "weights")
        tell(result_.notes, "morph-targets", "morph targets of a mesh are passed over");
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
    const bool linear = std::all_of(tracks.begin(), tracks.end(), [](const Track& track) {
      return track.keys.between == Between::Line || track.keys.times.size() == 1;
    });
    std::string name =
        animation.name.empty() ? "animation" + std::to_string(result_.clips.size()) : animation.name;
    const std::string plain = name;
    const auto taken = [&] {
      return std::any_of(result_.clips.begin(), result_.clips.end(),
                         [&](const GltfClip& other) { return other.name == name; });
    };
    for (int n = 2; taken(); ++n) name = plain + "_" + std::to_string(n);
    if (!even || !linear) {  // frames alone cannot hold it
      constexpr double fine = 60.0;
      rate = options_.framesPerSecond ? *options_.framesPerSecond
             : even                   ? rate * std::ceil(fine / rate)
                                      : fine;
      char text[32];
      std::snprintf(text, sizeof text, "%.6g Hz", rate);
      tell(result_.notes, "resampled",
           "animation '" + name + "': " +
               (linear ? "keys at uneven times" : "steps or splines between keys") + ", sampled at " + text);
    }
    const double frames = std::floor((last - first) * rate + 0.5) + 1.0;
    if (!(frames < 1e6)) fail(file_, "an animation of fewer than a million frames", exactNumber(frames));
    if (!(frames * result_.skeleton.nq() < 5e7))
      fail(file_, "an animation of fewer than 50 million values",
           exactNumber(frames * result_.skeleton.nq()));
    const int count = static_cast<int>(frames);
    GltfClip clip{name, {.framesPerSecond = rate, .q = Eigen::MatrixXd(result_.skeleton.nq(), count)}};
    for (int f = 0; f < count; ++f) {
      Eigen::VectorXd q = neutral(result_.skeleton);
      for (const Track& track : tracks) {
        const Placement& rest = world_[track.joint];
        const double seconds = first + f / rate;
        if (track.rotation) {
          setBallRotation(result_.skeleton, q, track.joint,
                          (rest.rotation.conjugate() * rotationAt(track.keys, seconds)).normalized());
        } else {
          const int up = parents_[track.joint];
          const Vector3d at = vectorAt(track.keys, seconds);
          const Vector3d moved = (up < 0            ? at
                                  : world_[up].even ? Vector3d(world_[up].scale * at)
                                                    : Vector3d(world_[up].stretch * at)) -
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
  const GltfOptions& options_;
  GltfModel result_;
  MeshLook look_;
  std::vector<bool> turns_, moves_;
  std::vector<int> order_, parents_,
      jointOfNode_;               ///< order_: node of each joint, -1 for the joint above all roots
  std::vector<Placement> world_;  ///< one a joint: rotation and translation (metres) in the parent's frame,
                                  ///< stretch from the node to the joint's frame
  Frames restFrames_;
};

}  // namespace

GltfModel parseGltf(std::string_view bytes, const std::string& file, const std::string& folder,
                    const GltfOptions& options) {
  if (options.framesPerSecond && !(*options.framesPerSecond > 0.0))
    throw std::invalid_argument("a frame rate must be positive");
  const tinygltf::Model model = load(bytes, file, folder);
  return Reader(model, file, options).read();
}

GltfModel readGltf(const std::string& path, const GltfOptions& options) {
  return parseGltf(readFile(path), path, std::filesystem::path(path).parent_path().string(), options);
}

namespace {

/// Appends data to the only buffer and describes it.
class Writer {
 public:
  Writer(const Skeleton& skeleton, const Skin* skin, const std::vector<GltfClip>& clips, GltfJoints joints)
      : joints_(joints) {
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
      if (joints_ == GltfJoints::AsTheyMove) {
        const double* first = skeleton.rest().data() + skeleton.qIndex(i);
        node.extras = withMotion(skeleton.joint(i), {first, first + skeleton.qCount(i)});
      }
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
    const std::vector<float> times = gltfKeyTimes(count, source.clip.framesPerSecond);
    std::vector<std::vector<float>> rotations(skeleton.jointCount()), translations(skeleton.jointCount());
    std::vector<Quaterniond> last(skeleton.jointCount(), Quaterniond::Identity());
    Frames frames;
    for (int f = 0; f < count; ++f) {
      forwardKinematics(skeleton, source.clip.q.col(f), frames);
      for (int i = 0; i < skeleton.jointCount(); ++i) {
        if (skeleton.qCount(i) == 0) continue;
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
      if (skeleton.qCount(i) == 0) continue;
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

  GltfJoints joints_;
  tinygltf::Model model_;
};

std::string format(const Skeleton& skeleton, const Skin* skin, const std::vector<GltfClip>& clips,
                   bool binary, GltfJoints joints) {
  Writer writer(skeleton, skin, clips, joints);
  tinygltf::TinyGLTF out;
  std::ostringstream stream;
  if (!out.WriteGltfSceneToStream(&writer.model(), stream, !binary, binary))
    throw std::runtime_error("the glTF library could not write the model");
  return stream.str();
}

}  // namespace

std::string formatGlb(const Skeleton& skeleton, const Skin* skin, const std::vector<GltfClip>& clips) {
  return format(skeleton, skin, clips, true, GltfJoints::Frames);
}

void writeGltf(const std::string& path, const Skeleton& skeleton, const Skin* skin,
               const std::vector<GltfClip>& clips, GltfJoints joints) {
  writeFile(path, format(skeleton, skin, clips, !path.ends_with(".gltf"), joints));
}

}  // namespace gelenk
