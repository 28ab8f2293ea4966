// A folder in the desktop's own file manager.
#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace likeness::ui {

// Asks the desktop to show the folder, by `xdg-open`, and does not wait for what it opens: it goes on when
// this program ends. Fails where there is no such folder or no such program.
Result<void> show_folder(const std::filesystem::path& folder);

}  // namespace likeness::ui
