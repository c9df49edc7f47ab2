#include "skinning/io/urdf_body.h"

#include <cmath>
#include <filesystem>

#include "kinematics/io/word_stream.h"
#include "skinning/io/collada.h"
#include "skinning/io/obj.h"
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
  constexpr std::string_view package = "package://", local = "file://";
  std::vector<std::string> tails;
  if (fileName.starts_with(package)) {
    tails.push_back(fileName.substr(package.size()));
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

/// nullopt where the mesh is missing.
std::optional<Mesh> bodyOf(const UrdfVisual& visual, const std::string& urdfPath) {
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
  Mesh mesh = name.ends_with(".stl")   ? readStl(*path)
              : name.ends_with(".dae") ? readCollada(*path)
                                       : readObj(*path);
  for (Vector3d& p : mesh.positions) p = p.cwiseProduct(visual.size);
  if (visual.size.prod() < 0.0)  // mirrored: keep the outside outside
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  mesh.normals.clear();
  return mesh;
}

}  // namespace

UrdfModel openUrdf(const std::string& path) {
  UrdfRobot robot = readUrdf(path);
  UrdfModel model{.skeleton = robot.skeleton, .skin = {}, .masses = robot.masses, .notes = robot.notes};
  const Frames rest = restFrames(robot.skeleton);
  Mesh whole;
  std::vector<Influences> influences;
  const auto add = [&](const UrdfVisual& visual, const Mesh& body) {
    const int base = static_cast<int>(whole.positions.size());
    const Eigen::Isometry3d worldFromVisual = rest[visual.joint] * visual.jointFromVisual;
    for (const Vector3d& p : body.positions) whole.positions.push_back(worldFromVisual * p);
    for (const auto& [a, b, c] : body.triangles) whole.triangles.push_back({base + a, base + b, base + c});
    influences.resize(whole.positions.size(), Influences{{visual.joint, 0, 0, 0}, {1.0, 0.0, 0.0, 0.0}});
  };
  for (int joint = 0; joint < robot.skeleton.jointCount(); ++joint) {
    std::vector<std::string> missing;
    bool drawn = false, substituted = false;
    for (const bool collision : {false, true}) {
      if (collision && (drawn || missing.empty()))
        break;  // only for links whose visual meshes are all missing
      for (const UrdfVisual& visual : robot.visuals) {
        if (visual.joint != joint || visual.collision != collision) continue;
        if (const auto body = bodyOf(visual, path)) {
          add(visual, *body);
          drawn = true;
          substituted = substituted || collision;
        } else if (!collision) {
          missing.push_back(visual.fileName);
        }
      }
    }
    for (const std::string& file : missing)
      tell(model.notes, substituted ? "mesh-replaced" : "mesh-missing",
           "mesh '" + file + "' was not found as STL, OBJ or Collada" +
               (substituted ? ": drawn with its collision geometry" : " and is left out"));
  }
  if (!whole.triangles.empty()) model.skin = bindSkin(std::move(whole), rest, std::move(influences));
  return model;
}

}  // namespace gelenk
