#include "skinning/io/obj.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <span>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "skinning/io/picture.h"
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

struct Corner {
  int vertex, coordinate;  ///< from zero; coordinate: -1 for none
};

/// A corner "i", "i/t", "i//n", "i/t/n". Positive indices may point further down the file and are not checked
/// here.
Corner parseCorner(std::string_view word, int verticesSoFar, int coordinatesSoFar, const std::string& file,
                   int line) {
  const auto fail = [&](const std::string& expected) {
    throw ParseError(file, line, expected, "'" + std::string(word) + "'");
  };
  std::string_view rest = word;
  std::array<int, 3> index{};
  for (int part = 0; part < 3; ++part) {
    const std::size_t slash = rest.find('/');
    const std::string_view number = rest.substr(0, slash);
    const bool mayBeEmpty = part == 1 && slash != std::string_view::npos;
    if (!(number.empty() && mayBeEmpty)) {
      const auto value = parseInteger(number);
      if (!value || *value == 0) fail("a face corner i, i/t, i//n or i/t/n with indices from 1");
      index[part] = *value;
    }
    if (slash == std::string_view::npos) {
      const auto [vertex, coordinate, normal] = index;
      if (vertex < -verticesSoFar)
        fail("an index that counts back at most " + std::to_string(verticesSoFar) + " vertices");
      return {vertex > 0 ? vertex - 1 : verticesSoFar + vertex,
              coordinate >= 0 ? coordinate - 1 : std::max(-1, coordinatesSoFar + coordinate)};
    }
    rest.remove_prefix(slash + 1);
  }
  fail("at most three indices in a face corner");
  return {};
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
        corners.push_back(
            parseCorner(words[k], static_cast<int>(mesh.positions.size()), 0, file, lineNumber).vertex);
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

/// The file of `map_Kd [options] name with blanks.png`, beside the .mtl; empty: it is not there.
std::string pictureOf(std::string_view line, const std::filesystem::path& folder) {
  std::string name(line.substr(line.find("map_Kd") + 6));
  std::replace(name.begin(), name.end(), '\\', '/');  // written on Windows
  std::error_code error;
  // Options come first, and each has its own number of words: the longest rest that is a file's name is it.
  for (std::size_t at = name.find_first_not_of(" \t"); at != name.npos;
       at = name.find_first_not_of(" \t", name.find_first_of(" \t", at))) {
    const std::string rest = name.substr(at, name.find_last_not_of(" \t\r") + 1 - at);
    for (const auto& path : {folder / rest, folder / std::filesystem::path(rest).filename()})
      if (std::filesystem::is_regular_file(path, error)) return path.string();
  }
  return {};
}

/// newmtl, Kd and map_Kd of a file; others are passed over. false: it cannot be read.
bool readMaterials(const std::filesystem::path& path, MeshLook& look, std::vector<Note>* notes) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  const std::string text = readFile(path.string());
  for (std::string_view line : splitLines(plainText(text, path.string()))) {
    line = line.substr(0, line.find('#'));
    const Words words = splitWords(line);
    if (words.size() > 1 && words[0] == "newmtl") look.materials.push_back({.name = std::string(words[1])});
    Material& material = look.materials.back();
    if (words.size() == 4 && words[0] == "Kd") {
      Eigen::Vector3f rgb = Eigen::Vector3f::Ones();
      for (int k = 0; k < 3; ++k)
        rgb[k] = std::clamp(static_cast<float>(parseNumber(words[k + 1]).value_or(1.0)), 0.0f, 1.0f);
      material.colour.head<3>() = linearFromSrgb(rgb);
    }
    if (words.size() > 1 && words[0] == "map_Kd") {
      const auto picture = readPicture(pictureOf(line, path.parent_path()));
      if (!picture) {
        if (notes)
          tell(*notes, "texture-missing", "textures that could not be read: their surfaces have one colour");
        continue;
      }
      material.texture = static_cast<int>(look.textures.size());
      look.textures.push_back(picture);
    }
  }
  for (Material& material : look.materials) {
    if (material.texture < 0) continue;
    if (material.colour.head<3>().isZero()) material.colour.setOnes();
    material.cutOff = blendCutOff;
  }
  return true;
}

Eigen::Vector2f parseCoordinate(const Words& words) {
  const auto number = [&](std::size_t k) {
    return k < words.size() ? static_cast<float>(parseNumber(words[k]).value_or(0.0)) : 0.0f;
  };
  return {number(1), 1.0f - number(2)};
}

