// What is wrong with a video that cannot be opened, or not be read to its end, and what to do. Internal to
// core/video, as frame_to_rgb.h.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace likeness {

// Of fewer frames before a fault nothing can be made; more are used, and the film ends with them.
inline constexpr int kFewestBeforeFault = 30;

// How far a film could be read.
struct ReadSoFar {
  int frames = 0;
  int expected = 0;   // of all of it, about; no more than `frames`: not known
  double last_s = 0;  // time of the last of them
};

Result<void> check_is_video_file(const std::filesystem::path& path);
Error bad_video(const std::filesystem::path& path, std::string what, std::string fix);
// A file that ends too early, of any sort.
Error incomplete_video(const std::filesystem::path& path, std::string what);
Error cannot_open_video(const std::filesystem::path& path, int av_error);
Error cut_short_error(const std::filesystem::path& path, const ReadSoFar& read);
Error damaged_error(const std::filesystem::path& path, const ReadSoFar& read);

}  // namespace likeness
