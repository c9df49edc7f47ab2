#include "skinning/io/obj.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
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
  int vertex, coordinate, normal;  ///< from zero; the last two: -1 for none
};

/// A corner "i", "i/t", "i//n", "i/t/n". soFar: how many of each stand above the line. Positive indices may
/// point further down the file and are not checked here.
Corner parseCorner(std::string_view word, const Corner& soFar, const std::string& file, int line) {
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
      if (index[0] < -soFar.vertex)
        fail("an index that counts back at most " + std::to_string(soFar.vertex) + " vertices");
      const auto fromZero = [](int value, int count) {
        return value >= 0 ? value - 1 : std::max(-1, count + value);
      };
      return {fromZero(index[0], soFar.vertex), fromZero(index[1], soFar.coordinate),
              fromZero(index[2], soFar.normal)};
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
            parseCorner(words[k], {static_cast<int>(mesh.positions.size()), 0, 0}, file, lineNumber).vertex);
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

/// Unit; zero where the line says none.
Eigen::Vector3d parseNormal(const Words& words) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  if (words.size() == 4)
    for (int k = 0; k < 3; ++k) normal[k] = parseNumber(words[k + 1]).value_or(0.0);
  return normal.stableNormalized();
}

/// What a corner carries beyond its vertex: numbers of texture coordinates and of a normal, -1 for none.
using Extra = std::array<int, 2>;

/// One of them a vertex, with a copy of it for each further one that a corner asks for. corners: three a
/// triangle. Returns those of all vertices, the added ones behind.
std::vector<Extra> layCorners(const std::vector<std::array<Extra, 3>>& corners, int vertices, ObjLook& out) {
  std::vector<Extra> ofVertex(vertices, Extra{-1, -1});
  std::vector<char> known(vertices, false);
  std::map<std::pair<int, Extra>, int> further;
  for (std::size_t t = 0; t < corners.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      int& vertex = out.triangles[t][k];
      const Extra& extra = corners[t][k];
      if (!known[vertex]) ofVertex[vertex] = extra;
      known[vertex] = true;
      if (ofVertex[vertex] == extra) continue;
      const auto [at, isNew] = further.try_emplace({vertex, extra}, static_cast<int>(ofVertex.size()));
      if (isNew) {
        out.copyOf.push_back(vertex);
        ofVertex.push_back(extra);
      }
      vertex = at->second;
    }
  return ofVertex;
}

/// For each normal the first that is equal, for none that is zero.
std::vector<int> firstEqual(const std::vector<Eigen::Vector3d>& normals) {
  std::map<std::array<double, 3>, int> known;
  std::vector<int> first;
  for (const Eigen::Vector3d& n : normals)
    first.push_back(
        n.isZero() ? -1
                   : known.try_emplace({n.x(), n.y(), n.z()}, static_cast<int>(first.size())).first->second);
  return first;
}

}  // namespace

std::optional<ObjLook> readObjLook(const std::string& path, const Mesh& mesh, std::vector<Note>* notes,
                                   bool wantsCoordinates) {
  const std::string whole = readFile(path);
  ObjLook out;
  MeshLook& look = out.look;
  look.materials.push_back({.name = "none"});
  bool found = false;
  int material = 0, first = 0;
  Corner soFar{0, 0, 0};
  std::vector<Eigen::Vector2f> coordinates;
  std::vector<Eigen::Vector3d> normals;
  std::vector<std::array<Extra, 3>> corners;
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
    const auto extra = [&](int k) { return Extra{face[k].coordinate, face[k].normal}; };
    corners.push_back({extra(a), extra(b), extra(c)});
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
      ++soFar.vertex;
    } else if (words[0] == "vt") {
      ++soFar.coordinate;
      coordinates.push_back(parseCoordinate(words));
    } else if (words[0] == "vn") {
      ++soFar.normal;
      normals.push_back(parseNormal(words));
    } else if (words[0] == "f") {
      face.clear();
      for (std::size_t k = 1; k < words.size(); ++k)
        face.push_back(parseCorner(words[k], soFar, path, static_cast<int>(n) + 1));
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
  if (out.triangles != mesh.triangles) return std::nullopt;
  if (!found) look = {};
  // What the picture does not need cuts nothing: coordinates without a texture, normals told twice.
  const bool textured = !coordinates.empty() && (wantsCoordinates || !look.textures.empty());
  const std::vector<int> equal = firstEqual(normals);
  bool anyNormal = false;
  int unreadable = 0;
  for (auto& triangle : corners)
    for (auto& [coordinate, normal] : triangle) {
      if (!textured || coordinate >= static_cast<int>(coordinates.size())) coordinate = -1;
      const bool asked = normal >= 0;
      normal = asked && normal < static_cast<int>(equal.size()) ? equal[normal] : -1;
      anyNormal = anyNormal || normal >= 0;
      unreadable += asked && normal < 0;
    }
  if (unreadable > 0 && notes)
    tell(*notes, "normals-missing",
         "normals that a face asks for and that are none or not there: the mean of the vertex's faces is "
         "taken",
         unreadable);
  if (!found && !textured && !anyNormal) return std::nullopt;
  const std::vector<Extra> ofVertex = layCorners(corners, static_cast<int>(mesh.positions.size()), out);
  if (textured || !look.textures.empty())
    for (const auto& [coordinate, normal] : ofVertex)
      look.coordinates.push_back(coordinate >= 0 ? coordinates[coordinate] : Eigen::Vector2f::Zero());
  if (!anyNormal) return out;
  Mesh byFaces{.positions = mesh.positions, .triangles = mesh.triangles, .normals = {}};
  computeNormals(byFaces);
  for (std::size_t v = 0; v < ofVertex.size(); ++v) {
    const std::size_t vertex =
        v < mesh.positions.size() ? v : static_cast<std::size_t>(out.copyOf[v - mesh.positions.size()]);
    const int normal = ofVertex[v][1];
    out.normals.push_back(normal >= 0 ? normals[normal] : byFaces.normals[vertex]);
  }
  return out;
}

