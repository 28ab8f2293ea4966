// A project whose project.json cannot be read: what can still be said of it, and its repair.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/project/project.h"

namespace likeness {

struct DamagedProject {
  std::filesystem::path folder;
  Error error;         // why it cannot be opened
  bool newer = false;  // whole, but of a newer Likeness: nothing to repair
  // As far as its project.json and its capture.json still tell; the rest are the defaults.
  ProjectOptions options;
  std::vector<int> further_clips;            // numbers of those whose folders still open
  std::vector<std::filesystem::path> clips;  // that one of the two names and that are there
};

// nullopt: the project opens, or the folder is not one of Likeness's. Many programs have a project.json: it
// is Likeness's where it says so, where the folder is called NAME.likeness, or where Likeness's own files lie
// beside it.
std::optional<DamagedProject> find_damaged_project(const std::filesystem::path& folder);

// Makes the project.json anew from what is in the folder; the damaged one stays as project.damaged.json.
// Every stage counts as to be done again, and nobody's consent is known: what the stages left behind can be
// shown, but is not taken for the result of these options. A project that opens stays as it is. Takes the
// project's lock.
Result<Project> repair_project(const std::filesystem::path& folder);

}  // namespace likeness
