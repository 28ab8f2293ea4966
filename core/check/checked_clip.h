// What the capture check found of a project's clip, kept in the project as check.json: the verdict counts
// until the clip is another or is looked at again, not only until the window is closed.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/base/result.h"
#include "core/check/clip_words.h"
#include "core/check/verdict.h"

namespace likeness {

struct CheckedClip {
  std::string clip_hash;  // of the clip's content, as hash_video's
  CaptureVerdict verdict{};
  ClipFacts facts{};
};

// As check.json and `check --json` list them.
nlohmann::json remarks_json(std::span<const Remark> remarks);

std::filesystem::path checked_clip_path(const std::filesystem::path& project);  // the project's folder

Result<void> write_checked_clip(const std::filesystem::path& path, const CheckedClip& checked);
// An Error where there is none, it cannot be read, or another version's check made it.
Result<CheckedClip> read_checked_clip(const std::filesystem::path& path);

}  // namespace likeness
