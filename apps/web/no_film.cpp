// Films need the program ffmpeg, and a page starts no programs: this says so where one is begun.
#include <stdexcept>

#include "apps/render/video.h"

namespace gelenk {

VideoWriter::VideoWriter(const std::string&, int, int, int) {
  throw std::runtime_error(
      "a film needs the program ffmpeg, which a page cannot start; gelenk sandbox records one");
}
VideoWriter::~VideoWriter() = default;
void VideoWriter::add(const Image&) {}
void VideoWriter::finish() {}

}  // namespace gelenk
