// What this process is writing under temporary names (files.h), so that a signal that ends it at once leaves
// nothing half-written. Safe from any thread.
#pragma once

#include <filesystem>

namespace likeness {

// In the name of pieces that are a film without an end, too (core/video/finish_film.h): they outlive their
// process.
inline constexpr const char* kRecordingMark = ".recording";

void remember_unfinished(const std::filesystem::path& path);  // a file or a folder
void forget_unfinished(const std::filesystem::path& path);    // it is finished, or gone

// Removes all of it. Who begins or finishes a file afterwards waits for ever: the process is to end now.
void remove_unfinished();

}  // namespace likeness
