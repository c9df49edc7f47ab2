#include "apps/render/video.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <vector>

extern char** environ;

namespace gelenk {
namespace {

bool isGif(const std::string& path) { return path.ends_with(".gif"); }

/// Fails early, with the system's reason, where the folder cannot be written.
void requireWritable(const std::string& path) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (file < 0) throw std::runtime_error("cannot write " + path + ": " + std::strerror(errno));
  close(file);
}

/// Starts the program with its standard input at the reading end of a pipe; returns the errno of
/// posix_spawnp.
int startReader(const std::vector<std::string>& words, int readEnd, int writeEnd, pid_t& process) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, readEnd, STDIN_FILENO);
  posix_spawn_file_actions_addclose(&actions, readEnd);
  posix_spawn_file_actions_addclose(&actions, writeEnd);
  const int error = posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

}  // namespace

VideoWriter::VideoWriter(const std::string& path, int width, int height, int framesPerSecond)
    : path_(path), unfinished_(path + ".tmp" + std::to_string(getpid()) + (isGif(path) ? ".gif" : ".mp4")) {
  if (width % 2 != 0 || height % 2 != 0)
    throw std::runtime_error("a video needs an even width and height, not " + std::to_string(width) + " x " +
                             std::to_string(height));
  requireWritable(unfinished_);
  std::signal(SIGPIPE, SIG_IGN);  // a reader that gives up shows as a failed write
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw std::runtime_error(std::string("cannot make a pipe: ") + std::strerror(errno));
  const std::vector<std::string> encoding =
      isGif(path)
          ? std::vector<std::string>{"-filter_complex", "[0:v]split[a][b];[a]palettegen[p];[b][p]paletteuse"}
          : std::vector<std::string>{"-c:v", "libx264",  "-preset", "medium",    "-crf",
                                     "18",   "-pix_fmt", "yuv420p", "-movflags", "+faststart"};
  std::vector<std::string> words{"ffmpeg",
                                 "-y",
                                 "-loglevel",
                                 "error",
                                 "-f",
                                 "rawvideo",
                                 "-pixel_format",
                                 "rgba",
                                 "-video_size",
                                 std::to_string(width) + "x" + std::to_string(height),
                                 "-framerate",
                                 std::to_string(framesPerSecond),
                                 "-i",
                                 "-"};
  words.insert(words.end(), encoding.begin(), encoding.end());
  words.push_back(unfinished_);
  const int error = startReader(words, ends[0], ends[1], process_);
  close(ends[0]);
  pipe_ = fdopen(ends[1], "wb");
  if (error == 0) return;
  process_ = -1;
  std::fclose(pipe_);
  pipe_ = nullptr;
  std::remove(unfinished_.c_str());
  throw std::runtime_error("writing a video needs the program ffmpeg, which cannot be started (" +
                           std::string(std::strerror(error)) + "); apt install ffmpeg, or write a .png");
}

VideoWriter::~VideoWriter() {
  if (pipe_) std::fclose(pipe_);
  if (process_ > 0) waitpid(process_, nullptr, 0);
  if (!unfinished_.empty()) std::remove(unfinished_.c_str());
}

void VideoWriter::add(const Image& image) {
  if (std::fwrite(image.pixels.data(), 1, image.pixels.size(), pipe_) != image.pixels.size())
    throw std::runtime_error("ffmpeg stopped before the video " + path_ + " was complete");
}

void VideoWriter::finish() {
  const bool flushed = std::fclose(pipe_) == 0;
  pipe_ = nullptr;
  int status = 0;
  waitpid(process_, &status, 0);
  process_ = -1;
  if (!flushed || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error("ffmpeg could not write the video " + path_);
  if (std::rename(unfinished_.c_str(), path_.c_str()) != 0)
    throw std::runtime_error("cannot write " + path_ + ": " + std::strerror(errno));
  unfinished_.clear();
}

}  // namespace gelenk
