#include "skinning/io/prepared_cache.h"

#include <cctype>
#include <cstring>
#include <filesystem>
#include <optional>
#include <vector>

#include "kinematics/io/text_file.h"
#include "skinning/io/skin_cache.h"

namespace gelenk {
namespace {

/// Raise it when smoothing or centres change their result.
constexpr std::uint64_t methodVersion = 4;

template <class T>
void put(std::string& out, const std::vector<T>& values) {
  out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}
void put(std::string& out, std::uint64_t value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
bool take(std::string_view& from, std::vector<T>& values, std::size_t count) {
  if (from.size() < count * sizeof(T)) return false;
  values.resize(count);
  if (count > 0) std::memcpy(static_cast<void*>(values.data()), from.data(), count * sizeof(T));
  from.remove_prefix(count * sizeof(T));
  return true;
}

std::uint64_t keyOf(const Skin& skin, const SkinChoice& choice) {
  std::string facts = toString(choice);
  put(facts, methodVersion);
  put(facts, skin.mesh.positions);
  put(facts, skin.mesh.triangles);
  for (const Influences& in : skin.influences) {  // not the padding between joints and weights
    facts.append(reinterpret_cast<const char*>(in.joints.data()), sizeof in.joints);
    facts.append(reinterpret_cast<const char*>(in.weights.data()), sizeof in.weights);
  }
  return checksum(facts);
}

/// Key, checksum of what follows; then joints, weights, and centres with their slopes where the method has
/// them.
std::string fileOf(const PreparedSkin& prepared, std::uint64_t key) {
  std::string body;
  for (const Influences& in : prepared.skin.influences) {
    body.append(reinterpret_cast<const char*>(in.joints.data()), sizeof in.joints);
    body.append(reinterpret_cast<const char*>(in.weights.data()), sizeof in.weights);
  }
  put(body, prepared.centres);
  put(body, prepared.centreSlopes);
  std::string file;
  put(file, key);
  put(file, checksum(body));
  return file + body;
}

std::optional<PreparedSkin> preparedOf(const std::string& file, const Skin& skin, const SkinMethod& method,
                                       TwistSpread spread, std::uint64_t key) {
  constexpr std::size_t head = 2 * sizeof(std::uint64_t),
                        row = sizeof(Influences::joints) + sizeof(Influences::weights);
  if (file.size() < head) return std::nullopt;
  std::string_view body = std::string_view(file).substr(head);
  std::string expected;
  put(expected, key);
  put(expected, checksum(body));
  const std::size_t count = skin.mesh.positions.size();
  if (file.compare(0, head, expected) != 0 || body.size() < row * count) return std::nullopt;
  Skin smooth = skin;
  for (Influences& in : smooth.influences) {
    std::memcpy(in.joints.data(), body.data(), sizeof in.joints);
    std::memcpy(in.weights.data(), body.data() + sizeof in.joints, sizeof in.weights);
    body.remove_prefix(row);
  }
  PreparedSkin prepared = prepareSkin(std::move(smooth), skinMethod(SkinMethodKind::Lbs), std::move(spread));
  prepared.method = &method;
  if (!body.empty() && (!take(body, prepared.centres, count) || !take(body, prepared.centreSlopes, count)))
    return std::nullopt;
  if (!body.empty() || (method.prepare && prepared.centres.empty())) return std::nullopt;
  return prepared;
}

std::string pathOf(const std::string& folder, const std::string& name, const SkinChoice& choice) {
  std::string file = name + "-" + toString(choice);
  for (char& c : file)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '-';
  return folder + "/" + file + ".prepared";
}

}  // namespace

void keepPreparedSkin(const std::string& folder, const std::string& name, const Skin& skin,
                      const SkinChoice& choice, const PreparedSkin& prepared) {
  std::filesystem::create_directories(folder);
  writeFile(pathOf(folder, name, choice), fileOf(prepared, keyOf(skin, choice)));
}

PreparedSkin cachedPreparedSkin(const std::string& folder, const std::string& name, const Skin& skin,
                                SkinChoice choice, const Skeleton& skeleton, const Frames& bound) {
  choice.layers = SkinLayers::None;
  const bool isQuick = choice.smoothing == 0.0 && !skinMethod(choice.method).prepare;
  if (folder.empty() || isQuick) return prepareSkin(skin, choice, skeleton, bound);
  const std::string path = pathOf(folder, name, choice);
  const std::uint64_t key = keyOf(skin, choice);
  try {
    if (std::filesystem::exists(path)) {
      const SkinChoice plain{.method = SkinMethodKind::Lbs, .twist = choice.twist};
      TwistSpread spread = choice.twist ? prepareSkin(Skin{}, plain, skeleton, bound).spread : TwistSpread{};
      if (auto kept = preparedOf(readFile(path), skin, skinMethod(choice.method), std::move(spread), key))
        return *std::move(kept);
    }
  } catch (const std::exception&) {  // made anew below
  }
  PreparedSkin prepared = prepareSkin(skin, choice, skeleton, bound);
  if (prepared.own) return prepared;  // moments are not kept
  try {
    keepPreparedSkin(folder, name, skin, choice, prepared);
  } catch (const std::exception&) {  // the skin is there; only the next start is slower
  }
  return prepared;
}

}  // namespace gelenk