/// The coordinates a vertex, with a copy of it for each further pair that a corner asks for. corners: three a
/// triangle, by number into coordinates.
void layCoordinates(const std::vector<Eigen::Vector2f>& coordinates,
                    const std::vector<std::array<int, 3>>& corners, int vertices, ObjLook& out) {
  std::vector<int> first(vertices, -2);  // number of the coordinates of each vertex; -2: none yet
  std::map<std::pair<int, int>, int> further;
  out.look.coordinates.assign(vertices, Eigen::Vector2f::Zero());
  const auto at = [&](int number) {
    return number >= 0 && number < static_cast<int>(coordinates.size()) ? coordinates[number]
                                                                        : Eigen::Vector2f::Zero();
  };
  for (std::size_t t = 0; t < corners.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      int& vertex = out.triangles[t][k];
      const int number = corners[t][k];
      if (first[vertex] == -2) {
        first[vertex] = number;
        out.look.coordinates[vertex] = at(number);
      }
      if (first[vertex] == number) continue;
      const auto [known, isNew] =
          further.try_emplace({vertex, number}, vertices + static_cast<int>(out.copyOf.size()));
      if (isNew) {
        out.copyOf.push_back(vertex);
        out.look.coordinates.push_back(at(number));
      }
      vertex = known->second;
    }
}

}  // namespace

std::optional<ObjLook> readObjLook(const std::string& path, const Mesh& mesh, std::vector<Note>* notes) {
  const std::string whole = readFile(path);
  ObjLook out;
  MeshLook& look = out.look;
  look.materials.push_back({.name = "none"});
  bool found = false;
  int material = 0, first = 0, vertices = 0;
  std::vector<Eigen::Vector2f> coordinates;
  std::vector<std::array<int, 3>> corners;  // numbers of their coordinates
  std::vector<Corner> face;
  std::vector<Eigen::Vector3d> polygon;
  const auto endPart = [&] {
    const int next = static_cast<int>(out.triangles.size());
    if (next > first)
      look.parts.push_back({.name = look.materials[material].name,
                            .firstTriangle = first,
                            .triangleCount = next - first,
                            .material = material});
    first = next;
  };
  const auto addTriangle = [&](int a, int b, int c) {
    out.triangles.push_back({face[a].vertex, face[b].vertex, face[c].vertex});
    corners.push_back({face[a].coordinate, face[b].coordinate, face[c].coordinate});
  };
  const auto lines = splitLines(plainText(whole, path));
  std::string joined;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    std::string_view line = continuedLine(lines, n, joined);
    line = line.substr(0, line.find('#'));
    const Words words = splitWords(line);
    if (words.size() < 2) continue;
    if (words[0] == "mtllib") {
      for (std::size_t k = 1; k < words.size(); ++k)
        found |=
            readMaterials(std::filesystem::path(path).parent_path() / std::string(words[k]), look, notes);
    } else if (words[0] == "usemtl") {
      endPart();
      const auto named = std::ranges::find(look.materials, words[1], &Material::name);
      material = named == look.materials.end() ? 0 : static_cast<int>(named - look.materials.begin());
    } else if (words[0] == "v") {
      ++vertices;
    } else if (words[0] == "vt") {
      coordinates.push_back(parseCoordinate(words));
    } else if (words[0] == "f") {
      face.clear();
      for (std::size_t k = 1; k < words.size(); ++k)
        face.push_back(parseCorner(words[k], vertices, static_cast<int>(coordinates.size()), path,
                                   static_cast<int>(n) + 1));
      if (face.size() == 3) {
        addTriangle(0, 1, 2);
        continue;
      }
      polygon.clear();
      for (const Corner& corner : face) {
        if (corner.vertex >= static_cast<int>(mesh.positions.size())) return std::nullopt;
        polygon.push_back(mesh.positions[corner.vertex]);
      }
      for (const auto& [a, b, c] : triangulated(polygon).triangles) addTriangle(a, b, c);
    }
  }
  endPart();
  if (!found || out.triangles != mesh.triangles) return std::nullopt;
  if (!look.textures.empty())
    layCoordinates(coordinates, corners, static_cast<int>(mesh.positions.size()), out);
  return out;
}

void cutForTexture(const ObjLook& look, Mesh& mesh) {
  if (look.copyOf.empty()) return;
  if (mesh.normals.size() != mesh.positions.size()) computeNormals(mesh);
  cutForTexture(look, mesh.positions);
  cutForTexture(look, mesh.normals);
  mesh.triangles = look.triangles;
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
