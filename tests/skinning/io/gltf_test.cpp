#include "skinning/io/gltf.h"

#ifdef GELENK_ASSIMP
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif
#include <filesystem>

#include "kinematics/configuration.h"
#include "kinematics/io/asf_amc.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/mannequin.h"
#include "skinning/blend/linear_blend.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

struct Body {
  Skeleton skeleton;
  Skin skin;
  MotionClip clip;
};

Body randomBody(unsigned seed) {
  std::mt19937_64 random(seed);
  Body body;
  body.skeleton = testing::randomSkeleton(random, 8);
  Mesh mesh;
  SparseWeights weights;
  for (int v = 0; v < 60; ++v) {
    mesh.positions.push_back(2.0 * testing::randomUnit(random));
    weights.push_back({{static_cast<int>(random() % 8), 0.1 + uniform01(random)},
                       {static_cast<int>(random() % 8), uniform01(random)}});
  }
  for (int t = 0; t + 2 < 60; ++t) mesh.triangles.push_back({t, t + 1, t + 2});
  body.skin = bindSkin(mesh, restFrames(body.skeleton), fourLargest(weights, 8));
  body.clip = {.framesPerSecond = 24.0, .q = Eigen::MatrixXd(body.skeleton.nq(), 7)};
  for (int f = 0; f < 7; ++f) body.clip.q.col(f) = randomWithinLimits(body.skeleton, random);
  return body;
}

TEST(Gltf, OutAndInKeepsJointsAndSkinInEveryFrame) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Body body = randomBody(seed);
    const GltfModel again =
        parseGltf(formatGlb(body.skeleton, &body.skin, {{"move", body.clip}}), "again.glb");
    ASSERT_EQ(again.clips.size(), 1u);
    ASSERT_TRUE(again.skin);
    EXPECT_EQ(again.clips[0].name, "move");
    EXPECT_NEAR(again.clips[0].clip.framesPerSecond, 24.0, 1e-4);
    ASSERT_EQ(again.clips[0].clip.frameCount(), 7);
    for (int f = 0; f < 7; ++f) {
      const Frames before = forwardKinematics(body.skeleton, body.clip.q.col(f)),
                   after = forwardKinematics(again.skeleton, again.clips[0].clip.q.col(f));
      for (int i = 0; i < 8; ++i)
        EXPECT_LE((before[i].translation() -
                   after[again.skeleton.jointIndex(body.skeleton.joint(i).name)].translation())
                      .norm(),
                  1e-5)
            << "seed " << seed;
      const SkinnedVertices a = linearBlendSkin(body.skin, before), b = linearBlendSkin(*again.skin, after);
      for (std::size_t v = 0; v < a.positions.size(); ++v)
        EXPECT_LE((a.positions[v] - b.positions[v]).norm(), 1e-5) << "seed " << seed;
    }
  }
}

#ifdef GELENK_ASSIMP
Vector3d translation(const aiMatrix4x4& m) { return {m.a4, m.b4, m.c4}; }

TEST(Gltf, AnIndependentLoaderSeesTheSameJointsMeshAndKeys) {
  const Body body = randomBody(7);
  const std::string bytes = formatGlb(body.skeleton, &body.skin, {{"move", body.clip}});
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_ValidateDataStructure, "glb");
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  ASSERT_EQ(scene->mNumMeshes, 1u);
  EXPECT_EQ(scene->mMeshes[0]->mNumVertices, 60u);
  EXPECT_EQ(scene->mMeshes[0]->mNumFaces, 58u);
  ASSERT_EQ(scene->mNumAnimations, 1u);
  const Frames rest = restFrames(body.skeleton);
  for (int i = 0; i < 8; ++i) {
    const aiNode* node = scene->mRootNode->FindNode(body.skeleton.joint(i).name.c_str());
    ASSERT_NE(node, nullptr);
    aiMatrix4x4 world;
    for (; node; node = node->mParent) world = node->mTransformation * world;
    EXPECT_LE((translation(world) - rest[i].translation()).norm(), 1e-5) << body.skeleton.joint(i).name;
  }
  // A frame of the animation, put together from the keys that assimp read.
  const int frame = 3;
  const Frames posed = forwardKinematics(body.skeleton, body.clip.q.col(frame));
  for (int i = 0; i < 8; ++i) {
    aiMatrix4x4 world;
    for (const aiNode* node = scene->mRootNode->FindNode(body.skeleton.joint(i).name.c_str()); node;
         node = node->mParent) {
      aiMatrix4x4 local = node->mTransformation;
      for (unsigned c = 0; c < scene->mAnimations[0]->mNumChannels; ++c) {
        const aiNodeAnim* channel = scene->mAnimations[0]->mChannels[c];
        if (channel->mNodeName != node->mName) continue;
        const aiQuaternion r = channel->mRotationKeys[channel->mNumRotationKeys > 1 ? frame : 0].mValue;
        const aiVector3D t = channel->mPositionKeys[channel->mNumPositionKeys > 1 ? frame : 0].mValue;
        local = aiMatrix4x4(aiVector3D(1, 1, 1), r, t);
      }
      world = local * world;
    }
    EXPECT_LE((translation(world) - posed[i].translation()).norm(), 1e-5) << body.skeleton.joint(i).name;
  }
}

