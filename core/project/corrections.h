// The strokes painted on a project's masks: corrections/NNNNNN.json, a file for each frame that has any. The
// matte stage takes them as certain; its result is stale as soon as they are others.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/matte/strokes.h"
#include "core/project/project.h"

namespace likeness {

std::filesystem::path strokes_path(const Project& project, int frame);  // absent: none

// The frames that have strokes, ascending, whether or not their files can be read.
std::vector<int> corrected_frames(const Project& project);

// All strokes. The first file that cannot be read is the error: masks are not made from half of what somebody
// painted.
Result<FrameStrokes> read_corrections(const Project& project);

// The files' content as one hash; empty without strokes.
std::string corrections_hash(const Project& project);

// Writes a frame's strokes, whole or not at all. No strokes: the file goes, and the folder with the last one,
// so that taking back what was painted makes the project as it was.
Result<void> save_corrections(const Project& project, int frame, const Strokes& strokes);

// Renames a frame's file, which cannot be read, so that strokes can be painted anew: NNNNNN.damaged.json, or
// with a number. Returns its new place.
Result<std::filesystem::path> set_aside_strokes(const Project& project, int frame);

// Renames the whole folder to corrections.old, or with a number. Returns its new place.
Result<std::filesystem::path> set_aside_corrections(const Project& project);

}  // namespace likeness
