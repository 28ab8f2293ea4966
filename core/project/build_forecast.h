// What building an avatar will take of disk, memory and minutes, said before it starts, and a smaller plan
// where that is too much.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/project/project.h"
#include "core/video/decode.h"

namespace likeness {

struct BuildForecast {
  int frames = 0;                                // of the clip
  std::uint64_t disk = 0;                        // bytes the project will hold
  std::uint64_t memory = 0;                      // bytes at most, of the hungriest stage
  std::array<double, kStages.size()> seconds{};  // of each stage, where the camera rests
  double seconds_if_moving = 0;                  // more, where the camera moves and its path is to be found
  double total_seconds() const;
};

// threads: that compute.
BuildForecast forecast_build(const VideoInfo& clip, const ProjectOptions& options, const HeadModel& model,
                             int threads);

// With a further clip of the person, of which nothing is held out.
void add_further_clip(const VideoInfo& clip, const ProjectOptions& options, const HeadModel& model,
                      int threads, BuildForecast& forecast);

// What there is of both, where a project is or will be.
struct Resources {
  std::optional<std::uint64_t> disk, memory;  // bytes free; nullopt: the system does not say
};
Resources free_resources(const std::filesystem::path& project);

// Not enough: says of what, how much is needed, and what to do. held: bytes of the forecast that the
// project's folder holds already.
Result<void> check_forecast(const BuildForecast& forecast, const Resources& free, std::uint64_t held = 0);

// The largest smaller picture size whose forecast fits; nullopt where this one fits, or none does.
std::optional<int> smaller_size(const VideoInfo& clip, const ProjectOptions& options, const HeadModel& model,
                                int threads, const Resources& free);

// Bytes of all files in a folder; 0 where there is none.
std::uint64_t folder_bytes(const std::filesystem::path& folder);

// "about 6 min, 0.3 GB on the disk and 1.1 GB of memory"
std::string forecast_words(const BuildForecast& forecast);

}  // namespace likeness
