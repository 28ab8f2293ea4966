// The visible mark of synthetic pictures.
#pragma once

#include <string_view>

#include "core/image/image.h"

namespace likeness {

inline constexpr std::string_view kMarkText = "synthetic - Likeness";

// Writes the text into the lower left corner, light with a dark rim, about a thirtieth of the picture high
// but no wider than nine tenths of it; opaque where the picture has alpha.
void draw_mark(Image8& picture, std::string_view text = kMarkText);

}  // namespace likeness
