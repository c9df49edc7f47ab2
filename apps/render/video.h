#pragma once

#include <cstdio>
#include <string>

#include "apps/commands/image.h"

namespace gelenk {

/// Encodes pictures into an H.264 .mp4, or a .gif where the path ends so, by the program ffmpeg, which gets
/// raw frames through a pipe. The file appears under its name when finish() has succeeded.
class VideoWriter {
 public:
  /// width, height even. Throws std::runtime_error with a sentence where ffmpeg is missing or the folder
  /// cannot be written.
  VideoWriter(const std::string& path, int width, int height, int framesPerSecond);
  ~VideoWriter();  ///< without finish(): the unfinished file is removed
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// Throws std::runtime_error if ffmpeg has given up.
  void add(const Image& image);
  void finish();

 private:
  std::string path_, unfinished_;
  std::FILE* pipe_ = nullptr;
  int process_ = -1;
};

}  // namespace gelenk
