// Whether a file of dlib's shape predictor keeps what dlib's code takes for granted: it follows a file's
// indices without a look and takes the memory that a file's counts ask for. Internal to core/track.
#pragma once

#include <cstdint>
#include <istream>

#include "core/base/result.h"

namespace likeness {

// in: the file from its start; bytes: its length. Reads all of it and keeps none of it. The error's `what`
// tells the fault; its other fields are the caller's.
Result<void> check_predictor(std::istream& in, std::uint64_t bytes);

}  // namespace likeness
