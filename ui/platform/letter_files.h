// Which of the system's fonts has a letter, by fontconfig.
#pragma once

#include <optional>
#include <string>

namespace likeness::ui {

struct LetterFile {
  std::string path;
  int face = 0;  // in a collection
  bool operator==(const LetterFile&) const = default;
};

// The font that the system prefers for running text among those with this letter; nullopt: none has it. The
// first call reads the list of fonts, a tenth of a second or so. On the window's thread.
std::optional<LetterFile> file_of_letter(char32_t letter);

}  // namespace likeness::ui
