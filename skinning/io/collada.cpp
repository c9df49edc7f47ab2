#include "skinning/io/collada.h"

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

#ifdef GELENK_ASSIMP
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif

namespace gelenk {

#ifdef GELENK_ASSIMP

namespace {

void addNode(const aiScene& scene, const aiNode& node, const aiMatrix4x4& worldFromParent,
             const std::string& path, Mesh& mesh) {
  const aiMatrix4x4 worldFromNode = worldFromParent * node.mTransformation;
  const bool mirrored = worldFromNode.Determinant() < 0.0f;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[m]];
    const int base = static_cast<int>(mesh.positions.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D p = worldFromNode * part.mVertices[v];
      mesh.positions.emplace_back(p.x, p.y, p.z);
      if (!mesh.positions.back().allFinite())
        throw ParseError(path, 0, "finite coordinates", "NaN or infinity");
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;  // lines and points
      std::array<int, 3> triangle;
      for (int k = 0; k < 3; ++k) triangle[k] = base + static_cast<int>(face.mIndices[k]);
      if (mirrored) std::swap(triangle[1], triangle[2]);
      mesh.triangles.push_back(triangle);
    }
  }
  for (unsigned k = 0; k < node.mNumChildren; ++k)
    addNode(scene, *node.mChildren[k], worldFromNode, path, mesh);
}

}  // namespace

bool readsCollada() { return true; }

Mesh readCollada(const std::string& path) {
  const std::string text = readFile(path);  // the system's reason where it cannot be opened
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFileFromMemory(
      text.data(), text.size(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices, "dae");
  if (!scene || !scene->mRootNode) throw ParseError(path, 0, "Collada", importer.GetErrorString());
  Mesh mesh;
  addNode(*scene, *scene->mRootNode, aiMatrix4x4(), path, mesh);
  if (mesh.triangles.empty()) throw ParseError(path, 0, "at least one triangle", "none");
  return mesh;
}

#else

bool readsCollada() { return false; }

Mesh readCollada(const std::string& path) {
  throw ParseError(path, 0, "STL or OBJ",
                   "Collada, which this build does not read (it was made without Assimp)");
}

#endif

}  // namespace gelenk
