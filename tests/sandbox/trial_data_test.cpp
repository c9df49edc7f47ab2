// Every file of the trial data, given to the program as it is: info, render and sandbox answer with a result
// or with one sentence, never with a crash, a hang or silence. One test a folder, so that they run side by
// side.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "kinematics/io/text_file.h"
#include "tests/places.h"
#include "tests/sandbox/program.h"
#include "tests/sanitized.h"

namespace gelenk {
namespace {

namespace fs = std::filesystem;
using testing::Finished;

constexpr const char* patience = "120";  // seconds a file; the largest body takes 10 where nothing is cached

/// Folders of the trial data that hold files, relative to it; none where there is no trial data.
std::vector<std::string> folders() {
  std::vector<std::string> found;
  const fs::path root = testing::dataFolder();
  if (!fs::is_directory(root)) return found;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const std::string folder = fs::relative(entry.path().parent_path(), root).string();
    if (entry.is_regular_file() && std::ranges::find(found, folder) == found.end()) found.push_back(folder);
  }
  std::ranges::sort(found);
  return found;
}

class TrialData : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    std::string name = GetParam();
    std::ranges::replace(name, '/', '_');
    out_ = fs::temp_directory_path() / ("gelenk_trial_" + name + "_" + std::to_string(getpid()));
    fs::create_directories(out_);
  }
  void TearDown() override { fs::remove_all(out_); }

  /// A result (and the picture, where one is promised), or exit status 1 and a sentence.
  static void expectAnswer(std::vector<std::string> arguments, const fs::path& picture) {
    std::string line;
    for (const std::string& word : arguments) line += " " + word;
    arguments.insert(arguments.begin(), {"timeout", patience, testing::programFile()});
    const Finished finished = testing::runProgram(arguments);
    EXPECT_TRUE(finished.status == 0 || finished.status == 1)
        << "gelenk" << line << "\nended with " << finished.status << ": " << finished.output;
    EXPECT_TRUE(finished.status == 0 || finished.output.size() > 10)
        << "gelenk" << line << " fails without a sentence";
    for (const char* word : {"what():", "Sanitizer", "runtime error"})
      EXPECT_EQ(finished.output.find(word), std::string::npos) << "gelenk" << line << '\n' << finished.output;
    if (picture.empty()) return;
    EXPECT_EQ(finished.status == 0, fs::exists(picture)) << "gelenk" << line;
    fs::remove(picture);
  }

  fs::path out_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(TrialData);

TEST_P(TrialData, EveryFileGivesAPictureOrASentence) {
  if (testing::sanitized && !std::getenv("GELENK_TRIAL_DATA"))
    GTEST_SKIP() << "minutes under a sanitizer: by hand, with GELENK_TRIAL_DATA set";
  const fs::path picture = out_ / "picture.png";
  for (const auto& entry : fs::directory_iterator(fs::path(testing::dataFolder()) / GetParam())) {
    if (!entry.is_regular_file()) continue;
    const std::string file = entry.path();
    expectAnswer({"info", file}, {});
    expectAnswer({"render", file, "--size", "320x240", "-o", picture}, picture);
    expectAnswer(
        {"sandbox", file, "--offscreen", "--size", "480x320", "--frames", "3", "--screenshot", picture},
        picture);
  }
}

std::string testName(const ::testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}
INSTANTIATE_TEST_SUITE_P(Folders, TrialData, ::testing::ValuesIn(folders()), testName);

}  // namespace
}  // namespace gelenk
