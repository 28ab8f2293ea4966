// What a question about a failure needs to be answered: figures and messages, no picture.
#pragma once

#include <optional>
#include <string>

#include "ui/studio/project_contents.h"

namespace likeness::ui {

// A line a fact. error: the last one that was shown; contents: null where no project is open.
std::string diagnostics_text(const std::optional<Error>& error, const ProjectContents* contents);

}  // namespace likeness::ui
