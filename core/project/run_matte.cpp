// The mattes of a project's clip: see stage_run.h.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "core/base/files.h"
#include "core/project/corrections.h"
#include "core/project/kept_decoding.h"
#include "core/project/make_mattes.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/stage_run.h"
#include "core/project/staleness.h"

namespace likeness {

Result<void> run_matte(const StageContext& context) {
  const auto read = read_tracked_capture(context.project);
  if (!read) return read.error();
  const auto model = head_model_at(context.inputs.matte.head_model);
  if (!model) return model.error();
  if (const auto fits = check_track_fits(read->track, *model); !fits) return fits.error();
  constexpr int kMatteParts = 1;  // raised when what is kept of a frame is made otherwise
  const auto kept = std::make_shared<KeptWork>(
      decoded_path(context.project) / "mattes.kept",
      fmt::format("mattes {} {}", kMatteParts, input_hash(context.project, Stage::matte)));
  const auto matte = make_mattes(context.project, context.inputs.matte, context.project.folder, *read, *model,
                                 context.progress, context.stop, kept);
  if (!matte) return matte.error();
  context.record.message =
      matte->has_plate ? fmt::format("Background plate, {:.0f} % of it seen.", 100 * matte->plate_coverage)
                       : "No background plate: the camera moves throughout.";
  if (path_exists(room_path(context.project)))
    context.record.message += " The room behind the moving camera was learnt.";
  const MatteReport& report = matte->report;
  if (report.prior == MaskPrior::person_network)
    context.record.message += fmt::format(" The person network was used in {:.0f} % of the frames.",
                                          100.0 * report.prior_frames / std::max(1, report.frames));
  if (report.prior == MaskPrior::clip) context.record.message += " The clip's own mask was taken.";
  if (const std::size_t painted = corrected_frames(context.project).size(); painted > 0)
    context.record.message +=
        fmt::format(" Corrected by hand in {} frame{}.", painted, painted == 1 ? "" : "s");
  context.record.warnings = matte->warnings;
  return {};
}

}  // namespace likeness
