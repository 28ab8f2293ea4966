// See letter_pictures.h.
#include "ui/letter_pictures.h"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "ui/letters.h"
#include "ui/platform/letter_files.h"

namespace likeness::ui {

namespace {

constexpr float kEm = 0.84f;      // of a line, as in the window's own font
constexpr float kRise = 0.8f;     // of a line that is above what letters stand on
constexpr std::size_t kOpen = 8;  // font files at a time

struct FreeFontFace {
  void operator()(FT_Face face) const { FT_Done_Face(face); }
};
using FontFace = std::unique_ptr<FT_FaceRec, FreeFontFace>;

FT_Face open_font_face(const LetterFile& file) {
  static FT_Library library = [] {
    FT_Library made = nullptr;
    return FT_Init_FreeType(&made) == 0 ? made : nullptr;
  }();
  static std::map<std::pair<std::string, int>, FontFace> faces;
  if (!library) return nullptr;
  const std::pair key(file.path, file.face);
  if (const auto known = faces.find(key); known != faces.end()) return known->second.get();
  if (faces.size() >= kOpen) faces.clear();
  FT_Face face = nullptr;
  if (FT_New_Face(library, file.path.c_str(), file.face, &face) != 0) face = nullptr;
  return faces.emplace(key, FontFace(face)).first->second.get();
}

// Of a font of pictures, whose sizes are fixed: the one above the wanted, or the largest. Its pixels for one
// of ours.
std::optional<float> choose_size(FT_Face face, float em) {
  if (FT_IS_SCALABLE(face)) {
    if (FT_Set_Pixel_Sizes(face, 0, FT_UInt(std::max(1.f, std::round(em)))) != 0) return std::nullopt;
    return 1.f;
  }
  int best = -1;
  for (int i = 0; i < face->num_fixed_sizes; ++i) {
    const auto height = [&](int k) { return float(face->available_sizes[k].y_ppem) / 64; };
    if (best < 0 ||
        (height(best) < em ? height(i) > height(best) : height(i) >= em && height(i) < height(best)))
      best = i;
  }
  if (best < 0 || FT_Select_Size(face, best) != 0) return std::nullopt;
  return std::max(1.f, float(face->available_sizes[best].y_ppem) / 64 / em);
}

// 0..255; of a coloured picture what is light counts more, so that its drawing is seen.
int cover_at(const FT_Bitmap& bitmap, int x, int y) {
  const unsigned char* row = bitmap.buffer + std::ptrdiff_t(y) * bitmap.pitch;
  switch (bitmap.pixel_mode) {
    case FT_PIXEL_MODE_MONO:
      return row[x / 8] >> (7 - x % 8) & 1 ? 255 : 0;
    case FT_PIXEL_MODE_GRAY:
      return row[x];
    case FT_PIXEL_MODE_BGRA: {
      const unsigned char* p = row + 4 * x;  // premultiplied
      return (p[3] * 80 + (p[0] * 18 + p[1] * 183 + p[2] * 54) * 175 / 255) / 255;
    }
    default:
      return 0;
  }
}

LetterPicture reduced(const FT_GlyphSlotRec& glyph, float scale) {
  const FT_Bitmap& bitmap = glyph.bitmap;
  LetterPicture picture;
  picture.advance = std::round(float(glyph.advance.x) / 64 / scale);
  picture.left = int(std::lround(float(glyph.bitmap_left) / scale));
  picture.top = int(std::lround(float(glyph.bitmap_top) / scale));
  picture.width = int(std::ceil(float(bitmap.width) / scale));
  picture.height = int(std::ceil(float(bitmap.rows) / scale));
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const auto from = [&](int k) { return int(float(k) * scale); };
      const int x1 = std::min(std::max(from(x + 1), from(x) + 1), int(bitmap.width));
      const int y1 = std::min(std::max(from(y + 1), from(y) + 1), int(bitmap.rows));
      int sum = 0, count = 0;
      for (int v = from(y); v < y1; ++v)
        for (int u = from(x); u < x1; ++u) sum += cover_at(bitmap, u, v), ++count;
      picture.covers.push_back(std::uint8_t(count > 0 ? sum / count : 0));
    }
  return picture;
}

std::optional<LetterPicture> from_system(std::uint32_t letter, float size) {
  const auto file = file_of_letter(char32_t(letter));
  FT_Face face = file ? open_font_face(*file) : nullptr;
  if (!face) return std::nullopt;
  const FT_UInt glyph = FT_Get_Char_Index(face, letter);
  const auto scale = choose_size(face, kEm * size);
  if (glyph == 0 || !scale || FT_Load_Glyph(face, glyph, FT_LOAD_COLOR) != 0 ||
      (face->glyph->format != FT_GLYPH_FORMAT_BITMAP &&
       FT_Render_Glyph(face->glyph, FT_RENDER_MODE_NORMAL) != 0))
    return std::nullopt;
  return reduced(*face->glyph, *scale);
}

// Joiners, marks of direction, selectors of variants: they say how others look.
bool is_unseen(std::uint32_t c) {
  const auto within = [c](std::uint32_t first, std::uint32_t last) { return c >= first && c <= last; };
  return c == 0xad || within(0x200b, 0x200f) || within(0x202a, 0x202e) || within(0x2060, 0x2064) ||
         within(0x2066, 0x206f) || within(0xfe00, 0xfe0f) || c == 0xfeff || within(0xe0000, 0xe0fff);
}

// 3 x 5 px each, a row three bits.
constexpr std::array<std::uint16_t, 16> kDigits{
    0b111101101101111, 0b010110010010111, 0b111001111100111, 0b111001111001111,
    0b101101111001001, 0b111100111001111, 0b111100111101111, 0b111001010010010,
    0b111101111101111, 0b111101111001111, 0b111101111101101, 0b110101110101110,
    0b111100100100111, 0b110101101101110, 0b111100111100111, 0b111100111100100};

}  // namespace