#endif

TEST(Gltf, CmuWalkOutAndInKeepsEveryJoint) {
  const std::string data = testing::dataFolder() + "/mocap/asf/";
  if (!std::filesystem::exists(data + "02_01.amc")) GTEST_SKIP() << "no trial data at " << data;
  const AsfSkeleton asf = readAsf(data + "02.asf");
  const MotionClip clip = readAmc(data + "02_01.amc", asf);
  const GltfModel again = parseGltf(formatGlb(asf.skeleton, nullptr, {{"walk", clip}}), "walk.glb");
  ASSERT_EQ(again.clips.size(), 1u);
  ASSERT_EQ(again.clips[0].clip.frameCount(), clip.frameCount());
  double worst = 0.0;
  for (int f = 0; f < clip.frameCount(); ++f) {
    const Frames a = forwardKinematics(asf.skeleton, clip.q.col(f)),
                 b = forwardKinematics(again.skeleton, again.clips[0].clip.q.col(f));
    for (int i = 0; i < asf.skeleton.jointCount(); ++i)
      worst = std::max(
          worst, (a[i].translation() - b[again.skeleton.jointIndex(asf.skeleton.joint(i).name)].translation())
                     .norm());
  }
  EXPECT_LE(worst, 1e-5);
  RecordProperty("worst_micrometres", std::to_string(1e6 * worst));
}

TEST(Gltf, TrialCharactersAreReadWithSkinAndAnimation) {
  const std::string data = testing::dataFolder() + "/characters/";
  if (!std::filesystem::exists(data + "gltf/Fox.glb")) GTEST_SKIP() << "no trial data at " << data;
  for (const char* name : {"gltf/RiggedFigure.glb", "gltf/Fox.glb", "kaykit/Knight.glb"}) {
    const GltfModel model = readGltf(data + name);
    ASSERT_TRUE(model.skin) << name;
    EXPECT_GE(model.clips.size(), 1u) << name;
    for (const GltfClip& clip : model.clips) validate(model.skeleton, clip.clip);
    const SkinnedVertices rest = linearBlendSkin(*model.skin, restFrames(model.skeleton));
    EXPECT_GT(rest.positions.size(), 100u);
  }
}

