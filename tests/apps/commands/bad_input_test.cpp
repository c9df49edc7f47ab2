#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "apps/document/model_files.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "skinning/blend/linear_blend.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using ::testing::HasSubstr;

/// A folder of small files that goes with the test.
class BadFiles : public ::testing::Test {
 protected:
  BadFiles()
      : folder_(::testing::TempDir() + "gelenk_bad_" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::create_directories(folder_);
  }
  ~BadFiles() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << content;
    return folder_ + "/" + name;
  }
  std::string path(const std::string& name) const { return folder_ + "/" + name; }

  std::string sentence(const std::string& body, const std::string& skeleton,
                       const std::string& weights) const {
    try {
      importFiles(
          body,
          {.skeleton = skeleton, .weights = weights, .asf = {}, .amc = {}, .mapping = {}, .figure = {}});
    } catch (const std::exception& error) {
      return error.what();
    }
    return "accepted";
  }

  const std::string goodObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const std::string goodSkeleton = "a 0 0 0 -1\nb 0 1 0 a\nc 0 2 0 b\n";
  const std::string goodWeights = "1 0\n0.5 0.5\n0 1\n1 0\n";

 private:
  std::string folder_;
};

TEST_F(BadFiles, AGoodTrioOpensAndStandsInPlace) {
  const Imported imported = importFiles(file("b.obj", goodObj), {.skeleton = file("s.skel", goodSkeleton),
                                                                 .weights = file("w.attachment", goodWeights),
                                                                 .asf = {},
                                                                 .amc = {},
                                                                 .mapping = {},
                                                                 .figure = {}});
  ASSERT_TRUE(imported.model.skin);
  const auto rest = linearBlendSkin(*imported.model.skin, restFrames(imported.model.skeleton));
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_LE((rest.positions[v] - imported.model.skin->mesh.positions[v]).norm(), 1e-15);
  EXPECT_THAT(imported.model.notes.at(0).text, HasSubstr("four largest weights kept"));
}

TEST_F(BadFiles, AnObjWithASkeletonAndNoWeightsGetsHeatWeights) {
  const Imported imported = importFiles(file("b.obj", goodObj), {.skeleton = file("s.skel", goodSkeleton),
                                                                 .weights = {},
                                                                 .asf = {},
                                                                 .amc = {},
                                                                 .mapping = {},
                                                                 .figure = {}});
  ASSERT_TRUE(imported.model.skin);
  EXPECT_THAT(imported.model.notes.at(0).text, HasSubstr("heat"));
}

TEST_F(BadFiles, WhatIsGivenBesideAModelIsReadOrRefused) {
  const auto refusal = [](const std::string& model, const Companions& files) {
    try {
      importFiles(model, files);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal("figure", {.asf = "a.asf"}), HasSubstr("not read together with --asf a.asf"));
  EXPECT_THAT(refusal("panda", {.weights = "w"}), HasSubstr("--weights w"));
  EXPECT_THAT(refusal("figure", {.clip = "wave"}), HasSubstr("--clip"));
  EXPECT_THAT(refusal("figure", {.up = "z"}), HasSubstr("--up"));
  EXPECT_THAT(refusal(gelenk::testing::inputFolder() + "/forearm.bvh", {.amc = "m.amc"}),
              HasSubstr("--amc m.amc"));
  EXPECT_THAT(refusal(file("b.obj", goodObj), {.skeleton = file("s.skel", goodSkeleton), .amc = "m.amc"}),
              HasSubstr("--amc needs --asf"));
}

TEST_F(BadFiles, EachIsRefusedInOneSentenceThatNamesTheFile) {
  const std::string obj = file("b.obj", goodObj), skeleton = file("s.skel", goodSkeleton),
                    weights = file("w.attachment", goodWeights);
  EXPECT_THAT(sentence(path("none.obj"), skeleton, weights), HasSubstr("none.obj: No such file"));
  EXPECT_THAT(sentence(obj, path("none.skel"), weights), HasSubstr("none.skel: No such file"));
  EXPECT_THAT(sentence(obj, skeleton, path("none.attachment")), HasSubstr("none.attachment: No such file"));
  EXPECT_THAT(sentence(file("empty.obj", ""), skeleton, weights),
              HasSubstr("empty.obj: expected at least one vertex"));
  EXPECT_THAT(sentence(file("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"), skeleton, weights),
              HasSubstr("far.obj:4: expected a vertex index of at most 3, found 9"));
  EXPECT_THAT(sentence(file("nan.obj", "v 0 nan 0\n"), skeleton, weights),
              HasSubstr("nan.obj:1: expected a finite number, found 'nan'"));
  EXPECT_THAT(sentence(obj, skeleton, file("few.attachment", "1 0\n")),
              HasSubstr("few.attachment: expected 4 rows"));
  EXPECT_THAT(sentence(obj, file("later.skel", "a 0 0 0 -1\nb 0 1 0 c\nc 0 2 0 a\n"), weights),
              HasSubstr("later.skel:2"));
  EXPECT_THAT(sentence(obj, file("two.skel", "a 0 0 0 -1\nb 0 1 0 -1\n"), weights), HasSubstr("two.skel:2"));
  EXPECT_THAT(sentence(obj, file("ring.skel", "a 0 0 0 -1\nb 0 1 0 c\nc 0 2 0 b\n"), weights),
              HasSubstr("cycle"));
  EXPECT_THAT(sentence(obj, file("zero.skel", "a 0 0 0 -1\nb 0 0 0 a\n"), weights),
              HasSubstr("zero.skel:2: expected a bone of positive length"));
  EXPECT_THAT(sentence(obj, "", ""), HasSubstr("mesh without a skeleton"));
  EXPECT_THAT(sentence(weights, "", ""), HasSubstr("holds weights only"));
  EXPECT_THAT(sentence(file("m.amc", "1\n"), "", ""), HasSubstr("--asf"));
  EXPECT_THAT(sentence(file("p.pose", "NumJoints: 1\n"), "", ""), HasSubstr("--figure"));
  EXPECT_THAT(sentence(file("what.xyz", "?"), "", ""), HasSubstr("cannot tell what"));
  EXPECT_THAT(sentence("no such name", "", ""), HasSubstr("no model is called 'no such name'"));
  EXPECT_THAT(sentence(path(""), "", ""), HasSubstr("cannot tell what"));
}

TEST_F(BadFiles, AFileThatCannotBeWrittenLeavesTheOldOneAndSaysWhy) {
  EXPECT_THROW(writeFile(path("no/such/folder/x.bvh"), "new"), std::runtime_error);
  const std::string old = file("old.txt", "old");
  EXPECT_THROW(writeFile(old + "/below", "new"), std::runtime_error);
  EXPECT_EQ(readFile(old), "old");
}

TEST_F(BadFiles, TutorialFilesAreToldByTheirFirstWords) {
  EXPECT_EQ(fileKind(file("t.skel", "NumJoints: 1\nNonAnimatedJointPositions:\n")),
            FileKind::TutorialSkeleton);
  EXPECT_EQ(fileKind(file("t.txt", "\nNumJoints: 1\nJointAngles:\n")), FileKind::TutorialPose);
  EXPECT_EQ(fileKind(file("p.skel", goodSkeleton)), FileKind::PinocchioSkeleton);
  EXPECT_EQ(fileKind("B.OBJ"), FileKind::ObjMesh);
  EXPECT_EQ(fileKind("x.skeleton.out"), FileKind::PinocchioSkeleton);
}

}  // namespace
}  // namespace gelenk
