// A folder of its own for each run of a test program: tests run side by side, and two that write a file of
// the same name would read each other's. It stays where a test failed.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace {

class OwnFolder final : public ::testing::Environment {
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "gelenk-tests-XXXXXX").string();
    ASSERT_TRUE(mkdtemp(pattern.data())) << pattern;
    path_ = pattern;
    setenv("TMPDIR", pattern.c_str(), 1);  // std::filesystem::temp_directory_path, and what the tests start
    setenv("TEST_TMPDIR", (pattern + "/").c_str(), 1);  // ::testing::TempDir
  }
  void TearDown() override {
    std::error_code ignored;
    if (!::testing::UnitTest::GetInstance()->Failed()) std::filesystem::remove_all(path_, ignored);
  }

  std::filesystem::path path_;
};

const ::testing::Environment* const ownFolder = ::testing::AddGlobalTestEnvironment(new OwnFolder);

}  // namespace
