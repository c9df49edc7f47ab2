#include "skinning/io/urdf_body.h"

#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "kinematics/io/word_stream.h"
#include "skinning/bodies/robot_body.h"
#include "skinning/creases.h"
#include "skinning/io/collada.h"
#include "skinning/io/obj.h"
#include "skinning/io/picture.h"
#include "skinning/io/stl.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

bool isReadable(const std::string& path) {
  const std::string ending = lowerCase(fs::path(path).extension().string());
  return ending == ".stl" || ending == ".obj" || (ending == ".dae" && readsCollada());
}

std::optional<std::string> findFile(const std::string& urdfPath, const std::string& fileName) {
  constexpr std::string_view local = "file://";
  std::vector<std::string> tails;
  const std::size_t scheme = fileName.find("://");  // package://NAME/PATH, model://NAME/PATH
  if (scheme != std::string::npos && !fileName.starts_with(local)) {
    tails.push_back(fileName.substr(scheme + 3));
    const std::size_t slash = tails[0].find('/');
    if (slash != std::string::npos) tails.push_back(tails[0].substr(slash + 1));
    for (std::size_t at = tails.back().find('/'); at != std::string::npos; at = tails.back().find('/'))
      tails.push_back(tails.back().substr(at + 1));
  } else {
    tails.push_back(fileName.starts_with(local) ? fileName.substr(local.size()) : fileName);
  }
  std::error_code error;
  fs::path folder = fs::absolute(urdfPath, error).parent_path();
  for (; !folder.empty(); folder = folder.parent_path()) {
    for (const std::string& tail : tails)
      if (fs::is_regular_file(folder / tail, error)) return (folder / tail).string();
    if (folder == folder.parent_path()) break;  // the root
  }
  return std::nullopt;
}

/// The file itself if it can be read, else one beside it with another ending.
std::optional<std::string> findMesh(const std::string& urdfPath, const std::string& fileName) {
  const fs::path base = fs::path(fileName).parent_path() / fs::path(fileName).stem();
  std::vector<std::string> candidates;
  if (isReadable(fileName)) candidates.push_back(fileName);
  for (const char* ending : {".stl", ".STL", ".obj", ".dae"})
    if (isReadable("mesh" + std::string(ending))) candidates.push_back(base.string() + ending);
  for (const std::string& candidate : candidates)
    if (const auto path = findFile(urdfPath, candidate)) return path;
  return std::nullopt;
}

