// Choices that are kept with the clip, as words of the command line: paths, frames and spans of frames.
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/project/option_table.h"

namespace likeness {

// Changes the row's choice to what the words say; the row's word, mostly "none", takes it back.
//   a path      the path
//   frames      "12,40-60": these
//   spans       "190-204": these beside those there are
// Errors: words that are not a list of frames, with an example for the row's flag.
Result<void> read_option_words(const OptionRow& row, std::string_view words, ProjectOptions& options);

}  // namespace likeness
