// A project shows a person's face from all sides: nobody else on the machine reads it unless its owner says
// so.
#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace likeness {

// Makes the project's folder, its owner's alone (mode 0700); one that is there stays as it is. What Likeness
// writes into it follows it (core/base/files.cpp), but for exports/, which are made to be given away.
Result<void> make_project_folder(const std::filesystem::path& folder);

// The same of what libraries and other programs wrote into a folder that is its owner's alone.
void keep_private(const std::filesystem::path& folder);

}  // namespace likeness
