// The cameras of a project's clip: see stage_run.h.
#include <filesystem>
#include <system_error>

#include "core/camera/align.h"
#include "core/camera/kept_path.h"
#include "core/capture/capture.h"
#include "core/matte/coarse_mask.h"
#include "core/project/kept_decoding.h"
#include "core/project/stage_run.h"

namespace likeness {

namespace fs = std::filesystem;

Result<void> run_align(const StageContext& context) {
  const AlignInputs& inputs = context.inputs.align;
  AlignOptions options;
  options.seed = int(inputs.seed);
  options.resting = inputs.choices.resting_camera;
  options.lens_mm = inputs.choices.lens_mm;
  options.kept = decoded_path(context.project);
  options.mask_inputs = mask_inputs(inputs.landmark_model);
  // A project from before cuts were found is one shot.
  if (const auto capture = read_capture(capture_path(context.project)))
    options.stretches = stretches_that_serve(*capture);
  std::error_code ignored;
  const bool photographs = fs::is_directory(inputs.video, ignored) && !options.resting;
  const auto person =
      coarse_person_mask(inputs.landmark_model, photographs ? Pictures::single : Pictures::in_sequence);
  if (!person) return person.error();
  const auto align = photographs ? align_photos : align_clip;
  const auto aligned = align(inputs.video, *person, context.project.folder / "colmap", options,
                             context.progress, context.stop);
  if (!aligned) return aligned.error();
  context.record.message = aligned->evidence;
  context.record.warnings = aligned->warnings;
  if (options.lens_mm > 0 && !aligned->cameras.is_static)
    context.record.warnings.push_back(
        "The camera moves, so its lens was found together with its path; the one given by --lens is not "
        "used.");
  const auto written = write_cameras(cameras_path(context.project), aligned->cameras);
  if (written) drop_path_pictures(options.kept);
  return written;
}

}  // namespace likeness
