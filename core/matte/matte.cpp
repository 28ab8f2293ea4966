// The matte stage: the person network's shares -> samples -> plate and colour statistics in three rounds ->
// for a moving camera the room, and the rounds again -> cuts of every frame -> the room again -> a look
// back at plate and room -> alpha -> frozen regions.
#include "core/matte/matte.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/files.h"
#include "core/base/kept_work.h"
#include "core/matte/cut_frames.h"
#include "core/matte/judge_background.h"
#include "core/matte/replace_folder.h"
#include "core/matte/see_persons.h"
#include "core/matte/write_mattes.h"

namespace likeness {

namespace fs = std::filesystem;

namespace matting {
namespace {

constexpr int kCutSide =
    256;  // px at which person and background are separated; the edge is done at full size

// What was learnt of the background, beside the frames. It changes no mask and no plate: held-out frames have
// their say here.
Result<void> look_back(Stage& stage, const std::vector<Job>& jobs, const Cuts& cuts,
                       const Statistics& statistics, MatteResult& result) {
  MatteReport& report = result.report;
  const bool own = std::ranges::any_of(jobs, &Job::own_mask);
  report.prior = own                    ? MaskPrior::clip
                 : stage.network        ? MaskPrior::matting_network
                 : stage.person_network ? MaskPrior::person_network
                                        : MaskPrior::none;
  report.frames = int(jobs.size()), report.prior_frames = cuts.by_prior;
  if (auto judged = judge_background(stage, jobs, cuts.persons, statistics, report); !judged) return judged;
  const auto plate = look_back_at_plate(stage, jobs, cuts.persons, statistics);
  if (!plate) return plate.error();
  report.plate_look_back = *plate;
  for (std::string warning :
       {look_back_warning(report, stage.cameras.kind), plate_fault(report), room_fault(report)})
    if (!warning.empty()) result.warnings.push_back(std::move(warning));
  return {};
}

// Those that a killed run wrote from the same cuts stay.
Result<fs::path> unfinished_masks(const Stage& stage) {
  const fs::path folder = stage.folder / "masks.part";
  if (stage.kept && stage.kept->find("edges"))
    if (auto there = make_writable_folder(folder); there) {
      remove_abandoned_parts(folder);
      return folder;
    }
  auto fresh = fresh_folder(folder);
  if (fresh && stage.kept) stage.kept->keep("edges", {});
  return fresh;
}

Result<MatteResult> run(Stage& stage, const LearnRoom& learn_room, const Progress& progress) {
  std::vector<Job> jobs = list_jobs(stage);
  const auto trains = std::count_if(jobs.begin(), jobs.end(), [](const Job& job) { return job.trains; });
  if (trains == 0)
    return Error{ErrorCode::failed, "No training frame has both a camera and a tracked head.",
                 "See the warnings of the camera and track stages, and film again if they say so.", "matte"};
  mark_rest(stage, jobs);
  choose_mosaic(stage, jobs);
  if (auto seen = see_persons(stage, jobs, progress.stage(0, 0.05, "person")); !seen) return seen.error();
  auto statistics = learn_in_rounds(stage, jobs, progress.stage(0.05, 0.15, "background"));
  if (!statistics) return statistics.error();
  if (learn_room) {
    auto room = room_behind(stage, jobs, *statistics, learn_room, progress.stage(0.15, 0.2, "room"));
    if (!room) return room.error();
    stage.room = std::move(*room);
    if (stage.room) statistics = learn_in_rounds(stage, jobs, progress.stage(0.2, 0.25, "background"));
    if (!statistics) return statistics.error();
  }
  const auto cuts = cut_all(stage, "cut", jobs, *statistics, progress.stage(0.25, 0.5, "mattes"));
  if (!cuts) return cuts.error();
  if (stage.room)
    if (auto again = learn_room_again(stage, jobs, cuts->persons, learn_room, *statistics,
                                      progress.stage(0.5, 0.75, "room again"));
        !again)
      return again.error();
  MatteResult result;
  if (auto looked = look_back(stage, jobs, *cuts, *statistics, result); !looked) return looked.error();
  const auto masks = unfinished_masks(stage);
  if (!masks) return masks.error();
  if (auto written =
          write_masks(stage, jobs, cuts->persons, *statistics, *masks, progress.stage(0.75, 0.95, "edges"));
      !written)
    return written.error();
  restore_folder(stage.folder / "regions");
  if (!regions_complete(stage))
    if (auto written = write_regions(stage, jobs, *masks, progress.stage(0.95, 1, "regions")); !written)
      return written.error();
  if (auto written = write_plate(stage, jobs, *statistics, result); !written) return written.error();
  if (auto written = write_matte_report(stage.folder / "matte_report.json", result.report); !written)
    return written.error();
  if (auto replaced = replace_folder(*masks, stage.folder / "masks"); !replaced) return replaced.error();
  if (result.has_plate && result.plate_coverage < 0.3)
    result.warnings.push_back(
        fmt::format("Only {:.0f} % of the background is ever seen; the rest of the plate is filled in.",
                    100 * result.plate_coverage));
  progress.report(1);
  return result;
}

}  // namespace
}  // namespace matting

Result<MatteResult> matte_clip(const fs::path& folder, const Capture& capture, const CameraSet& cameras,
                               const Track& track, const HeadModel& model, const MatteOptions& options,
                               const Progress& progress, std::stop_token stop) {
  if (capture.crop.side <= 0 || options.size < 32)
    return Error{ErrorCode::bad_input,
                 fmt::format("A crop of {} px to {} px cannot be matted.", capture.crop.side, options.size),
                 "Run `likeness import` again.", folder.string()};
  std::optional<MattingNetwork> network;
  if (!options.network.empty()) {
    auto loaded = MattingNetwork::load(options.network);
    if (!loaded) return loaded.error();
    network = std::move(*loaded);
  }
  try {
    matting::Stage stage{folder,
                         capture,
                         cameras,
                         track,
                         make_person_model(model, track),
                         options.size,
                         std::min(options.size, matting::kCutSide),
                         network ? &*network : nullptr,
                         network ? nullptr : options.person_network.get(),
                         options.strokes,
                         stop,
                         options.kept.get(),
                         {},
                         {},
                         {}};
    auto result = matting::run(stage, options.learn_room, progress);
    const bool goes_on = !result && result.error().code == ErrorCode::cancelled && options.kept;
    std::error_code ignored;
    if (!goes_on) fs::remove_all(folder / "masks.part", ignored);
    fs::remove_all(folder / "regions.part", ignored);
    if (result && options.kept) options.kept->finish();
    return result;
  } catch (const cv::Exception& fault) {
    return Error{ErrorCode::failed, fmt::format("The mattes could not be made: {}.", fault.what()),
                 "Free some memory and run the same command again.", folder.string()};
  }
}

}  // namespace likeness
