// See build_forecast.h.
#include "core/project/build_forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <system_error>
#include <utility>

#include "core/base/memory.h"
#include "core/capture/capture.h"
#include "core/project/stage_inputs.h"
#include "core/project/training_options.h"
#include "core/train/memory_forecast.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// From one clip of 400 frames of 512 px, built at 512 px with two threads of a cloud server's processor
// (import 7.5 s, align 7.8, fit 79, matte 16); a desktop's are up to twice as fast, so the forecast is too
// long rather than too short. A stage's seconds grow with the frames; those of import, align and matte also
// with the pixels they read, and how they divide between the two is estimated.
constexpr double kImportFrame_s = 0.013, kImportMegapixel_s = 0.022;
constexpr double kAlignFrame_s = 0.015, kAlignMegapixel_s = 0.018;
constexpr double kFit_s = 6, kFitFrame_s = 0.2;
constexpr double kMatteFrame_s = 0.02, kMatteMegapixel_s = 0.08;
constexpr double kMovingFrame_s = 0.5;  // more for align, if COLMAP has to find the path of the camera
constexpr double kTrainOpening_s = 4;   // reading pictures, making lattices, writing the avatar
constexpr double kStep_s = 0.16;        // of training by steps instead of a budget
constexpr int kMeasuredThreads = 2, kMaxThreads = 8;  // more gain little: one thread reads the clip

// A PNG of a filmed face takes 0.6 (a calm wall) to 1.6 (leaves, noise) bytes per pixel, a matte a twentieth.
constexpr double kFrameByte = 1.7, kMaskByte = 0.06;
constexpr double kTrackFrame = 9000;           // bytes of track.json, capture.json and cameras.json
constexpr double kAvatarAndCheckpoint = 60e6;  // bytes; two fields, the checkpoint with Adam's two moments

// Fitting keeps one grey picture of at most this side per frame, and its patches and tracks.
constexpr double kGreySide = 512, kFitFrame = 60e3, kProgram = 250e6;

double gigabytes(std::uint64_t bytes) { return double(bytes) / 1e9; }

// How many frames are read: of a fast or long clip only every few.
int clip_frames(const VideoInfo& clip, const ClipSeconds& seconds) {
  int all = clip.frame_count > 0 ? clip.frame_count
                                 : int(std::lround(std::max(0.0, clip.duration_s * clip.frames_per_second)));
  if (!seconds.whole())
    all = std::min(all, int(std::lround(length_within(seconds, clip.duration_s) * clip.frames_per_second)));
  const int stride = std::max(1, sampling_stride(clip));
  return (all + stride - 1) / stride;
}

fs::path nearest_folder(fs::path path) {
  std::error_code ignored;
  path = fs::absolute(path, ignored);
  while (!fs::exists(path, ignored) && path.has_relative_path()) path = path.parent_path();
  return path;
}

}  // namespace

double BuildForecast::total_seconds() const { return std::accumulate(seconds.begin(), seconds.end(), 0.0); }

BuildForecast forecast_build(const VideoInfo& clip, const ProjectOptions& options, const HeadModel& model,
                             int threads) {
  const StageInputs inputs = stage_inputs(options);
  const ImportOptions import;
  BuildForecast forecast;
  forecast.frames = clip_frames(clip, inputs.import.choices.seconds);
  const double frames = forecast.frames, source = double(clip.width) * clip.height / 1e6,
               picture = double(inputs.import.choices.size) * inputs.import.choices.size;
  const double trained = std::min((1 - import.held_out_share) * frames, double(import.max_frames)),
               kept = trained + import.held_out_share * frames;
  const double slower = double(kMeasuredThreads) / std::clamp(threads, 1, kMaxThreads);
  const auto seconds = [&](Stage stage) -> double& { return forecast.seconds[std::size_t(stage)]; };
  seconds(Stage::import) = slower * frames * (kImportFrame_s + kImportMegapixel_s * source);
  seconds(Stage::align) = slower * frames * (kAlignFrame_s + kAlignMegapixel_s * source);
  seconds(Stage::fit) = slower * (kFit_s + kFitFrame_s * frames);
  seconds(Stage::matte) = slower * kept * (kMatteFrame_s + kMatteMegapixel_s * picture / 1e6);
  seconds(Stage::train) = kTrainOpening_s + (inputs.train.choices.steps > 0
                                                 ? slower * kStep_s * double(inputs.train.choices.steps)
                                                 : inputs.train.choices.budget_s);
  forecast.seconds_if_moving = slower * kMovingFrame_s * frames;

  forecast.disk =
      std::uint64_t(kept * picture * (kFrameByte + kMaskByte) + frames * kTrackFrame + kAvatarAndCheckpoint);
  const auto training =
      forecast_memory(std::size_t(trained), inputs.import.choices.size, model, training_options(inputs.train))
          .total();
  const auto fitting = std::uint64_t(kProgram + frames * (kGreySide * kGreySide + kFitFrame));
  forecast.memory = std::max(training, fitting);
  return forecast;
}

