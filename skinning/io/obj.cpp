#include "skinning/io/obj.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <span>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "skinning/polygon.h"

namespace gelenk {
namespace {

using Words = std::vector<std::string_view>;

/// The keywords of the format that say nothing about vertices and faces.
constexpr std::array<std::string_view, 27> passedOver = {
    "vt",        "vn",     "vp",  "o",    "g",     "s",        "mg",       "usemtl", "mtllib",
    "usemap",    "maplib", "l",   "p",    "bevel", "c_interp", "d_interp", "lod",    "shadow_obj",
    "trace_obj", "cstype", "deg", "curv", "curv2", "surf",     "parm",     "trim",   "end"};

Eigen::Vector3d parseVertex(const Words& words, const std::string& file, int line) {
  if (words.size() < 4)
    throw ParseError(file, line, "three coordinates after 'v'", std::to_string(words.size() - 1));
  if (words.size() > 8)
    throw ParseError(file, line, "at most seven numbers after 'v'", std::to_string(words.size() - 1));
  std::array<double, 7> values{};
  for (std::size_t k = 1; k < words.size(); ++k) {
    const auto value = parseNumber(words[k]);
    if (!value) throw ParseError(file, line, "a finite number", badNumber(words[k]));
    values[k - 1] = *value;
  }
  if (words.size() == 5 && values[3] != 1.0)
    throw ParseError(file, line, "1 as a vertex's fourth value (rational curves are not read)",
                     "'" + std::string(words[4]) + "'");
  return {values[0], values[1], values[2]};
}

/// Index, from zero, of the vertex in a corner "i", "i/t", "i//n", "i/t/n". A positive index may point
/// further down the file and is not checked here.
int parseCorner(std::string_view word, int verticesSoFar, const std::string& file, int line) {
  const auto fail = [&](const std::string& expected) {
    throw ParseError(file, line, expected, "'" + std::string(word) + "'");
  };
  std::string_view rest = word;
  int index = 0;
  for (int part = 0; part < 3; ++part) {
    const std::size_t slash = rest.find('/');
    const std::string_view number = rest.substr(0, slash);
    const bool mayBeEmpty = part == 1 && slash != std::string_view::npos;
    if (!(number.empty() && mayBeEmpty)) {
      const auto value = parseInteger(number);
      if (!value || *value == 0) fail("a face corner i, i/t, i//n or i/t/n with indices from 1");
      if (part == 0) index = *value;
    }
    if (slash == std::string_view::npos) {
      if (index < 0 && index < -verticesSoFar)
        fail("an index that counts back at most " + std::to_string(verticesSoFar) + " vertices");
      return index > 0 ? index - 1 : verticesSoFar + index;
    }
    rest.remove_prefix(slash + 1);
  }
  fail("at most three indices in a face corner");
  return 0;
}

/// Line n (from zero) and the lines that continue it after a '\\' at the end; n moves to the last of them.
std::string_view continuedLine(const std::vector<std::string_view>& lines, std::size_t& n,
                               std::string& joined) {
  std::string_view line = lines[n];
  if (line.empty() || line.back() != '\\') return line;
  joined.clear();
  while (!line.empty() && line.back() == '\\') {
    joined.append(line.substr(0, line.size() - 1)).push_back(' ');
    line = n + 1 < lines.size() ? lines[++n] : std::string_view();
  }
  joined.append(line);
  return joined;
}

}  // namespace

Mesh parseObj(std::string_view text, const std::string& file, std::vector<Note>* notes) {
  struct Face {
    int line;
    std::size_t first, count;  // in corners
  };
  Mesh mesh;
  std::vector<Face> faces;
  std::vector<int> corners;
  const auto lines = splitLines(plainText(text, file));
  std::string joined;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    const int lineNumber = static_cast<int>(n) + 1;
    std::string_view line = continuedLine(lines, n, joined);
    line = line.substr(0, line.find('#'));
    const Words words = splitWords(line);
    if (words.empty()) continue;
    if (words[0] == "v") {
      mesh.positions.push_back(parseVertex(words, file, lineNumber));
    } else if (words[0] == "f") {
      if (words.size() < 4)
        throw ParseError(file, lineNumber, "a face of at least three corners",
                         std::to_string(words.size() - 1));
      faces.push_back({lineNumber, corners.size(), words.size() - 1});
      for (std::size_t k = 1; k < words.size(); ++k)
        corners.push_back(parseCorner(words[k], static_cast<int>(mesh.positions.size()), file, lineNumber));
    } else if (std::find(passedOver.begin(), passedOver.end(), words[0]) == passedOver.end()) {
      throw ParseError(file, lineNumber, "an OBJ keyword such as v or f", "'" + std::string(words[0]) + "'");
    }
  }
  if (mesh.positions.empty()) throw ParseError(file, 0, "at least one vertex (a line 'v x y z')", "none");
  if (faces.empty()) throw ParseError(file, 0, "at least one face (a line 'f i j k')", "none");
  const int count = static_cast<int>(mesh.positions.size());
  std::vector<Eigen::Vector3d> polygon;
  for (const Face& face : faces) {  // vertices may stand below the faces that use them
    const std::span<const int> of(corners.data() + face.first, face.count);
    for (const int corner : of)
      if (corner >= count)
        throw ParseError(file, face.line, "a vertex index of at most " + std::to_string(count),
                         std::to_string(corner + 1));
    if (of.size() == 3) {
      mesh.triangles.push_back({of[0], of[1], of[2]});
      continue;
    }
    polygon.clear();
    for (const int corner : of) polygon.push_back(mesh.positions[corner]);
    const PolygonTriangles result = triangulated(polygon);
    for (const auto& [a, b, c] : result.triangles) mesh.triangles.push_back({of[a], of[b], of[c]});
    if (result.crossing && notes)
      tell(*notes, "polygon-crossing",
           "polygons cross themselves or have no area: their triangles may fold, line " +
               std::to_string(face.line));
  }
  return mesh;
}

