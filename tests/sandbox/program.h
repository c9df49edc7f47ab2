#pragma once

#include <string>
#include <vector>

namespace gelenk::testing {

/// A child process; ended (SIGTERM, then waited for) when the object goes.
class Program {
 public:
  /// arguments[0] is looked up in PATH. environment: entries "NAME=value" that replace the test's own, "NAME"
  /// alone unsets. Standard output and error go to the same pipe.
  Program(const std::vector<std::string>& arguments, const std::vector<std::string>& environment = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Everything it writes until it ends, and its exit status (128 + signal where killed).
  int wait(std::string& output);
  /// The first line that it writes, without the end.
  std::string readLine();
  bool running();
  int id() const { return pid_; }
  /// SIGKILL: the process gets no chance to tidy up.
  void kill();

 private:
  int pid_ = -1, pipe_ = -1, status_ = -1;
};

struct Finished {
  int status = -1;
  std::string output;
};
Finished runProgram(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment = {});

/// True where the command can be found in PATH.
bool hasCommand(const std::string& name);

}  // namespace gelenk::testing
