// The built-in head: made by this code alone, so that everything works without a downloaded model.
#pragma once

#include "core/head/head_model.h"

namespace likeness {

// Deterministic; built anew at every call, in about half a second: keep the result.
HeadModel make_builtin_head();

}  // namespace likeness
