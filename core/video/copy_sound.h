// The sound of one clip beside the pictures of another, copied as it is.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace likeness {

struct CopiedSound {
  bool copied = false;
  std::string why_not;  // in words, when the sound was left out
};

// Adds the first sound track of `from` to the mp4 `film`, which is replaced whole or not at all; the sound
// ends with the pictures. A clip without sound, or with a kind that mp4 cannot hold, leaves the film
// unchanged.
Result<CopiedSound> copy_sound(const std::filesystem::path& from, const std::filesystem::path& film);

}  // namespace likeness
