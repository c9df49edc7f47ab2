#include "skinning/io/collada.h"

#include <algorithm>
#include <filesystem>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "skinning/io/picture.h"

#ifdef GELENK_ASSIMP
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif

namespace gelenk {

#ifdef GELENK_ASSIMP

namespace {

void addNode(const aiScene& scene, const aiNode& node, const aiMatrix4x4& worldFromParent,
             const std::string& path, Mesh& mesh, MeshLook* look, bool& mapped) {
  const aiMatrix4x4 worldFromNode = worldFromParent * node.mTransformation;
  const bool mirrored = worldFromNode.Determinant() < 0.0f;
  const aiMatrix3x3 normalFromNode = aiMatrix3x3(worldFromNode).Inverse().Transpose();
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[m]];
    const int base = static_cast<int>(mesh.positions.size()), first = static_cast<int>(mesh.triangles.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D p = worldFromNode * part.mVertices[v];
      mesh.positions.emplace_back(p.x, p.y, p.z);
      if (!mesh.positions.back().allFinite())
        throw ParseError(path, 0, "finite coordinates", "NaN or infinity");
      const aiVector3D n = part.HasNormals() ? normalFromNode * part.mNormals[v] : aiVector3D();
      mesh.normals.push_back(Eigen::Vector3d(n.x, n.y, n.z).stableNormalized());
      const aiVector3D at = part.HasTextureCoords(0) ? part.mTextureCoords[0][v] : aiVector3D(0, 1, 0);
      if (look) look->coordinates.emplace_back(at.x, 1.0f - at.y);
      mapped = mapped || part.HasTextureCoords(0);
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;  // lines and points
      std::array<int, 3> triangle;
      for (int k = 0; k < 3; ++k) triangle[k] = base + static_cast<int>(face.mIndices[k]);
      if (mirrored) std::swap(triangle[1], triangle[2]);
      mesh.triangles.push_back(triangle);
    }
    if (look)
      look->parts.push_back({.name = part.mName.C_Str(),
                             .firstTriangle = first,
                             .triangleCount = static_cast<int>(mesh.triangles.size()) - first,
                             .material = static_cast<int>(part.mMaterialIndex)});
  }
  for (unsigned k = 0; k < node.mNumChildren; ++k)
    addNode(scene, *node.mChildren[k], worldFromNode, path, mesh, look, mapped);
}

/// A picture within the file, or beside it; null where it cannot be read.
std::shared_ptr<const Texture> pictureOf(const aiScene& scene, const std::string& name,
                                         const std::string& path) {
  if (const aiTexture* inside = scene.GetEmbeddedTexture(name.c_str()))
    return inside->mHeight > 0
               ? nullptr  // of plain pixels, which Collada has not
               : decodePicture({reinterpret_cast<const char*>(inside->pcData), inside->mWidth});
  const std::filesystem::path file(name), folder = std::filesystem::path(path).parent_path();
  if (auto picture = readPicture((folder / file).string())) return picture;
  return readPicture((folder / file.filename()).string());
}

/// Diffuse colour and texture.
Material materialOf(const aiScene& scene, const aiMaterial& source, const std::string& path, MeshLook& look,
                    std::vector<Note>* notes) {
  Material material{.gloss = 0.2f};
  aiString name;
  if (source.Get(AI_MATKEY_NAME, name) == AI_SUCCESS) material.name = name.C_Str();
  aiColor3D diffuse(0.75f, 0.76f, 0.78f);
  source.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
  const auto within = [](float value) { return value > 0.0f ? std::min(value, 1.0f) : 0.0f; };
  material.colour.head<3>() =
      linearFromSrgb(Eigen::Vector3f(within(diffuse.r), within(diffuse.g), within(diffuse.b)));
  if (source.GetTexture(aiTextureType_DIFFUSE, 0, &name) != AI_SUCCESS) return material;
  if (const auto picture = pictureOf(scene, name.C_Str(), path)) {
    material.texture = static_cast<int>(look.textures.size());
    material.colour.setOnes();  // Collada has either a colour or a texture
    material.cutOff = blendCutOff;
    look.textures.push_back(picture);
  } else if (notes) {
    tell(*notes, "texture-missing", "textures that could not be read: their surfaces have one colour");
  }
  return material;
}

}  // namespace

bool readsCollada() { return true; }

Mesh readCollada(const std::string& path, MeshLook* look, std::vector<Note>* notes) {
  const std::string text = readFile(path);  // the system's reason where it cannot be opened
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFileFromMemory(
      text.data(), text.size(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices, "dae");
  if (!scene || !scene->mRootNode) throw ParseError(path, 0, "Collada", importer.GetErrorString());
  Mesh mesh;
  if (look)
    for (unsigned m = 0; m < scene->mNumMaterials; ++m)
      look->materials.push_back(materialOf(*scene, *scene->mMaterials[m], path, *look, notes));
  bool mapped = false;
  addNode(*scene, *scene->mRootNode, aiMatrix4x4(), path, mesh, look, mapped);
  if (mesh.triangles.empty()) throw ParseError(path, 0, "at least one triangle", "none");
  if (std::ranges::any_of(mesh.normals, [](const auto& n) { return !(n.norm() > 0.5); }))
    mesh.normals.clear();
  if (look && !mapped) look->coordinates.clear();
  return mesh;
}

#else

bool readsCollada() { return false; }

Mesh readCollada(const std::string& path, MeshLook*, std::vector<Note>*) {
  throw ParseError(path, 0, "STL or OBJ",
                   "Collada, which this build does not read (it was made without Assimp)");
}

#endif

}  // namespace gelenk