void cutSurface(const ObjLook& look, Mesh& mesh) {
  if (mesh.normals.size() != mesh.positions.size()) computeNormals(mesh);
  cutSurface(look, mesh.positions);
  cutSurface(look, mesh.normals);
  if (!look.normals.empty()) mesh.normals = look.normals;
  mesh.triangles = look.triangles;
}

namespace {

std::string vertexLines(const Mesh& mesh) {
  std::string text;
  text.reserve(64 * mesh.positions.size() + 24 * mesh.triangles.size());
  for (const Eigen::Vector3d& p : mesh.positions)
    text += "v " + exactNumber(p.x()) + ' ' + exactNumber(p.y()) + ' ' + exactNumber(p.z()) + '\n';
  if (mesh.normals.size() == mesh.positions.size())
    for (const Eigen::Vector3d& n : mesh.normals)
      text += "vn " + exactNumber(n.x()) + ' ' + exactNumber(n.y()) + ' ' + exactNumber(n.z()) + '\n';
  return text;
}

/// The shortest notation that reads back as the same bits.
std::string exactFloat(float value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

void addFace(const Mesh& mesh, const std::array<int, 3>& triangle, bool textured, std::string& text) {
  const bool withNormal = mesh.normals.size() == mesh.positions.size();
  text += 'f';
  for (const int vertex : triangle) {
    const std::string number = std::to_string(vertex + 1);
    text += ' ' + number;
    if (textured || withNormal) text += '/' + (textured ? number : std::string());
    if (withNormal) text += '/' + number;
  }
  text += '\n';
}

/// Names of one word each, all different.
std::vector<std::string> materialNames(const MeshLook& look) {
  std::vector<std::string> names;
  for (const Material& material : look.materials) {
    std::string name = material.name.empty() ? "material" : material.name;
    for (char& c : name)
      if (std::isspace(static_cast<unsigned char>(c)) || c == '#') c = '_';
    const std::string plain = name;
    for (int k = 2; std::ranges::count(names, name) > 0; ++k) name = plain + '_' + std::to_string(k);
    names.push_back(name);
  }
  return names;
}

}  // namespace

std::string formatObj(const Mesh& mesh) {
  std::string text = vertexLines(mesh);
  for (const auto& triangle : mesh.triangles) addFace(mesh, triangle, false, text);
  return text;
}

void writeObj(const std::string& path, const Mesh& mesh) { writeFile(path, formatObj(mesh)); }

ObjText formatObj(const Mesh& mesh, const MeshLook& look, const std::string& mtlName,
                  const std::vector<std::string>& pictures) {
  ObjText text{.obj = "mtllib " + mtlName + '\n' + vertexLines(mesh), .mtl = {}};
  const bool textured = look.coordinates.size() == mesh.positions.size();
  for (std::size_t v = 0; textured && v < look.coordinates.size(); ++v) {
    const Eigen::Vector2f& at = look.coordinates[v];
    text.obj += "vt " + exactFloat(at.x()) + ' ' + exactFloat(1.0f - at.y()) + '\n';
  }
  const std::vector<std::string> names = materialNames(look);
  for (const MeshLook::Part& part : look.parts) {
    if (!part.name.empty()) text.obj += "g " + part.name + '\n';
    text.obj += "usemtl " + names[part.material] + '\n';
    for (int t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t)
      addFace(mesh, mesh.triangles[t], textured, text.obj);
  }
  for (std::size_t m = 0; m < look.materials.size(); ++m) {
    const Material& material = look.materials[m];
    text.mtl += "newmtl " + names[m] + "\nKd";
    for (int k = 0; k < 3; ++k) text.mtl += ' ' + exactFloat(srgbFromLinear(material.colour[k]));
    text.mtl += '\n';
    if (material.colour.w() < 1.0f) text.mtl += "d " + exactFloat(material.colour.w()) + '\n';
    if (material.texture >= 0) text.mtl += "map_Kd " + pictures[material.texture] + '\n';
  }
  return text;
}

}  // namespace gelenk
