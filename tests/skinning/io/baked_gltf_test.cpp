#include "skinning/io/baked_gltf.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "kinematics/io/text_file.h"
#include "tests/gpu/test_bodies.h"
#ifdef GELENK_ASSIMP
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif

namespace gelenk {
namespace {

struct Baked {
  Skin skin = testing::arm(2, 0.3, 0.05, 4, 6).skin;
  std::string path = ::testing::TempDir() + "baked.glb";
  SkinnedVertices at(int frame) const {
    SkinnedVertices out{.positions = skin.mesh.positions, .normals = skin.mesh.normals};
    for (auto& p : out.positions) p.y() += 0.1 * frame * p.x();
    return out;
  }
  ~Baked() { std::filesystem::remove(path); }
};

TEST(BakedGltf, TheFilesLengthsAreThoseItSays) {
  const Baked baked;
  writeBakedGltf(baked.path, baked.skin.mesh, 4, 30.0, [&](int f) { return baked.at(f); });
  const std::string file = readFile(baked.path);
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (int k = 3; k >= 0; --k) value = value << 8 | static_cast<unsigned char>(file[at + k]);
    return value;
  };
  EXPECT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(number(8), file.size());
  EXPECT_EQ(file.substr(16, 4), "JSON");
  EXPECT_EQ(number(12) % 4, 0u);
  EXPECT_EQ(number(20 + number(12)) + 28 + number(12), file.size());
}

#ifdef GELENK_ASSIMP
TEST(BakedGltf, AnotherLoaderFindsEveryFramesVertices) {
  const Baked baked;
  writeBakedGltf(baked.path, baked.skin.mesh, 3, 30.0, [&](int f) { return baked.at(f); });
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(baked.path, 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  ASSERT_EQ(scene->mNumMeshes, 1u);
  const aiMesh& mesh = *scene->mMeshes[0];
  ASSERT_EQ(mesh.mNumAnimMeshes, 2u);
  ASSERT_EQ(mesh.mNumVertices, baked.skin.mesh.positions.size());
  for (int frame = 1; frame < 3; ++frame) {
    const SkinnedVertices want = baked.at(frame);
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& p = mesh.mAnimMeshes[frame - 1]->mVertices[v];
      EXPECT_LE((Eigen::Vector3d(p.x, p.y, p.z) - want.positions[v]).norm(), 1e-6);
    }
  }
  ASSERT_EQ(scene->mNumAnimations, 1u);
}
#endif

TEST(BakedGltf, WhatCannotBeBakedIsRefused) {
  const Baked baked;
  const auto bake = [&](int frames, double rate, const std::function<SkinnedVertices(int)>& surface) {
    writeBakedGltf(baked.path, baked.skin.mesh, frames, rate, surface);
  };
  const auto at = [&](int f) { return baked.at(f); };
  EXPECT_THROW(bake(0, 30.0, at), std::invalid_argument);
  EXPECT_THROW(bake(2, 0.0, at), std::invalid_argument);
  EXPECT_THROW(bake(2, 1e-300, at), std::invalid_argument);  // infinite in single precision
  EXPECT_THROW(bake(2, 1e60, at), std::invalid_argument);    // both frames at 0
  EXPECT_THROW(bake(2, 30.0, [](int) { return SkinnedVertices{}; }), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
