#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "kinematics/io/text_file.h"
#include "tests/places.h"
#include "tests/sandbox/program.h"

namespace gelenk {
namespace {

using ::testing::ContainsRegex;
using testing::Finished;
using ::testing::HasSubstr;

/// `gelenk path --model ur5` along a file of poses, in a folder of its own.
class PathCommand : public ::testing::Test {
 protected:
  PathCommand()
      : folder_(::testing::TempDir() + "gelenk_path_" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name() + "/") {
    std::filesystem::create_directories(folder_);
  }
  ~PathCommand() override { std::filesystem::remove_all(folder_); }

  Finished follow(const std::string& poses, std::vector<std::string> more = {}) const {
    writeFile(folder_ + "path.csv", poses);
    more.insert(more.begin(),
                {testing::programFile(), "path", "--model", "ur5", "--path", folder_ + "path.csv"});
    return testing::runProgram(more);
  }
  std::string out(const std::string& name) const { return folder_ + name; }

  const std::string poses = "0.4 0.1 0.5 0 1 0 0\n0.4 0.11 0.5 0 1 0 0\n0.4 0.12 0.5 0 1 0 0\n";

 private:
  std::string folder_;
};

TEST_F(PathCommand, AHeadingHasNoNumber) {
  for (const char* heading :
       {"", "x,y,z,qw,qx,qy,qz\n", "X Y Z QW QX QY QZ\n", "# 1 2 3\n\nplace and turn\n"})
    EXPECT_THAT(follow(heading + poses).output, HasSubstr("3 poses, 0 jumps")) << heading;
  for (const char* word : {"O.4", "1e999", "nan", "inf", "0.4.1"})
    EXPECT_THAT(follow(word + (" 0.1 0.5 0 1 0 0\n" + poses)).output,
                HasSubstr(std::string("path.csv:1: expected a finite number, found '") + word))
        << word;
  EXPECT_THAT(follow("nan nan nan nan nan nan nan\n" + poses).output,
              HasSubstr("path.csv:1: expected a finite"));
  EXPECT_THAT(follow("x 1 2\n" + poses).output,
              HasSubstr("path.csv:1: expected X Y Z QW QX QY QZ, found 3 values"));
  EXPECT_THAT(follow("x y z\nqw qx qy qz\n" + poses).output, HasSubstr("path.csv:2: expected X Y Z"));
}

TEST_F(PathCommand, TheWayFromTheStartCounts) {
  ASSERT_EQ(follow(poses, {"-o", out("q.csv")}).status, 0);
  const std::string table = readFile(out("q.csv"));
  std::string row(splitLines(table)[1]);
  std::replace(row.begin(), row.end(), ',', ' ');
  std::vector<std::string> start = {"--start"};
  for (const std::string_view word : splitWords(row)) start.emplace_back(word);
  start.erase(start.begin() + 1);  // the pose's number
  const Finished same = follow(poses, start);
  EXPECT_THAT(same.output, HasSubstr("3 poses, 0 jumps"));
  EXPECT_EQ(same.status, 0);
  start[1] = exactNumber(*parseNumber(start[1]) + 0.75);
  const Finished far = follow(poses, start);
  EXPECT_THAT(far.output, HasSubstr("jump between the start and pose 1: a joint turns by 0.75"));
  EXPECT_EQ(far.status, 2);
  start[1] = "7";
  EXPECT_THAT(follow(poses, start).output, ContainsRegex("start: joint 1 .* at 7, outside its limits -6.28"));
}

TEST_F(PathCommand, WhatCannotBeWrittenIsRefusedWithEveryEnding) {
  const Finished done = follow(poses, {"-o", out("q.txt")});
  EXPECT_THAT(done.output, HasSubstr("can be written as .csv, "));
  EXPECT_THAT(done.output, HasSubstr(".bvh"));
  EXPECT_EQ(done.status, 1);
}

TEST_F(PathCommand, NoOptionTakesNan) {
  for (const char* option : {"--jump", "--fps", "--start"})
    EXPECT_THAT(follow(poses, {option, "nan"}).output,
                HasSubstr(std::string(option) + ": expected a number, found 'nan'"));
  EXPECT_THAT(follow(poses, {"--keys", "1"}).output, HasSubstr("expected a whole number from 2 to 1000000"));
  EXPECT_THAT(follow(poses, {"--fps", "1e-300"}).output, HasSubstr("expected a number from 0.01 to 10000"));
}

}  // namespace
}  // namespace gelenk
