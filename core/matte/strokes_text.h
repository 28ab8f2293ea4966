// Strokes as a JSON array, for the files that hold strokes. Internal to core/matte.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/matte/strokes.h"

namespace likeness {

std::string strokes_text(std::span<const Stroke> strokes);

// What was read of an array: `damaged` is the number of the first invalid stroke, from 1; 0: all are valid.
struct ReadStrokes {
  Strokes strokes;
  std::size_t damaged = 0;
};
// text: JSON. nullopt if it is not an array of strokes at all.
std::optional<ReadStrokes> strokes_of_text(const std::string& text);

}  // namespace likeness