TEST(Gltf, BadInputIsRefused) {
  const std::string head = "{\"asset\":{\"version\":\"2.0\"}";
  const auto buffer = [&](const std::string& rest) {  // 12 zero bytes
    return head +
           ",\"buffers\":[{\"byteLength\":12,\"uri\":\"data:application/"
           "octet-stream;base64,AAAAAAAAAAAAAAAA\"}]," +
           rest + "}";
  };
  const auto aboveABone = [&](const std::string& transform) {
    return head + ",\"nodes\":[{" + transform + ",\"children\":[1]},{}],\"skins\":[{\"joints\":[1]}]}";
  };
  const std::string mesh =
      "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]";
  const auto accessor = [&](const std::string& type, const std::string& count, const std::string& offset,
                            const std::string& length) {
    return buffer("\"bufferViews\":[{\"buffer\":0,\"byteLength\":" + length +
                  "}],\"accessors\":[{\"bufferView\":0,\"byteOffset\":" + offset +
                  ",\"componentType\":5126,\"count\":" + count + ",\"type\":\"" + type + "\"}]," + mesh);
  };
  testing::expectRefused(
      {
          {"empty", "", 0, "glTF 2.0"},
          {"not JSON", "{\"asset\"", 0, "glTF 2.0"},
          {"JSON of something else", "[1, 2]", 0, "glTF 2.0"},
          {"no asset", "{}", 0, ""},
          {"binary cut off", std::string("glTF\2\0\0\0\x40\0\0\0", 12), 0, "glTF 2.0"},
          {"binary of version 1", std::string("glTF\1\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0", 20), 0, "glTF 2.0"},
          {"no node", head + "}", 0, "at least one node"},
          {"child that does not exist", head + ",\"nodes\":[{\"children\":[7]}]}", 0,
           "children among the 1 nodes, found 7"},
          {"negative child", head + ",\"nodes\":[{\"children\":[-2]}]}", 0, ""},
          {"two parents", head + ",\"nodes\":[{\"children\":[2]},{\"children\":[2]},{}]}", 0, "one parent"},
          {"cycle",
           head +
               ",\"nodes\":[{\"children\":[1]},{\"children\":[0]}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0}",
           0, "cycle"},
          {"its own child", head + ",\"nodes\":[{\"children\":[0]}],\"scenes\":[{\"nodes\":[0]}]}", 0,
           "cycle"},
          {"scene of missing nodes", head + ",\"nodes\":[{}],\"scenes\":[{\"nodes\":[3]}]}", 0,
           "scene's nodes"},
          {"unequal scale above a bone", aboveABone("\"scale\":[1,2,1]"), 0, "unequal scales"},
          {"scale zero above a bone", aboveABone("\"scale\":[0,0,0]"), 0, "one positive scale"},
          {"mirror above a bone", aboveABone("\"scale\":[-1,1,1]"), 0, "mirror"},
          {"shear above a bone", aboveABone("\"matrix\":[1,0,0,0, 1,1,0,0, 0,0,1,0, 0,0,0,1]"), 0, "shear"},
          {"quaternion of length 2", head + ",\"nodes\":[{\"rotation\":[0,0,0,2]}]}", 0, "unit quaternions"},
          {"huge translation",
           head + ",\"nodes\":[{\"translation\":[1e308,0,0],\"scale\":[1e300,1e300,1e300],\"children\":[1]},{"
                  "\"translation\":[1e308,0,0]}]}",
           0, ""},
          {"mesh that does not exist", head + ",\"nodes\":[{\"mesh\":4}]}", 0, "a mesh among 0"},
          {"skin that does not exist",
           accessor("VEC3", "1", "0", "12")
               .replace(accessor("VEC3", "1", "0", "12").find("{\"mesh\":0}"), 10,
                        "{\"mesh\":0,\"skin\":3,\"children\":[1]},{}"),
           0, "a skin among 0"},
          {"accessor beyond its view", accessor("VEC3", "2", "0", "12"), 0, "2 elements in 12 bytes"},
          {"a billion elements", accessor("VEC3", "1000000000", "0", "12"), 0, "1000000000 elements"},
          {"offset beyond the view", accessor("VEC3", "1", "100", "12"), 0, "elements in 12 bytes"},
          {"view beyond its buffer", accessor("VEC3", "1", "0", "1200"), 0, "a view beyond its buffer"},
          {"positions of two numbers", accessor("VEC2", "1", "0", "12"), 0, "2 components instead of 3"},
          {"one vertex, no triangle", accessor("VEC3", "1", "0", "12"), 0, "three indices a triangle"},
          {"no positions",
           head + ",\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{}}]}]}", 0,
           "positions in every mesh"},
          {"accessor that does not exist", head + "," + mesh + "}", 0, "accessor 0"},
          {"skin with a missing joint", head + ",\"nodes\":[{}],\"skins\":[{\"joints\":[5]}]}", 0,
           "a skin's joints"},
          {"animation of a missing node",
           head + ",\"nodes\":[{}],\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":9,"
                  "\"path\":\"rotation\"}}],\"samplers\":[{\"input\":0,\"output\":0}]}]}",
           0, "an animation's node"},
          {"animation without its sampler",
           head + ",\"nodes\":[{}],\"animations\":[{\"channels\":[{\"sampler\":3,\"target\":{\"node\":0,"
                  "\"path\":\"rotation\"}}],\"samplers\":[]}]}",
           0, ""},
      },
      [](const std::string& text, const std::string& file) { parseGltf(text, file); });
}

