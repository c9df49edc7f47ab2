#include "skinning/io/stl.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"

namespace gelenk {
namespace {

using Corner = std::array<double, 3>;

class Welder {
 public:
  void add(const std::array<Corner, 3>& corners) {
    std::array<int, 3> triangle;
    for (int k = 0; k < 3; ++k) {
      const auto [at, isNew] = vertexAt_.emplace(corners[k], static_cast<int>(mesh.positions.size()));
      if (isNew) mesh.positions.emplace_back(corners[k][0], corners[k][1], corners[k][2]);
      triangle[k] = at->second;
    }
    if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
      mesh.triangles.push_back(triangle);
  }
  Mesh mesh;

 private:
  std::map<Corner, int> vertexAt_;
};

constexpr std::size_t headSize = 84, triangleSize = 50;

Mesh parseBinary(std::string_view bytes, const std::string& file) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  if ((bytes.size() - headSize) / triangleSize < count)
    throw ParseError(file, 0, std::to_string(count) + " triangles of 50 bytes",
                     std::to_string(bytes.size() - headSize) + " bytes");
  Welder welder;
  for (std::size_t t = 0; t < count; ++t) {
    std::array<Corner, 3> corners;
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 3; ++c) {
        float value;
        std::memcpy(&value, bytes.data() + headSize + t * triangleSize + 12 + 12 * k + 4 * c, sizeof value);
        if (!std::isfinite(value))
          throw ParseError(file, 0, "finite coordinates", "NaN or infinity in triangle " + std::to_string(t));
        corners[k][c] = value == 0.0f ? 0.0 : value;  // one zero
      }
    welder.add(corners);
  }
  return std::move(welder.mesh);
}

Mesh parseText(std::string_view text, const std::string& file) {
  WordStream words(text, file);
  words.expect("solid");
  while (words.sameLine()) words.next("");
  Welder welder;
  while (!words.take("endsolid")) {
    words.expect("facet");
    words.expect("normal");
    for (int k = 0; k < 3; ++k) words.next("three numbers of the normal");
    words.expect("outer");
    words.expect("loop");
    std::array<Corner, 3> corners;
    for (Corner& corner : corners) {
      words.expect("vertex");
      for (double& value : corner) value = words.number() + 0.0;
    }
    words.expect("endloop");
    words.expect("endfacet");
    welder.add(corners);
  }
  return std::move(welder.mesh);
}

}  // namespace

Mesh parseStl(std::string_view bytes, const std::string& file) {
  // A binary file may begin with "solid" too; its length tells.
  std::uint32_t count = 0;
  if (bytes.size() >= headSize) std::memcpy(&count, bytes.data() + 80, sizeof count);
  const bool fitsBinary =
      bytes.size() >= headSize && bytes.size() == headSize + triangleSize * std::size_t{count};
  if (!fitsBinary) bytes = plainText(bytes, file);
  const bool isText = sameWord(bytes.substr(0, 5), "solid") && !fitsBinary;
  if (!isText && bytes.size() < headSize)
    throw ParseError(file, 0, "an STL: 'solid' or a head of 84 bytes",
                     std::to_string(bytes.size()) + " bytes");
  Mesh mesh = isText ? parseText(bytes, file) : parseBinary(bytes, file);
  if (mesh.triangles.empty()) throw ParseError(file, 0, "at least one triangle", "none");
  return mesh;
}

Mesh readStl(const std::string& path) { return parseStl(readFile(path), path); }

}  // namespace gelenk
