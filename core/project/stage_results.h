// What a stage wrote, and whether it is still that: a file that was cut, altered or replaced since is no
// result.
#pragma once

#include <string>
#include <vector>

#include "core/project/project.h"

namespace likeness {

// Those of its files that are there.
std::vector<std::filesystem::path> result_files(const Project& project, Stage stage);

// The content of its files, and the names of its pictures. Milliseconds.
std::string result_hash(const Project& project, Stage stage);
// The content of its pictures: a second for thousands.
std::string pictures_hash(const Project& project, Stage stage);

// Whether its files can be read at all; of projects from before hashes were kept.
bool results_readable(const Project& project, Stage stage);

// Moves files that are not what the record says out of the way of a new run, so that nothing of them is built
// upon and no edit by hand is lost: NAME.json becomes NAME.changed.json. Returns what was moved.
Result<std::vector<std::string>> set_aside_changed(const Project& project, Stage stage);

}  // namespace likeness