void add_further_clip(const VideoInfo& clip, const ProjectOptions& options, const HeadModel& model,
                      int threads, BuildForecast& forecast) {
  const BuildForecast further = forecast_build(clip, options, model, threads);
  forecast.frames += further.frames;
  forecast.disk += further.disk - std::uint64_t(kAvatarAndCheckpoint);
  for (const Stage stage : kStages)
    if (stage != Stage::train) forecast.seconds[std::size_t(stage)] += further.seconds[std::size_t(stage)];
  forecast.seconds_if_moving += further.seconds_if_moving;
  const StageInputs inputs = stage_inputs(options);
  const auto training = forecast_memory(std::size_t(forecast.frames), inputs.import.choices.size, model,
                                        training_options(inputs.train))
                            .total();
  forecast.memory = std::max({forecast.memory, further.memory, training});
}

Resources free_resources(const fs::path& project) {
  Resources free;
  std::error_code failure;
  const fs::space_info space = fs::space(nearest_folder(project), failure);
  if (!failure) free.disk = space.available;
  free.memory = available_memory();
  return free;
}

Result<void> check_forecast(const BuildForecast& forecast, const Resources& free, std::uint64_t held) {
  const std::uint64_t disk = forecast.disk > held ? forecast.disk - held : 0;
  if (free.disk && disk > *free.disk)
    return Error{
        ErrorCode::no_space,
        fmt::format("The project will take about {:.1f} GB more of the disk, and {:.1f} GB are free.",
                    gigabytes(disk), gigabytes(*free.disk)),
        "Free some of the disk, make smaller pictures, or use a shorter clip.", ""};
  if (free.memory && forecast.memory > *free.memory)
    return Error{ErrorCode::failed,
                 fmt::format("The avatar will take about {:.1f} GB of memory, and {:.1f} GB are free.",
                             gigabytes(forecast.memory), gigabytes(*free.memory)),
                 "Close other programs, make smaller pictures, or use a shorter clip.", ""};
  return {};
}

std::optional<int> smaller_size(const VideoInfo& clip, const ProjectOptions& options, const HeadModel& model,
                                int threads, const Resources& free) {
  if (check_forecast(forecast_build(clip, options, model, threads), free)) return std::nullopt;
  for (const int size : {512, 256}) {
    if (size >= options.import.size) continue;
    ProjectOptions smaller = options;
    smaller.import.size = size;
    if (check_forecast(forecast_build(clip, smaller, model, threads), free)) return size;
  }
  return std::nullopt;
}

std::uint64_t folder_bytes(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code failure;
  for (fs::recursive_directory_iterator it(folder, failure), end; !failure && it != end;
       it.increment(failure)) {
    std::error_code ignored;
    if (!it->is_symlink(ignored) && it->is_regular_file(ignored)) bytes += it->file_size(ignored);
  }
  return bytes;
}

std::string forecast_words(const BuildForecast& forecast) {
  return fmt::format("about {:.0f} min, {:.1f} GB of the disk and {:.1f} GB of memory",
                     std::max(1.0, std::ceil(forecast.total_seconds() / 60)), gigabytes(forecast.disk),
                     gigabytes(forecast.memory));
}

}  // namespace likeness
