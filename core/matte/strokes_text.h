// Strokes as a JSON array, for the files that hold some. Internal to core/matte.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/matte/strokes.h"

namespace likeness {

std::string strokes_text(std::span<const Stroke> strokes);

// What was read of an array: `damaged` is the number of the first stroke that is none, from 1; 0: all are.
struct ReadStrokes {
  Strokes strokes;
  std::size_t damaged = 0;
};
// text: JSON. Nothing where it is no array of strokes at all.
std::optional<ReadStrokes> strokes_of_text(const std::string& text);

}  // namespace likeness
