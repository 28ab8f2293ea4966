// Pictures of letters that the window's own font lacks: from the system's fonts, by FreeType; of what none of
// them has, its number in a frame, so that two names that differ look different.
#pragma once

#include <cstdint>
#include <vector>

namespace likeness::ui {

struct LetterPicture {
  int width = 0, height = 0;         // px; 0: nothing is seen of it
  int left = 0, top = 0;             // of the picture from the pen, and above the line that letters stand on
  float advance = 0;                 // of the pen
  std::vector<std::uint8_t> covers;  // width * height, 0..255
};

// letter: letter_meant() (letters.h). size: of the font, px of a line. On the window's thread.
LetterPicture draw_letter(std::uint32_t letter, float size);
// The last resort.
LetterPicture draw_letter_number(std::uint32_t letter, float size);

}  // namespace likeness::ui
