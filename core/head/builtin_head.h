// The built-in head: made entirely by this code, so that everything works without a downloaded model.
#pragma once

#include <string>
#include <vector>

#include "core/head/head_model.h"

namespace likeness {

// Deterministic; built afresh at every call, in about half a second: keep the result.
HeadModel make_builtin_head();

// What its identity directions mean, in their order: "jaw_width", "nose_length", ...
std::vector<std::string> builtin_identity_names();

}  // namespace likeness