// Nodes alone would give unlimited balls: knees that bend sideways.
TEST(Gltf, JointsComeBackAsTheyMove) {
  const Skeleton figure = mannequin();
  const std::string path = (std::filesystem::temp_directory_path() / "motions.glb").string();
  Mesh triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.triangles = {{0, 1, 2}};
  const Skin skin =
      bindSkin(triangle, restFrames(figure), fourLargest(SparseWeights(3, {{0, 1.0}}), figure.jointCount()));
  writeGltf(path, figure, &skin, {}, GltfJoints::AsTheyMove);  // what a skin hangs on turns without extras
  const Skeleton again = readGltf(path).skeleton;
  ASSERT_EQ(again.jointCount(), figure.jointCount());
  ASSERT_EQ(again.nq(), figure.nq());
  EXPECT_LT((again.rest() - figure.rest()).norm(), 1e-12);
  std::mt19937_64 random(5);
  for (int k = 0; k < 5; ++k) {
    const Eigen::VectorXd q = randomWithinLimits(figure, random);
    const Frames a = forwardKinematics(figure, q), b = forwardKinematics(again, q);
    for (int j = 0; j < figure.jointCount(); ++j)
      EXPECT_LT((a[j].matrix() - b[j].matrix()).norm(), 1e-9) << j;
  }
  for (int j = 0; j < figure.jointCount(); ++j) {
    ASSERT_EQ(again.joint(j).axes.size(), figure.joint(j).axes.size());
    for (std::size_t k = 0; k < figure.joint(j).axes.size(); ++k) {
      EXPECT_EQ(again.joint(j).axes[k].lower, figure.joint(j).axes[k].lower);
      EXPECT_EQ(again.joint(j).axes[k].upper, figure.joint(j).axes[k].upper);
    }
    ASSERT_EQ(again.joint(j).ballLimit.has_value(), figure.joint(j).ballLimit.has_value());
    if (figure.joint(j).ballLimit) {
      EXPECT_EQ(again.joint(j).ballLimit->swingRadii, figure.joint(j).ballLimit->swingRadii);
      EXPECT_EQ(again.joint(j).ballLimit->twistUpper, figure.joint(j).ballLimit->twistUpper);
    }
  }
}

TEST(Gltf, MotionsThatAreNoneAreRefused) {
  const auto node = [](const std::string& motion) {
    return R"({"asset":{"version":"2.0"},"nodes":[{"extras":{"gelenk":)" + motion + "}}]}";
  };
  testing::expectRefused(
      {{"no object", node("7"), 0, "list of axes"},
       {"an axis of two numbers", node(R"({"axes":[{"turn":[1,0]}]})"), 0, "3 numbers"},
       {"an axis of length 2", node(R"({"axes":[{"turn":[2,0,0]}]})"), 0, ""},
       {"reversed limits", node(R"({"axes":[{"turn":[1,0,0],"lower":1,"upper":-1}]})"), 0, ""},
       {"a quaternion of zeros", node(R"({"ball":{"rest":[0,0,0,0]}})"), 0, ""}},
      [](const std::string& text, const std::string& file) { parseGltf(text, file); });
}

TEST(Gltf, KeyTimesThatSinglePrecisionDoesNotHoldAreRefused) {
  const Skeleton figure = mannequin();
  MotionClip clip{.framesPerSecond = 30.0, .q = figure.rest().replicate(1, 3)};
  const auto write = [&](double rate) {
    clip.framesPerSecond = rate;
    formatGlb(figure, nullptr, {{"clip", clip}});
  };
  EXPECT_NO_THROW(write(0.01));
  EXPECT_THROW(write(1e-300), std::invalid_argument);  // infinite
  EXPECT_THROW(write(1e60), std::invalid_argument);    // all at 0
}

}  // namespace
}  // namespace gelenk
