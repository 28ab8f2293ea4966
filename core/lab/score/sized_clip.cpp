// Reading and resizing a clip.
#include "core/lab/score/sized_clip.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/base/hash.h"
#include "core/base/parallel.h"
#include "core/image/files.h"
#include "core/matte/plate_file.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/training_set.h"
#include "core/train/exposure.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

std::string content_of(const Project& project, const HeadModel& model) {
  std::string text = model.hash + project.record(Stage::matte).input_hash;
  for (const fs::path& path : {capture_path(project), cameras_path(project), track_path(project),
                               plate_path(project), plate_known_path(project), plate_info_path(project)}) {
    const auto hash = hash_file(path);
    text += hash ? *hash : "absent";
  }
  if (const auto hash = hash_file(detail_path(project))) text += *hash;  // most projects have none
  return hash_text(fmt::format("{} {}", text, fmt::join(project.options.train.left_out, ",")));
}

Image8 fitted(const Image8& image, int size) {
  return image.empty() || image.width == size ? image : resize(image, size, size);
}

}  // namespace

TrainingSet resized(TrainingSet set, int size) {
  if (size == set.size) return set;
  parallel_for(set.views.size(), [&](std::size_t v) {
    TrainingView& view = set.views[v];
    view.camera = resized(view.camera, size);
    view.rgb = fitted(view.rgb, size);
    view.alpha = TiledMask(fitted(to_image(view.alpha), size));
    if (view.inside.empty()) return;
    view.inside = resampled(view.inside, set.size, size);
    Image8 teaches = fitted(to_image(view.teaches), size);
    fill_outside(teaches, view.inside, 0);
    view.teaches = TiledMask(teaches);
  });
  if (!set.plate_camera) {  // a view of any size sees a mosaic as it is
    set.plate = fitted(set.plate, size);
    set.plate_known = fitted(set.plate_known, size);
  }
  set.size = size;
  return set;
}

std::vector<std::size_t> evenly_chosen(std::size_t count, std::size_t most) {
  if (most == 0 || most > count) most = count;
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < most; ++k) chosen.push_back(k * count / most);
  return chosen;
}

Result<SizedClip> read_sized_clip(const Project& project, int size) {
  if (std::error_code ignored; !fs::is_directory(regions_path(project), ignored))
    return Error{ErrorCode::not_found,
                 fmt::format("{} has no evaluation regions yet.", project.folder.string()),
                 fmt::format("Run: likeness fit {}", project.folder.string()), project.folder.string()};
  const auto model = project_head_model(project.options);
  if (!model) return model.error();
  auto read = read_tracked_capture(project);
  if (!read) return read.error();
  auto& [capture, cameras, track] = *read;
  const auto plate_info = read_plate_info(plate_info_path(project));
  if (!plate_info) return plate_info.error();
  Project one = project;
  one.further_clips.clear();  // the models compared are trained on one clip
  auto set = load_training_set(one, *model);
  if (!set) return set.error();
  const int clip_size = capture.size;
  if (size == 0) size = clip_size;
  // Cameras and regions are then of this size.
  capture.inside = resampled(capture.inside, capture.size, size);
  capture.size = size;

  SizedClip clip;
  clip.content = content_of(project, *model);
  clip.set = resized(std::move(*set), size);
  for (const int frame : held_out_frames(capture)) {
    const TrackedFrame* tracked = find_tracked(track, frame);
    const auto camera = filmed_camera(capture, cameras, track, frame);
    if (tracked == nullptr || tracked->status == FrameStatus::lost || !camera) {
      ++clip.lost;
      continue;
    }
    const auto truth =
        read_own_picture(project.folder / "frames", fmt::format("{:06}.png", frame), clip_size, 3);
    if (!truth) return truth.error();
    auto regions = read_regions(regions_path(project), capture, frame);
    if (!regions) return regions.error();
    TrainingView view{.camera = *camera};
    view.has_plate = std::ranges::binary_search(plate_info->frames, frame);
    PlatePicture plate = plate_picture(clip.set, view);
    if (!plate.rgb.empty() && !clip.set.plate_camera) plate.rgb = crop(plate.rgb, capture.inside);
    if (!plate.known.empty() && !clip.set.plate_camera) plate.known = crop(plate.known, capture.inside);
    const auto matte =
        read_own_picture(project.folder / "masks", fmt::format("{:06}.png", frame), clip_size, 1);
    if (!matte) return matte.error();
    HeldOutFrame& own = clip.held_out.emplace_back();
    own.frame = frame;
    own.pose = tracked->pose;
    own.camera = *camera;
    own.truth = crop(fitted(*truth, size), capture.inside);
    own.regions = std::move(*regions);
    const TiledMask alpha(crop(fitted(*matte, size), capture.inside));
    own.exposure = exposure_beside(own.truth, alpha, plate).value_or(Vec3f::Ones());
    own.plate = std::move(plate.rgb);
  }
  if (clip.held_out.empty())
    return Error{ErrorCode::failed, "None of the held-out frames has a track, so nothing can be measured.",
                 "Film a longer clip in which the face stays in view to the end.", project.folder.string()};
  return clip;
}

}  // namespace likeness
