#include "apps/sandbox/recorder.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gelenk {
namespace {

/// The upper left of the picture in the film's size.
Image sized(const Image& picture, int width, int height) {
  if (picture.width == width && picture.height == height) return picture;
  Image out{width, height, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(width) * height, 0)};
  const std::size_t row = 4 * static_cast<std::size_t>(std::min(width, picture.width));
  for (int y = 0; y < std::min(height, picture.height); ++y)
    std::memcpy(&out.pixels[4 * static_cast<std::size_t>(y) * width],
                &picture.pixels[4 * static_cast<std::size_t>(y) * picture.width], row);
  return out;
}

}  // namespace

void Recorder::start(const std::string& path, int width, int height, double time) {
  width_ = width - width % 2;  // as encoders want it
  height_ = height - height % 2;
  video_ = std::make_unique<VideoWriter>(path, width_, height_, framesPerSecond);
  path_ = path;
  start_ = time;
  written_ = 0;
}

long Recorder::due(double time) const {
  return static_cast<long>(std::floor((time - start_) * framesPerSecond + 1e-6)) + 1;
}

bool Recorder::wants(double time) const { return video_ && due(time) > written_; }

void Recorder::add(const Image& picture, double time) {
  if (!wants(time)) return;
  const Image frame = sized(picture, width_, height_);
  try {
    for (const long until = due(time); written_ < until; ++written_) video_->add(frame);
  } catch (...) {
    video_.reset();
    throw;
  }
}

void Recorder::finish() {
  if (!video_) return;
  const auto video = std::move(video_);
  video->finish();
}

}  // namespace gelenk