Mesh box(const Vector3d& size) {
  Mesh mesh;
  for (int v = 0; v < 8; ++v)
    mesh.positions.push_back(0.5 *
                             size.cwiseProduct(Vector3d(v & 1 ? 1 : -1, v & 2 ? 1 : -1, v & 4 ? 1 : -1)));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A surface of revolution about z through the profile's points (radius, z), closed at both ends.
Mesh revolved(const std::vector<std::pair<double, double>>& profile) {
  constexpr int sides = 24;
  Mesh mesh;
  const int rings = static_cast<int>(profile.size());
  for (const auto& [radius, z] : profile)
    for (int s = 0; s < sides; ++s)
      mesh.positions.emplace_back(radius * std::cos(2.0 * M_PI * s / sides),
                                  radius * std::sin(2.0 * M_PI * s / sides), z);
  for (int r = 0; r + 1 < rings; ++r)
    for (int s = 0; s < sides; ++s) {
      const int a = r * sides + s, b = r * sides + (s + 1) % sides;
      mesh.triangles.push_back({a, b, b + sides});
      mesh.triangles.push_back({a, b + sides, a + sides});
    }
  const int low = static_cast<int>(mesh.positions.size());
  mesh.positions.emplace_back(0.0, 0.0, profile.front().second);
  mesh.positions.emplace_back(0.0, 0.0, profile.back().second);
  for (int s = 0; s < sides; ++s) {
    mesh.triangles.push_back({low, (s + 1) % sides, s});
    mesh.triangles.push_back({low + 1, (rings - 1) * sides + s, (rings - 1) * sides + (s + 1) % sides});
  }
  return mesh;
}

Mesh sphere(double radius) {
  std::vector<std::pair<double, double>> profile;
  for (int k = 1; k < 16; ++k)
    profile.emplace_back(radius * std::sin(M_PI * k / 16), -radius * std::cos(M_PI * k / 16));
  Mesh mesh = revolved(profile);
  mesh.positions[mesh.positions.size() - 2].z() = -radius;
  mesh.positions.back().z() = radius;
  return mesh;
}

/// nullopt where the mesh is missing; empty where it cannot be read.
std::optional<Mesh> bodyOf(const UrdfVisual& visual, const std::string& urdfPath, MeshLook& look,
                           std::vector<Note>& notes) {
  switch (visual.shape) {
    case UrdfVisual::Shape::Box: return box(visual.size);
    case UrdfVisual::Shape::Cylinder:
      return revolved({{visual.size.x(), -0.5 * visual.size.z()}, {visual.size.x(), 0.5 * visual.size.z()}});
    case UrdfVisual::Shape::Sphere: return sphere(visual.size.x());
    case UrdfVisual::Shape::Mesh: break;
  }
  const auto path = findMesh(urdfPath, visual.fileName);
  if (!path) return std::nullopt;
  const std::string name = lowerCase(*path);
  Mesh mesh;
  try {
    mesh = name.ends_with(".stl")   ? readStl(*path)
           : name.ends_with(".dae") ? readCollada(*path, &look, &notes)
                                    : readObj(*path, &notes);
  } catch (const std::runtime_error& error) {
    tell(notes, "mesh-unreadable", "meshes that cannot be read are left out: " + std::string(error.what()));
    look = {};
    return mesh;
  }
  if (name.ends_with(".obj"))
    if (auto own = readObjLook(*path, mesh, &notes, !visual.texture.empty())) {
      cutSurface(*own, mesh.positions);
      mesh.triangles = own->triangles;
      mesh.normals = own->normals;
      look = std::move(own->look);
    }
  for (Vector3d& p : mesh.positions) p = p.cwiseProduct(visual.size);
  for (Vector3d& n : mesh.normals) n = n.cwiseQuotient(visual.size).stableNormalized();
  if (visual.size.prod() < 0.0)  // mirrored: keep the outside outside
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// The picture of the URDF's own material; null where there is none or it cannot be laid on the mesh.
std::shared_ptr<const Texture> textureOf(const UrdfVisual& visual, const MeshLook& mesh,
                                         const std::string& urdfPath, std::vector<Note>& notes) {
  if (visual.texture.empty()) return nullptr;
  const auto file = findFile(urdfPath, visual.texture);
  auto picture = file ? readPicture(*file) : nullptr;
  if (!picture)
    tell(notes, "texture-missing",
         "textures that could not be read, their surfaces have one colour: " + visual.texture + ", line " +
             std::to_string(visual.line));
  if (!picture || !mesh.coordinates.empty()) return picture;
  tell(notes, "texture-unmapped",
       "textures on shapes without texture coordinates are passed over: " + visual.texture + ", line " +
           std::to_string(visual.line));
  return nullptr;
}

}  // namespace

UrdfModel openUrdf(const std::string& path) {
  UrdfRobot robot = readUrdf(path);
  UrdfModel model{.skeleton = robot.skeleton,
                  .skin = {},
                  .name = robot.name,
                  .masses = robot.masses,
                  .notes = robot.notes};
  const Frames rest = restFrames(robot.skeleton);
  Mesh whole;
  std::vector<Influences> influences;
  MeshLook look;
  const auto paint = [&](const UrdfVisual& visual, MeshLook own, int first, int count) {
    const auto texture = textureOf(visual, own, path, model.notes);
    if (visual.colour || texture || own.materials.empty()) {
      own.materials = {visual.colour ? linkMaterial(*visual.colour) : linkMaterial()};
      own.textures.clear();
      own.parts = {{.triangleCount = count}};
      if (texture) {  // in place of the colour, as ROS' programs draw it
        own.materials[0].colour.setOnes();
        own.materials[0].texture = 0;
        own.materials[0].cutOff = blendCutOff;
        own.textures = {texture};
      }
    }
    const int materials = static_cast<int>(look.materials.size()),
              textures = static_cast<int>(look.textures.size());
    for (Material& material : own.materials)
      if (material.texture >= 0) material.texture += textures;
    look.textures.insert(look.textures.end(), own.textures.begin(), own.textures.end());
    look.coordinates.resize(whole.positions.size(), Eigen::Vector2f::Zero());
    look.coordinates.insert(look.coordinates.end(), own.coordinates.begin(), own.coordinates.end());
    look.materials.insert(look.materials.end(), own.materials.begin(), own.materials.end());
    for (MeshLook::Part part : own.parts) {
      part.name = robot.skeleton.joint(visual.joint).name;
      part.firstTriangle += first;
      part.material += materials;
      look.parts.push_back(std::move(part));
    }
  };
  const auto add = [&](const UrdfVisual& visual, Mesh body, MeshLook own) {
    if (body.normals.empty()) {
      std::vector<int> from;
      body = withCreases(body, 0.6, &from);
      if (!own.coordinates.empty()) {
        std::vector<Eigen::Vector2f> moved;
        for (const int v : from) moved.push_back(own.coordinates[v]);
        own.coordinates = std::move(moved);
      }
    }
    paint(visual, std::move(own), static_cast<int>(whole.triangles.size()),
          static_cast<int>(body.triangles.size()));
    const int base = static_cast<int>(whole.positions.size());
    const Eigen::Isometry3d worldFromVisual = rest[visual.joint] * visual.jointFromVisual;
    for (const Vector3d& p : body.positions) whole.positions.push_back(worldFromVisual * p);
    for (const Vector3d& n : body.normals) whole.normals.push_back(worldFromVisual.linear() * n);
    for (const auto& [a, b, c] : body.triangles) whole.triangles.push_back({base + a, base + b, base + c});
    influences.resize(whole.positions.size(), Influences{{visual.joint, 0, 0, 0}, {1.0, 0.0, 0.0, 0.0}});
  };
  std::vector<std::string> replaced, leftOut;
  for (int joint = 0; joint < robot.skeleton.jointCount(); ++joint) {
    std::vector<std::string> missing;
    bool drawn = false, substituted = false;
    for (const bool collision : {false, true}) {
      if (collision && (drawn || missing.empty()))
        break;  // only for links whose visual meshes are all missing
      for (const UrdfVisual& visual : robot.visuals) {
        if (visual.joint != joint || visual.collision != collision) continue;
        MeshLook own;
        if (const auto body = bodyOf(visual, path, own, model.notes)) {
          add(visual, *body, std::move(own));
          drawn = true;
          substituted = substituted || collision;
        } else if (!collision) {
          missing.push_back(visual.fileName);
        }
      }
    }
    auto& list = substituted ? replaced : leftOut;
    list.insert(list.end(), missing.begin(), missing.end());
  }
  // One line each, however many meshes a robot has.
  if (!replaced.empty())
    tell(model.notes, "mesh-replaced",
         "meshes that were not found as STL, OBJ or Collada, drawn with their collision geometry: " +
             listed(replaced),
         static_cast<int>(replaced.size()));
  if (!leftOut.empty())
    tell(model.notes, "mesh-missing",
         "meshes that were not found as STL, OBJ or Collada, left out: " + listed(leftOut),
         static_cast<int>(leftOut.size()));
  if (whole.triangles.empty()) return model;
  look.coordinates.resize(look.textures.empty() ? 0 : whole.positions.size(), Eigen::Vector2f::Zero());
  model.skin = bindSkin(std::move(whole), rest, std::move(influences));
  model.look = std::make_shared<const MeshLook>(std::move(look));
  return model;
}

}  // namespace gelenk
