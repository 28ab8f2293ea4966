// The names that a project's folder has of Likeness, and what may stand there: its own files and folders,
// never a link. A project comes from anywhere - a share, an archive, another person - and a link in it would
// lead what is removed or written out of its folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/result.h"

namespace likeness {

inline constexpr const char* kComparisonFolder = "comparison";
// Held while somebody works on the project, and while a window shows it (core/project/window_lock.h).
inline constexpr const char* kWorkLock = ".lock";
inline constexpr const char* kWindowLock = ".window";
bool is_lock_name(const std::string& name);

// Apart from performances and what was painted.
bool is_project_name(const std::string& name);
// performance.json, and what was saved beside it.
bool is_performance(const std::string& name);

// Whether a project's folder of this name holds strokes, those that were set aside too.
bool is_corrections_folder(const std::string& name);
// Whether a project's file of this name holds attributes, set aside or not.
bool is_attributes_file(const std::string& name);

bool is_link(const std::filesystem::path& path);

// A link in the place of one of the project's names, further clips' included; deep: or of anything within
// them, as whoever writes asks.
std::optional<std::filesystem::path> link_within(const std::filesystem::path& folder, bool deep);
// That there is none; else an Error that says where it leads.
Result<void> check_no_links(const std::filesystem::path& folder, bool deep);

}  // namespace likeness
