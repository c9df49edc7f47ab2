#pragma once

#include <memory>
#include <string>

#include "apps/render/video.h"

namespace gelenk {

/// A film of what the sandbox shows, 30 pictures a second of its own time: .mp4 or .gif. A window at rest
/// gives the same picture again, so that the film lasts as long as what was seen.
class Recorder {
 public:
  static constexpr int framesPerSecond = 30;

  /// Throws std::runtime_error where the file cannot be written or ffmpeg is missing.
  void start(const std::string& path, int width, int height, double time);
  bool isRunning() const { return video_ != nullptr; }
  const std::string& path() const { return path_; }
  double seconds() const { return static_cast<double>(written_) / framesPerSecond; }
  /// Whether a picture is due at this time.
  bool wants(double time) const;
  /// As many copies of the picture as have become due. A picture of another size is cut or padded. Throws
  /// where ffmpeg has given up; the recording is over then.
  void add(const Image& picture, double time);
  /// Throws likewise. The file is complete afterwards.
  void finish();

 private:
  long due(double time) const;
  std::unique_ptr<VideoWriter> video_;
  std::string path_;
  int width_ = 0, height_ = 0;
  double start_ = 0.0;
  long written_ = 0;
};

}  // namespace gelenk
