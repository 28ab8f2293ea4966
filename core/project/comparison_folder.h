// Where a project keeps what was compared on it (likeness::study): within, since it holds pictures of the
// person, who can be deleted with all that is theirs (core/project/care.h).
#pragma once

#include <filesystem>

#include "core/project/own_names.h"
#include "core/project/project.h"

namespace likeness {

inline std::filesystem::path comparison_folder(const Project& project) {
  return project.folder / kComparisonFolder;
}

}  // namespace likeness
