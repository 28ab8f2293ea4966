// Checks what dlib's code takes for granted in a shape predictor's file: dlib follows the file's indices
// unchecked and allocates whatever its counts ask for. Internal to core/track.
#pragma once

#include <cstdint>
#include <istream>

#include "core/base/result.h"

namespace likeness {

// in: the file from its start; bytes: its length. Reads all of it and keeps none of it. The error's `what`
// names the fault; its other fields are filled in by the caller.
Result<void> check_predictor(std::istream& in, std::uint64_t bytes);

}  // namespace likeness
