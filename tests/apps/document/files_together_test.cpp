#include "apps/document/files_together.h"

#include <gmock/gmock.h>

#include <stdexcept>

namespace gelenk {
namespace {

using ::testing::HasSubstr;

TEST(FilesTogether, ASurfaceTakesItsSkeletonAndWeights) {
  const ModelReference body = filesTogether({"body.weights", "body.skel", "body.obj"});
  EXPECT_EQ(body, (ModelReference{.nameOrFile = "body.obj",
                                  .files = {.skeleton = "body.skel", .weights = "body.weights"}}));
  const ModelReference alone = filesTogether({"body.obj"});
  EXPECT_EQ(alone, (ModelReference{.nameOrFile = "body.obj"}));
  const ModelReference motion = filesTogether({"walk.amc", "person.asf"});
  EXPECT_EQ(motion, (ModelReference{.nameOrFile = "walk.amc", .files = {.asf = "person.asf"}}));
  const ModelReference laid = filesTogether({"walk.amc", "body.obj", "person.asf"});
  EXPECT_EQ(laid,
            (ModelReference{.nameOrFile = "body.obj", .files = {.asf = "person.asf", .amc = "walk.amc"}}));
}

TEST(FilesTogether, AModelReadsItsOwnFilesFromAmongThem) {
  EXPECT_EQ(filesTogether({"meshes/link.stl", "arm.urdf", "meshes/link.obj"}).nameOrFile, "arm.urdf");
  EXPECT_EQ(filesTogether({"skin.png", "figure.bin", "figure.gltf"}).nameOrFile, "figure.gltf");
  EXPECT_EQ(filesTogether({"arm.urdf", "scene.json"}).nameOrFile, "scene.json");
  EXPECT_EQ(filesTogether({"readme.txt", "walk.bvh"}).nameOrFile, "walk.bvh");
}

TEST(FilesTogether, WhatFileManagersLeaveBesideFilesIsNoFile) {
  EXPECT_EQ(filesTogether({"arm/arm.urdf", "__MACOSX/arm/._arm.urdf", "arm/.DS_Store"}).nameOrFile,
            "arm/arm.urdf");
  EXPECT_EQ(filesTogether({"__MACOSX/._body.obj", "body.obj"}), (ModelReference{.nameOrFile = "body.obj"}));
  EXPECT_THROW(filesTogether({".DS_Store", "._arm.urdf"}), std::invalid_argument);
}

TEST(FilesTogether, SeveralOrNoneAreToldByName) {
  try {
    filesTogether({"left.urdf", "right.urdf"});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("left.urdf, right.urdf"));
  }
  try {
    filesTogether({"a.txt", "b.png"});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.txt, b.png"));
  }
  EXPECT_THROW(filesTogether({}), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
