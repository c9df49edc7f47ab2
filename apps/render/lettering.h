#pragma once

#include <memory>
#include <string>

#include "apps/commands/image.h"
#include "apps/render/colour.h"

namespace gelenk {

/// Words in pictures, in the typeface of the sandbox (Roboto), drawn by FreeType.
class Lettering {
 public:
  /// size: of the type, pixels. Throws std::runtime_error where the typeface is not installed.
  explicit Lettering(int size);
  ~Lettering();
  Lettering(const Lettering&) = delete;
  Lettering& operator=(const Lettering&) = delete;

  /// Pixels from the first letter's origin to where the next would stand. words: UTF-8.
  int width(const std::string& words) const;
  /// Writes with the baseline's left end at x, y; what lies outside the picture is cut off.
  void write(Image& picture, int x, int y, const std::string& words, const Colour& colour) const;

 private:
  struct Face;
  std::unique_ptr<Face> face_;
};

}  // namespace gelenk
