// Pictures of a frame's mask, with the strokes painted on it, for the window to show.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/result.h"
#include "core/image/image.h"
#include "core/matte/strokes.h"

namespace likeness::ui {

enum class MaskLook {
  picture,  // the background tinted, the outline drawn, strokes in their colours
  matte,    // white the person, black the background
  cut_out,  // the person before a chequered ground
  plate     // the background alone, hatched where nobody saw it
};

// What a mask's picture is made of: (size, size, 3) and (size, size, 1).
struct MaskSource {
  int frame = -1;
  Image8 rgb, alpha;
};
// Of a project's folder. Errors are one sentence for the place of the picture.
Result<MaskSource> read_mask_source(const std::filesystem::path& folder, int frame);

// attribute: the strokes say where an attribute is; the mask itself stays, and its background is not tinted.
// Large enough that outline and strokes are smooth. The matte is shown as its strokes change it at once; the
// cut about them is made by the matte stage. look: any but the plate.
Image8 draw_mask(const MaskSource& source, std::span<const Stroke> strokes, const SquareCrop& crop,
                 MaskLook look, bool attribute = false);
Result<Image8> draw_plate(const std::filesystem::path& folder);

// The colour a stroke is drawn in, sRGB.
std::array<std::uint8_t, 3> stroke_ink(StrokeMark mark);
inline constexpr float kStrokeShare = 0.45f;  // how much of it covers the picture

}  // namespace likeness::ui
