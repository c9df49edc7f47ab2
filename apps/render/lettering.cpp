#include "apps/render/lettering.h"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <cmath>
#include <stdexcept>
#include <vector>

namespace gelenk {
namespace {

constexpr const char* typeface = "/usr/share/fonts/truetype/roboto/unhinted/RobotoTTF/Roboto-Medium.ttf";

/// Code points of UTF-8; a byte that begins none becomes U+FFFD.
std::vector<char32_t> codePoints(const std::string& words) {
  std::vector<char32_t> points;
  for (std::size_t i = 0; i < words.size();) {
    const auto lead = static_cast<unsigned char>(words[i++]);
    const int more = lead < 0x80 ? 0 : lead >> 5 == 6 ? 1 : lead >> 4 == 14 ? 2 : lead >> 3 == 30 ? 3 : -1;
    char32_t point = more == 0 ? lead : more < 0 ? 0xfffd : lead & (0x3f >> more);
    for (int k = 0; k < more && i < words.size(); ++k)
      point = point << 6 | (static_cast<unsigned char>(words[i++]) & 0x3f);
    points.push_back(point);
  }
  return points;
}

}  // namespace

struct Lettering::Face {
  FT_Library library = nullptr;
  FT_Face face = nullptr;

  explicit Face(int size) {
    if (FT_Init_FreeType(&library) != 0) throw std::runtime_error("FreeType cannot be started");
    if (FT_New_Face(library, typeface, 0, &face) != 0 ||
        FT_Set_Pixel_Sizes(face, 0, static_cast<FT_UInt>(size)) != 0) {
      FT_Done_FreeType(library);  // and its faces
      throw std::runtime_error(std::string("the typeface ") + typeface +
                               " is missing: apt install fonts-roboto-unhinted");
    }
  }
  ~Face() { FT_Done_FreeType(library); }

  /// Calls use(glyph slot, left edge of the pen) for every letter; returns where the pen ends.
  template <class Use>
  int forEachGlyph(const std::string& words, FT_Int32 flags, const Use& use) const {
    FT_Pos pen = 0;  // 1/64 pixels
    FT_UInt before = 0;
    for (const char32_t point : codePoints(words)) {
      const FT_UInt glyph = FT_Get_Char_Index(face, point);
      FT_Vector kerning{0, 0};
      if (before != 0 && FT_HAS_KERNING(face))
        FT_Get_Kerning(face, before, glyph, FT_KERNING_DEFAULT, &kerning);
      pen += kerning.x;
      if (FT_Load_Glyph(face, glyph, flags) != 0) continue;
      use(face->glyph, static_cast<int>(pen / 64));
      pen += face->glyph->advance.x;
      before = glyph;
    }
    return static_cast<int>((pen + 32) / 64);
  }
};

Lettering::Lettering(int size) : face_(std::make_unique<Face>(size)) {}
Lettering::~Lettering() = default;

int Lettering::width(const std::string& words) const {
  return face_->forEachGlyph(words, FT_LOAD_TARGET_LIGHT, [](FT_GlyphSlot, int) {});
}

void Lettering::write(Image& picture, int x, int y, const std::string& words, const Colour& colour) const {
  const float ink[3] = {colour.r, colour.g, colour.b};
  face_->forEachGlyph(words, FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT, [&](FT_GlyphSlot slot, int pen) {
    const FT_Bitmap& bitmap = slot->bitmap;
    for (int row = 0; row < static_cast<int>(bitmap.rows); ++row)
      for (int column = 0; column < static_cast<int>(bitmap.width); ++column) {
        const int px = x + pen + slot->bitmap_left + column, py = y - slot->bitmap_top + row;
        if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
        const float cover =
            colour.a * static_cast<float>(bitmap.buffer[row * bitmap.pitch + column]) / 255.0f;
        std::uint8_t* pixel = &picture.pixels[4 * (static_cast<std::size_t>(py) * picture.width + px)];
        for (int k = 0; k < 3; ++k)
          pixel[k] = static_cast<std::uint8_t>(
              std::lround((1.0f - cover) * static_cast<float>(pixel[k]) + 255.0f * cover * ink[k]));
      }
  });
}

}  // namespace gelenk
