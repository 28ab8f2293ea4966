// What a stage wrote, and whether it is still that: a file that was cut, altered or replaced since is no
// result.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/project/project.h"

namespace likeness {

// Those of its files that are there.
std::vector<std::filesystem::path> result_files(const Project& project, Stage stage);

// A hash of each of its files by the file's name, and of its pictures' names by the folder's. Milliseconds.
std::map<std::string, std::string> stage_results(const Project& project, Stage stage);
// The content of its pictures: a second for thousands.
std::string pictures_hash(const Project& project, Stage stage);

// Whether its files can be read at all; of projects from before hashes were kept.
bool results_readable(const Project& project, Stage stage);

// Copies files that are there and not what the record says before a new run writes over them, so that no edit
// by hand is lost: NAME.json to NAME.changed.json, NAME.changed-2.json, ... Returns the copies' names.
Result<std::vector<std::string>> keep_changed(const Project& project, Stage stage);

}  // namespace likeness
