// See mask_picture.h.
#include "ui/studio/mask_picture.h"

#include <algorithm>
#include <cmath>

#include "core/capture/capture.h"
#include "core/image/files.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

using Ink = std::array<std::uint8_t, 3>;

constexpr int kMinSide = 768;  // px of what is drawn
constexpr Ink kTint{38, 66, 190}, kOutline{255, 206, 64};
constexpr float kTintShare = 0.5f;

void mix(std::uint8_t* pixel, const Ink& ink, float share) {
  for (std::size_t c = 0; c < 3; ++c)
    pixel[c] = std::uint8_t(std::lround(float(pixel[c]) * (1 - share) + float(ink[c]) * share));
}

// How much of a pixel the outline covers: alpha's distance from one half, divided by its slope.
float outline_share(const Image8& alpha, int x, int y) {
  const auto at = [&](int u, int v) {
    return float(*alpha.at(std::clamp(u, 0, alpha.width - 1), std::clamp(v, 0, alpha.height - 1)));
  };
  const float slope = 0.5f * std::hypot(at(x + 1, y) - at(x - 1, y), at(x, y + 1) - at(x, y - 1));
  if (slope < 4) return 0;  // of 255 per pixel: no edge
  return std::clamp(2.0f - std::abs(at(x, y) - 127.5f) / slope, 0.0f, 1.0f);
}

Ink chequer(int x, int y, int side) {
  const bool light = (x * 32 / side + y * 32 / side) % 2;
  return light ? Ink{214, 214, 214} : Ink{166, 166, 166};
}

void draw_over_picture(Image8& picture, const Image8& alpha, const StrokeCover& cover, bool attribute) {
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      std::uint8_t* pixel = picture.at(x, y);
      if (!attribute) mix(pixel, kTint, kTintShare * (1 - float(*alpha.at(x, y)) / 255));
      if (!cover.empty()) {
        mix(pixel, stroke_ink(StrokeMark::person), kStrokeShare * *cover.person.at(x, y));
        mix(pixel, stroke_ink(StrokeMark::background), kStrokeShare * *cover.background.at(x, y));
      }
      if (!attribute) mix(pixel, kOutline, outline_share(alpha, x, y));
    }
}

}  // namespace

std::array<std::uint8_t, 3> stroke_ink(StrokeMark mark) {
  return mark == StrokeMark::person       ? Ink{60, 220, 110}
         : mark == StrokeMark::background ? Ink{240, 70, 160}
                                          : Ink{240, 240, 240};
}

Result<MaskSource> read_mask_source(const fs::path& folder, int frame) {
  auto rgb = read_image(folder / frame_name(frame));
  if (!rgb || rgb->channels != 3)
    return Error{ErrorCode::not_found, "No picture of this frame was kept.", "", ""};
  auto alpha = read_image(folder / "masks" / frame_name(frame).filename());
  if (!alpha || alpha->channels != 1 || alpha->width != alpha->height)
    return Error{ErrorCode::not_found, "No mask of this frame has been made yet.", "", ""};
  return MaskSource{frame, std::move(*rgb), std::move(*alpha)};
}

Image8 draw_mask(const MaskSource& source, std::span<const Stroke> strokes, const SquareCrop& crop,
                 MaskLook look, bool attribute) {
  const int side = std::max(kMinSide, source.rgb.width);
  Image8 picture = resize(source.rgb, side, side), alpha = resize(source.alpha, side, side);
  const StrokeCover cover = cover_strokes(strokes, crop, side);
  if (!attribute) apply_strokes(cover, alpha);
  if (look == MaskLook::picture) {
    draw_over_picture(picture, alpha, cover, attribute);
    return picture;
  }
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const std::uint8_t a = *alpha.at(x, y);
      if (look == MaskLook::matte)
        std::fill_n(picture.at(x, y), 3, a);
      else
        mix(picture.at(x, y), chequer(x, y, side), 1 - float(a) / 255);
    }
  return picture;
}

Result<Image8> draw_plate(const fs::path& folder) {
  const auto plate = read_image(folder / "plate.png");
  if (!plate || plate->channels != 3)
    return Error{ErrorCode::not_found,
                 "There is no background plate: it takes a camera that rests for a second or longer.", "",
                 ""};
  const int side = std::max(kMinSide, plate->width);
  Image8 picture = resize(*plate, side, side);
  const auto known = read_image(folder / "plate_known.png");  // absent: the whole of it was seen
  if (!known || known->channels != 1 || known->width != plate->width) return picture;
  const Image8 seen = resize(*known, side, side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const bool hatched = (x + y) * 48 / side % 2 == 0;
      if (*seen.at(x, y) < 64 && hatched) mix(picture.at(x, y), kTint, kTintShare);
    }
  return picture;
}

}  // namespace likeness::ui
