#include "skinning/io/skin_cache.h"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <type_traits>

#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

// Header: magic, key, checksum of the rest; then counts and arrays in the machine's own layout: the file
// never leaves it.
constexpr std::string_view magic = "GELENK skin 0001";
constexpr std::size_t headerSize = magic.size() + 2 * sizeof(std::uint64_t);

template <typename T>
void put(std::string& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

void putVector(std::string& out, const Eigen::Vector3d& p) {
  out.append(reinterpret_cast<const char*>(p.data()), 3 * sizeof(double));
}

/// Takes values from the front; throws std::runtime_error at the end of the bytes.
class Taker {
 public:
  explicit Taker(std::string_view bytes) : bytes_(bytes) {}
  template <typename T>
  T take() {
    T value;
    copy(&value, sizeof(T));
    return value;
  }
  void copy(void* to, std::size_t size) {
    if (size > bytes_.size()) throw std::runtime_error("cut short");
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }
  std::size_t count(std::size_t leastBytesEach) {
    const auto n = take<std::uint64_t>();
    if (n > bytes_.size() / leastBytesEach) throw std::runtime_error("cut short");
    return static_cast<std::size_t>(n);
  }
  bool empty() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
};

std::string header(std::uint64_t key, std::string_view body) {
  std::string out(magic);
  put(out, key);
  put(out, checksum(body));
  return out;
}

std::string bodyOf(const Skin& skin) {
  std::string out;
  put(out, static_cast<std::uint64_t>(skin.mesh.positions.size()));
  for (const Eigen::Vector3d& p : skin.mesh.positions) putVector(out, p);
  for (const Eigen::Vector3d& n : skin.mesh.normals) putVector(out, n);
  for (const Influences& in : skin.influences) put(out, in.joints), put(out, in.weights);
  put(out, static_cast<std::uint64_t>(skin.mesh.triangles.size()));
  for (const auto& t : skin.mesh.triangles) put(out, t);
  put(out, static_cast<std::uint64_t>(skin.jointFromRestWorld.size()));
  for (const Eigen::Isometry3d& frame : skin.jointFromRestWorld)
    out.append(reinterpret_cast<const char*>(frame.data()), 16 * sizeof(double));
  return out;
}

Skin skinOf(std::string_view body) {
  Taker from(body);
  Skin skin;
  const std::size_t vertices = from.count(6 * sizeof(double));
  skin.mesh.positions.resize(vertices);
  skin.mesh.normals.resize(vertices);
  skin.influences.resize(vertices);
  for (Eigen::Vector3d& p : skin.mesh.positions) from.copy(p.data(), 3 * sizeof(double));
  for (Eigen::Vector3d& n : skin.mesh.normals) from.copy(n.data(), 3 * sizeof(double));
  for (Influences& in : skin.influences) {
    in.joints = from.take<decltype(in.joints)>();
    in.weights = from.take<decltype(in.weights)>();
  }
  skin.mesh.triangles.resize(from.count(3 * sizeof(int)));
  for (auto& t : skin.mesh.triangles) t = from.take<std::array<int, 3>>();
  skin.jointFromRestWorld.resize(from.count(16 * sizeof(double)));
  for (Eigen::Isometry3d& frame : skin.jointFromRestWorld) from.copy(frame.data(), 16 * sizeof(double));
  if (!from.empty()) throw std::runtime_error("too long");
  validate(skin.mesh);
  for (const Influences& in : skin.influences)
    for (const int joint : in.joints)
      if (joint < 0 || joint >= skin.jointCount()) throw std::runtime_error("a joint that does not exist");
  return skin;
}

}  // namespace

std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return hash;
}

std::string cacheFolder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache)
    return std::string(cache) + "/gelenk";
  if (const char* home = std::getenv("HOME"); home && *home) return std::string(home) + "/.cache/gelenk";
  return "";
}

std::optional<Skin> readCachedSkin(const std::string& path, std::uint64_t key) {
  try {
    const std::string file = readFile(path);
    if (file.size() < headerSize) return std::nullopt;
    const std::string_view body = std::string_view(file).substr(headerSize);
    if (std::string_view(file).substr(0, headerSize) != header(key, body)) return std::nullopt;
    return skinOf(body);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

void writeCachedSkin(const std::string& path, std::uint64_t key, const Skin& skin) {
  const std::string body = bodyOf(skin);
  writeFile(path, header(key, body) + body);
}

Skin cachedSkin(const std::string& folder, const std::string& name, std::uint64_t key,
                const std::function<Skin()>& make) {
  const std::string path = folder + "/" + name + ".skin";
  if (!folder.empty())
    if (std::optional<Skin> skin = readCachedSkin(path, key)) return *std::move(skin);
  Skin skin = make();
  if (folder.empty()) return skin;
  try {
    std::filesystem::create_directories(folder);
    writeCachedSkin(path, key, skin);
  } catch (const std::exception&) {  // the skin is there; only the next start is slower
  }
  return skin;
}

}  // namespace gelenk
