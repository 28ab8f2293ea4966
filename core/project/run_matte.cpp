// The mattes of a project's clip: see stage_run.h.
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/matte/matte.h"
#include "core/matte/person_network.h"
#include "core/project/corrections.h"
#include "core/project/further_clips.h"
#include "core/project/learn_room.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/stage_run.h"

namespace likeness {

namespace fs = std::filesystem;

Result<void> run_matte(const StageContext& context) {
  auto strokes = read_corrections(context.project);
  if (!strokes) return strokes.error();
  const auto read = read_tracked_capture(context.project);
  if (!read) return read.error();
  const auto& [capture, cameras, track] = *read;
  const auto model = head_model_at(context.inputs.matte.head_model);
  if (!model) return model.error();
  if (const auto fits = check_track_fits(track, *model); !fits) return fits.error();
  MatteOptions options;
  options.size = capture.size;
  options.network = context.inputs.matte.choices.matting_network;
  auto person_network = chosen_person_network(context.inputs.matte.person_network);
  if (!person_network) return person_network.error();
  options.person_network = std::move(*person_network);
  options.strokes = std::move(*strokes);
  std::error_code failure;
  fs::remove(room_path(context.project), failure);  // it was learnt from other mattes
  if (!is_further(context.project))
    options.learn_room = room_learner(context.project, context.inputs.matte.seed, *read);
  const auto matte = matte_clip(context.project.folder, capture, cameras, track, *model, options,
                                context.progress, context.stop);
  if (!matte) return matte.error();
  context.record.message =
      matte->has_plate ? fmt::format("Background plate, {:.0f} % of it seen.", 100 * matte->plate_coverage)
                       : "No background plate: the camera moves throughout.";
  if (path_exists(room_path(context.project)))
    context.record.message += " The room behind the moving camera was learnt.";
  if (const std::size_t painted = options.strokes.size(); painted > 0)
    context.record.message +=
        fmt::format(" Corrected by hand in {} frame{}.", painted, painted == 1 ? "" : "s");
  context.record.warnings = matte->warnings;
  return {};
}

}  // namespace likeness