LetterPicture draw_letter_number(std::uint32_t letter, float size) {
  const std::string digits =
      letter >= kByte ? fmt::format("{:02X}", letter - kByte) : fmt::format("{:04X}", letter);
  const int rows = letter >= kByte ? 1 : 2, columns = (int(digits.size()) + rows - 1) / rows;
  const int unit = std::max(1, int(size / 16));
  LetterPicture picture;
  picture.width = (4 * columns + 3) * unit;
  picture.height = (6 * 2 + 3) * unit;
  picture.top = std::min(picture.height, int(std::lround(kRise * size)));
  picture.advance = float(picture.width + unit);
  picture.covers.assign(std::size_t(picture.width) * std::size_t(picture.height), 0);
  const auto put = [&](int x, int y) {
    for (int v = 0; v < unit; ++v)
      for (int u = 0; u < unit; ++u)
        picture.covers[std::size_t(y * unit + v) * std::size_t(picture.width) + std::size_t(x * unit + u)] =
            255;
  };
  const int wide = picture.width / unit, high = picture.height / unit;
  for (int x = 0; x < wide; ++x) put(x, 0), put(x, high - 1);
  for (int y = 0; y < high; ++y) put(0, y), put(wide - 1, y);
  for (int i = 0; i < int(digits.size()); ++i) {
    const char digit = digits[std::size_t(i)];
    const std::uint16_t shape = kDigits[std::size_t(digit <= '9' ? digit - '0' : digit - 'A' + 10)];
    for (int k = 0; k < 15; ++k)
      if (shape >> (14 - k) & 1)
        put(2 + 4 * (i % columns) + k % 3, (rows == 1 ? 5 : 2 + 6 * (i / columns)) + k / 3);
  }
  return picture;
}

LetterPicture draw_letter(std::uint32_t letter, float size) {
  if (is_unseen(letter)) return {};
  if (letter < kByte)
    if (auto picture = from_system(letter, size)) return *std::move(picture);
  return draw_letter_number(letter, size);
}

}  // namespace likeness::ui
