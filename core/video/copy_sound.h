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

// Adds the sound of `from` to the mp4 `film`, which is replaced whole or not at all: the default track of
// those that mp4 can hold. from_s: the time of the clip's pictures at which the film begins; the sound ends
// with the film. A clip without sound, or with kinds that mp4 cannot hold, leaves the film unchanged.
Result<CopiedSound> copy_sound(const std::filesystem::path& from, const std::filesystem::path& film,
                               double from_s = 0);

}  // namespace likeness
