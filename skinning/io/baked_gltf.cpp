#include "skinning/io/baked_gltf.h"

#include <Eigen/Geometry>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "kinematics/io/text_file.h"
#include "skinning/io/gltf_key_times.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

/// The binary part and what the JSON says of it: a view and an accessor for every array.
class Arrays {
 public:
  /// Returns the accessor's number. target: 34962 vertices, 34963 indices, 0 neither.
  template <class T>
  int add(const std::vector<T>& data, std::size_t components, int componentType, const char* type, int target,
          const std::string& bounds = "") {
    const std::size_t begin = bytes_.size(), size = data.size() * sizeof(T);
    bytes_.resize(begin + size);
    if (size > 0) std::memcpy(bytes_.data() + begin, data.data(), size);
    comma(views_) << "{\"buffer\":0,\"byteOffset\":" << begin << ",\"byteLength\":" << size;
    if (target != 0) views_ << ",\"target\":" << target;
    views_ << "}";
    comma(accessors_) << "{\"bufferView\":" << count_ << ",\"componentType\":" << componentType
                      << ",\"count\":" << data.size() / components << ",\"type\":\"" << type << "\"" << bounds
                      << "}";
    return count_++;
  }
  int addVectors(const std::vector<Vector3d>& vectors) {
    std::vector<float> data;
    Eigen::AlignedBox3f box;
    for (const Vector3d& v : vectors) {
      const Eigen::Vector3f f = v.cast<float>();
      box.extend(f);
      data.insert(data.end(), {f.x(), f.y(), f.z()});
    }
    std::ostringstream bounds;
    bounds.precision(9);
    bounds << ",\"min\":[" << box.min().x() << "," << box.min().y() << "," << box.min().z() << "],\"max\":["
           << box.max().x() << "," << box.max().y() << "," << box.max().z() << "]";
    return add(data, 3, 5126, "VEC3", 34962, bounds.str());
  }
  std::string views() const { return views_.str(); }
  std::string accessors() const { return accessors_.str(); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::ostringstream& comma(std::ostringstream& list) {
    if (count_ > 0) list << ",";
    return list;
  }
  std::string bytes_;
  std::ostringstream views_, accessors_;
  int count_ = 0;
};

void put(std::string& out, std::uint32_t value) {
  for (int k = 0; k < 4; ++k) out.push_back(static_cast<char>(value >> 8 * k & 0xff));
}

std::vector<Vector3d> differences(const std::vector<Vector3d>& from, const std::vector<Vector3d>& to) {
  std::vector<Vector3d> out(from.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = to[i] - from[i];
  return out;
}

}  // namespace

void writeBakedGltf(const std::string& path, const Mesh& mesh, int frames, double framesPerSecond,
                    const std::function<SkinnedVertices(int)>& surface) {
  if (frames < 1) throw std::invalid_argument("a motion without a frame cannot be baked");
  if (!(framesPerSecond > 0.0)) throw std::invalid_argument("a baked motion needs a frame rate above 0");
  Arrays arrays;
  std::vector<std::uint32_t> indices;
  for (const auto& t : mesh.triangles)
    for (const int corner : t) indices.push_back(static_cast<std::uint32_t>(corner));
  const SkinnedVertices first = surface(0);
  const int indexArray = arrays.add(indices, 1, 5125, "SCALAR", 34963);
  const int positionArray = arrays.addVectors(first.positions),
            normalArray = arrays.addVectors(first.normals);
  std::ostringstream targets;
  for (int f = 1; f < frames; ++f) {  // the mesh itself is the first frame
    const SkinnedVertices now = surface(f);
    if (now.positions.size() != mesh.positions.size() || now.normals.size() != mesh.positions.size())
      throw std::invalid_argument("a baked surface has another number of vertices than its mesh");
    const int moved = arrays.addVectors(differences(first.positions, now.positions));
    const int turned = arrays.addVectors(differences(first.normals, now.normals));
    targets << (f > 1 ? "," : "") << "{\"POSITION\":" << moved << ",\"NORMAL\":" << turned << "}";
  }
  std::ostringstream json;
  json
      << "{\"asset\":{\"version\":\"2.0\",\"generator\":\"gelenk\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
      << "\"nodes\":[{\"mesh\":0,\"name\":\"baked "
         "skin\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":"
      << positionArray << ",\"NORMAL\":" << normalArray << "},\"indices\":" << indexArray;
  if (frames > 1) {
    const std::vector<float> times = gltfKeyTimes(frames, framesPerSecond);
    std::vector<float> weights;
    for (int f = 0; f < frames; ++f)
      for (int t = 1; t < frames; ++t) weights.push_back(t == f ? 1.0f : 0.0f);
    std::ostringstream range;
    range.precision(9);
    range << ",\"min\":[0],\"max\":[" << times.back() << "]";
    const int input = arrays.add(times, 1, 5126, "SCALAR", 0, range.str());
    const int output = arrays.add(weights, 1, 5126, "SCALAR", 0);
    json << ",\"targets\":[" << targets.str() << "]}],\"weights\":[";
    for (int t = 1; t < frames; ++t) json << (t > 1 ? ",0" : "0");
    json << "]}],\"animations\":[{\"name\":\"baked\",\"samplers\":[{\"input\":" << input
         << ",\"output\":" << output
         << ",\"interpolation\":\"LINEAR\"}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
            "\"weights\"}}]}]";
  } else {
    json << "}]}]";
  }
  json << ",\"buffers\":[{\"byteLength\":" << arrays.bytes().size() << "}],\"bufferViews\":["
       << arrays.views() << "],\"accessors\":[" << arrays.accessors() << "]}";

  std::string text = json.str(), binary = arrays.bytes();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  const std::size_t whole = 12 + 8 + text.size() + 8 + binary.size();
  if (whole > 0xffffffffu)
    throw std::runtime_error("'" + path + "' would be larger than the 4 GB that a glb holds");
  std::string out = "glTF";
  put(out, 2);
  put(out, static_cast<std::uint32_t>(whole));
  put(out, static_cast<std::uint32_t>(text.size()));
  out += "JSON" + text;
  put(out, static_cast<std::uint32_t>(binary.size()));
  out += std::string("BIN\0", 4) + binary;
  writeFile(path, out);
}

}  // namespace gelenk
