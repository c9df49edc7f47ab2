// A folder of its own for each run of a test program: tests run side by side, and two that write a file of
// the same name would read each other's.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

namespace {

class OwnFolder {
 public:
  OwnFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "gelenk-tests-XXXXXX").string();
    if (!mkdtemp(pattern.data())) {
      std::perror(pattern.c_str());
      std::abort();
    }
    path_ = pattern;
    setenv("TMPDIR", pattern.c_str(), 1);  // std::filesystem::temp_directory_path, and what the tests start
    setenv("TEST_TMPDIR", (pattern + "/").c_str(), 1);  // ::testing::TempDir
  }
  ~OwnFolder() {
    std::error_code ignored;
    if (getpid() == owner_) std::filesystem::remove_all(path_, ignored);  // not by a child that was forked
  }

 private:
  std::filesystem::path path_;
  pid_t owner_ = getpid();
};

const OwnFolder ownFolder;

}  // namespace
