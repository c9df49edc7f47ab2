#include "tests/sandbox/program.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>

namespace gelenk::testing {

Program::Program(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  pid_ = fork();
  if (pid_ == 0) {
    dup2(ends[1], 1);
    dup2(ends[1], 2);
    close(ends[0]);
    close(ends[1]);
    for (const std::string& entry : environment) {
      const auto equals = entry.find('=');
      if (equals == std::string::npos)
        unsetenv(entry.c_str());
      else
        setenv(entry.substr(0, equals).c_str(), entry.substr(equals + 1).c_str(), 1);
    }
    std::vector<char*> words;
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    execvp(words[0], words.data());
    _exit(127);
  }
  close(ends[1]);
  fcntl(ends[0], F_SETFD, FD_CLOEXEC);
  pipe_ = ends[0];
}

Program::~Program() {
  if (running()) {
    ::kill(pid_, SIGTERM);
    waitpid(pid_, &status_, 0);
  }
  close(pipe_);
}

bool Program::running() {
  if (pid_ < 0 || status_ != -1) return false;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return true;
  status_ = status;
  return false;
}

void Program::kill() {
  if (running() && ::kill(pid_, SIGKILL) == 0) waitpid(pid_, &status_, 0);
}

std::string Program::readLine() {
  std::string line;
  char c = 0;
  while (read(pipe_, &c, 1) == 1 && c != '\n') line += c;
  return line;
}

int Program::wait(std::string& output) {
  char block[4096];
  for (ssize_t n; (n = read(pipe_, block, sizeof block)) > 0;)
    output.append(block, static_cast<std::size_t>(n));
  if (status_ == -1) waitpid(pid_, &status_, 0);
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
}

Finished runProgram(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  Program program(arguments, environment);
  Finished finished;
  finished.status = program.wait(finished.output);
  return finished;
}

bool hasCommand(const std::string& name) {
  std::istringstream folders(std::getenv("PATH") ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access((folder + "/" + name).c_str(), X_OK) == 0) return true;
  return false;
}

}  // namespace gelenk::testing
