// The cameras of a project's clip: see stage_run.h.
#include <filesystem>
#include <system_error>
#include <vector>

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
  options.kind = inputs.choices.camera;
  options.lens_mm = inputs.choices.lens_mm;
  options.kept = decoded_path(context.project);
  options.mask_inputs = mask_inputs(inputs);
  std::vector<ClipShot> shots;  // of a film that was cut, or of which some seconds were read
  std::error_code ignored;
  const bool photographs = fs::is_directory(inputs.video, ignored) && options.kind != CameraKind::resting;
  if (const auto capture = read_capture(capture_path(context.project))) {
    options.held_out = silent_frames(*capture), options.film = capture->film;
    options.stretches = stretches_that_serve(*capture), options.shots = spans_where_cut(*capture);
    if (capture->shots.size() > 1 || !capture->seconds.whole()) shots = capture->shots;
  }
  const auto person = coarse_person_mask(
      inputs.landmark_model, photographs ? Pictures::single : Pictures::in_sequence, inputs.person_network);
  if (!person) return person.error();
  const auto align = photographs ? align_photos : align_clip;
  auto aligned = align(inputs.video, *person, context.project.folder / "colmap", options, context.progress,
                       context.stop);
  if (!aligned) return aligned.error();
  if (!shots.empty()) aligned->cameras.shots.clear();
  for (const ClipShot& shot : shots)
    if (shot.used) aligned->cameras.shots.push_back({shot.from_s, shot.to_s, aligned->cameras.kind});
  context.record.message = aligned->evidence;
  context.record.warnings = aligned->warnings;
  if (options.lens_mm > 0 && aligned->cameras.kind == CameraKind::walking)
    context.record.warnings.push_back(
        "The camera walks, so its lens was found together with its path; the one given by --lens is not "
        "used.");
  const auto written = write_cameras(cameras_path(context.project), aligned->cameras);
  if (written) drop_path_pictures(options.kept);
  return written;
}

}  // namespace likeness