Mesh readObj(const std::string& path, std::vector<Note>* notes) {
  return parseObj(readFile(path), path, notes);
}

namespace {

/// newmtl, Kd and d of a file; others are passed over. false: it cannot be read.
bool readMaterials(const std::string& path, MeshLook& look) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  const std::string text = readFile(path);
  for (const std::string_view line : splitLines(plainText(text, path))) {
    const Words words = splitWords(line.substr(0, line.find('#')));
    if (words.size() > 1 && words[0] == "newmtl") look.materials.push_back({.name = std::string(words[1])});
    if (words.size() == 4 && words[0] == "Kd" && !look.materials.empty()) {
      Eigen::Vector3f rgb = Eigen::Vector3f::Ones();
      for (int k = 0; k < 3; ++k)
        rgb[k] = std::clamp(static_cast<float>(parseNumber(words[k + 1]).value_or(1.0)), 0.0f, 1.0f);
      look.materials.back().colour.head<3>() = linearFromSrgb(rgb);
    }
  }
  return true;
}

}  // namespace

std::optional<MeshLook> readObjLook(const std::string& path, const Mesh& mesh) {
  const std::string whole = readFile(path);
  MeshLook look;
  look.materials.push_back({.name = "none"});
  bool found = false;
  int material = 0, first = 0, next = 0;
  const auto endPart = [&] {
    if (next > first)
      look.parts.push_back({.name = look.materials[material].name,
                            .firstTriangle = first,
                            .triangleCount = next - first,
                            .material = material});
    first = next;
  };
  const auto lines = splitLines(plainText(whole, path));
  std::string joined;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    const std::string_view line = continuedLine(lines, n, joined);
    const Words words = splitWords(line.substr(0, line.find('#')));
    if (words.size() < 2) continue;
    if (words[0] == "mtllib") {
      for (std::size_t k = 1; k < words.size(); ++k)
        found |=
            readMaterials((std::filesystem::path(path).parent_path() / std::string(words[k])).string(), look);
    } else if (words[0] == "usemtl") {
      endPart();
      const auto named = std::ranges::find(look.materials, words[1], &Material::name);
      material = named == look.materials.end() ? 0 : static_cast<int>(named - look.materials.begin());
    } else if (words[0] == "f") {
      next += static_cast<int>(words.size()) - 3;  // a polygon of n corners gives n - 2 triangles
    }
  }
  endPart();
  if (!found || next != static_cast<int>(mesh.triangles.size())) return std::nullopt;
  return look;
}

std::string formatObj(const Mesh& mesh) {
  std::string text;
  text.reserve(64 * mesh.positions.size() + 24 * mesh.triangles.size());
  for (const Eigen::Vector3d& p : mesh.positions)
    text += "v " + exactNumber(p.x()) + ' ' + exactNumber(p.y()) + ' ' + exactNumber(p.z()) + '\n';
  for (const auto& [a, b, c] : mesh.triangles)
    text += "f " + std::to_string(a + 1) + ' ' + std::to_string(b + 1) + ' ' + std::to_string(c + 1) + '\n';
  return text;
}

void writeObj(const std::string& path, const Mesh& mesh) { writeFile(path, formatObj(mesh)); }

}  // namespace gelenk
