// The head model that a project uses.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/project/project.h"

namespace likeness {

Result<HeadModel> project_head_model(const ProjectOptions& options);
// The same by its file or folder; empty: the built-in head.
Result<HeadModel> head_model_at(const std::filesystem::path& path);

}  // namespace likeness
