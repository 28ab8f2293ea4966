// Frames of the matte stage: see matte_frames.h.
#include "core/matte/matte_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "core/camera/mosaic.h"
#include "core/image/files.h"
#include "core/matte/person_share.h"

namespace likeness::matting {

cv::Mat view(const Image8& image) {
  return cv::Mat(image.height, image.width, image.channels == 3 ? CV_8UC3 : CV_8U,
                 const_cast<std::uint8_t*>(image.data.data()));
}

cv::Mat reduced(const cv::Mat& picture, int size) {
  cv::Mat small;
  cv::resize(picture, small, {size, size}, 0, 0, cv::INTER_AREA);
  return small;
}

Intrinsics crop_of(const Stage& stage, const Camera& camera, int size) {
  const SquareCrop& crop = stage.capture.crop;
  return crop_intrinsics(camera.intrinsics, crop.x, crop.y, crop.side, size);
}

cv::Mat unfilmed(const Stage& stage, int size) {
  const PixelRect inside = resampled(stage.capture.inside, stage.capture.size, size);
  if (inside.empty()) return {};
  cv::Mat outside(size, size, CV_8U, cv::Scalar(255));
  outside(cv::Rect(inside.x, inside.y, inside.width, inside.height)).setTo(0);
  return outside;
}

Result<cv::Mat> kept_mask(const Stage& stage, const std::string& name, int frame,
                          const std::function<Result<cv::Mat>()>& make) {
  if (stage.kept == nullptr) return make();
  const std::string piece = fmt::format("{} {}", name, frame);
  const auto pixels = std::size_t(stage.cut_size) * std::size_t(stage.cut_size);
  if (const auto kept = stage.kept->find(piece); kept && (kept->size() == pixels || kept->empty())) {
    if (kept->empty()) return cv::Mat();
    return cv::Mat(stage.cut_size, stage.cut_size, CV_8U, const_cast<char*>(kept->data())).clone();
  }
  auto mask = make();
  if (!mask || stage.stop.stop_requested()) return mask;
  const bool own_form = mask->type() == CV_8U && mask->cols == stage.cut_size && mask->rows == stage.cut_size;
  if (mask->empty()) stage.kept->keep(piece, {});
  if (own_form && mask->isContinuous())
    stage.kept->keep(piece, {reinterpret_cast<const char*>(mask->data), pixels});
  return mask;
}

Result<cv::Mat> read_frame(const Stage& stage, int frame) {
  const auto image = read_image(stage.folder / frame_name(frame));
  if (!image) return image.error();
  if (image->channels != 3 || image->width != image->height)
    return Error{ErrorCode::bad_input,
                 fmt::format("A frame has {} x {} px and {} channels; a square RGB picture is expected.",
                             image->width, image->height, image->channels),
                 "Run `likeness import` again.", (stage.folder / frame_name(frame)).string()};
  const PixelRect inside = resampled(stage.capture.inside, stage.capture.size, image->width);
  const Image8 extended =
      inside.empty() ? *image : crop(crop(*image, inside), -inside.x, -inside.y, image->width, image->height);
  cv::Mat picture = view(extended).clone();
  return picture.cols == stage.size ? picture : reduced(picture, stage.size);
}

Result<cv::Mat> own_alpha(const Stage& stage, int frame, int size) {
  std::error_code ignored;
  const std::filesystem::path path = stage.folder / alpha_name(frame);
  if (!std::filesystem::exists(path, ignored)) return cv::Mat();
  const auto alpha = read_image(path);
  const int side = stage.capture.size;
  if (!alpha || alpha->channels != 1 || alpha->width != side || alpha->height != side)
    return Error{
        ErrorCode::bad_input,
        alpha ? fmt::format("{} does not have the project's {} x {} px.", path.string(), side, side)
              : fmt::format("{} is missing or damaged.", path.string()),
        fmt::format("Delete {} and run the build again: it is then made again.", path.parent_path().string()),
        path.string()};
  const Image8 sized = alpha->width == size ? *alpha : resize(*alpha, size, size);
  return view(sized).clone();
}

Result<cv::Mat> network_alpha(const Stage& stage, const cv::Mat& picture) {
  if (!stage.network) return cv::Mat();
  Image8 rgb(picture.cols, picture.rows, 3);
  std::memcpy(rgb.data.data(), picture.data, rgb.data.size());
  const auto alpha = stage.network->alpha(rgb);
  if (!alpha) return alpha.error();
  return view(*alpha).clone();
}

namespace {

// The tracked frame nearest in number: heads do not leap where the track is lost. Never one that is held out
// or kept apart for a training frame.
const TrackedFrame* nearest_tracked(const Stage& stage, const CaptureFrame& frame) {
  const auto may_know = [&](const TrackedFrame& candidate) {
    if (candidate.status == FrameStatus::lost) return false;
    if (frame.held_out) return true;
    const auto own = std::ranges::find(stage.capture.frames, candidate.frame, &CaptureFrame::frame);
    return own == stage.capture.frames.end() || !(own->held_out || own->apart);
  };
  const TrackedFrame* best = nullptr;
  for (const auto& candidate : stage.track.frames)
    if ((!best || std::abs(candidate.frame - frame.frame) < std::abs(best->frame - frame.frame)) &&
        may_know(candidate))
      best = &candidate;
  return best;
}

}  // namespace

std::vector<Job> list_jobs(const Stage& stage) {
  std::vector<Job> jobs;
  const std::vector<FrameSpan> shots = spans_where_cut(stage.capture);
  for (const auto& frame : stage.capture.frames) {
    if (!frame.used && !frame.held_out) continue;
    const bool on_plate = stage.cameras.kind != CameraKind::walking;
    Job job{frame.frame,
            span_of(shots, frame.frame),
            frame.used && !frame.held_out,
            frame.held_out,
            on_plate,
            nullptr,
            nullptr};
    job.camera = find_camera(stage.cameras, frame.frame);
    job.tracked = find_tracked(stage.track, frame.frame);
    if (!job.tracked || job.tracked->status == FrameStatus::lost) job.tracked = nearest_tracked(stage, frame);
    if (job.camera && job.tracked) jobs.push_back(job);
  }
  return jobs;
}

void mark_rest(const Stage& stage, std::vector<Job>& jobs) {
  if (stage.cameras.kind != CameraKind::walking) return;
  const auto same = [](const Job& a, const Job& b) {
    return a.camera->cam_from_world.matrix() == b.camera->cam_from_world.matrix();
  };
  const auto time_of = [&](const Job& job) { return time_of_frame(stage.capture, job.frame); };
  std::size_t best_begin = 0, best_end = 0;
  double longest_s = 0;
  for (std::size_t begin = 0; begin < jobs.size();) {
    std::size_t end = begin + 1;
    while (end < jobs.size() && same(jobs[begin], jobs[end])) ++end;
    const double length_s = time_of(jobs[end - 1]) - time_of(jobs[begin]);
    if (length_s > longest_s) longest_s = length_s, best_begin = begin, best_end = end;
    begin = end;
  }
  const auto trains = std::count_if(jobs.begin() + long(best_begin), jobs.begin() + long(best_end),
                                    [](const Job& job) { return job.trains; });
  constexpr double kLeast_s = 0.95;
  if (longest_s < kLeast_s || trains < 5) return;
  for (std::size_t i = best_begin; i < best_end; ++i) jobs[i].on_plate = true;
}

std::optional<PersonPlace> place_of(const Stage& stage, const Job& job, const Intrinsics& picture) {
  return place_person(stage.person, *job.tracked, *job.camera, picture, stage.track.metres_per_unit);
}

StrokeCover strokes_on(const Stage& stage, const Job& job, int size) {
  const auto own = stage.strokes.find(job.frame);
  if (own == stage.strokes.end()) return {};
  return cover_strokes(own->second, stage.capture.crop, size);
}

namespace {

// m: a hole in the network's person of up to this size is not seen through.
constexpr double kSmallHole = 0.04;

// What the track and the person network say about a frame. `hull` may be empty.
PersonPrior tracked_prior(const Stage& stage, const Job& job, int size, const PersonHull& hull) {
  const Intrinsics picture = crop_of(stage, *job.camera, size);
  if (const auto place = place_of(stage, job, picture)) {
    PersonPrior prior = person_prior(stage.person, *place, picture);
    sharpen_prior(prior, hull, *place, picture);
    if (size == job.share.cols)
      take_up_share(prior, job.share, share_band(place->px_per_metre), kSmallHole * place->px_per_metre);
    return prior;
  }
  PersonPrior nothing;
  nothing.certain = nothing.likely = nothing.below = nothing.hair = cv::Mat(size, size, CV_8U, cv::Scalar(0));
  nothing.possible = cv::Mat(size, size, CV_8U, cv::Scalar(255));
  nothing.location = cv::Mat(size, size, CV_32F, cv::Scalar(0));
  return nothing;
}

}  // namespace

PersonPrior prior_of(const Stage& stage, const Job& job, int size, const PersonHull& hull) {
  PersonPrior prior = tracked_prior(stage, job, size, hull);
  constrain_prior(prior, strokes_on(stage, job, size));
  return prior;
}

bool has_neighbours(const std::vector<Job>& jobs, std::size_t i) {
  const auto usable = [&](std::size_t other) {
    return jobs[other].shot == jobs[i].shot && std::abs(jobs[other].frame - jobs[i].frame) <= 2 &&
           (jobs[i].held_out || !jobs[other].held_out);
  };
  return i > 0 && i + 1 < jobs.size() && usable(i - 1) && usable(i + 1);
}

std::vector<const Job*> choose(const std::vector<Job>& jobs, bool on_plate, std::size_t count) {
  std::vector<const Job*> all, chosen;
  for (const auto& job : jobs)
    if (job.trains && job.on_plate == on_plate) all.push_back(&job);
  const std::size_t kept = std::min(count, all.size());
  for (std::size_t i = 0; i < kept; ++i) chosen.push_back(all[i * all.size() / kept]);
  return chosen;
}

namespace {

constexpr double kMosaicReach = 0.96;  // rad, 55 degrees: farther out a pinhole's picture grows without bound
constexpr std::size_t kMosaicFrames = 12;  // of a frame's pixels, at most

// OpenCV's pixels have their centre at 0.
cv::Matx33d cv_map(const Camera& from, const Camera& to) {
  const Mat3d map = pixels_between(from, to);
  cv::Matx33d m;
  for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = map(i / 3, i % 3);
  const cv::Matx33d to_corner(1, 0, 0.5, 0, 1, 0.5, 0, 0, 1), to_centre(1, 0, -0.5, 0, 1, -0.5, 0, 0, 1);
  return to_centre * m * to_corner;
}

Camera crop_camera(const Stage& stage, const Job& job, int size) {
  Camera camera = *job.camera;
  camera.intrinsics = crop_of(stage, camera, size);
  return camera;
}

}  // namespace

void choose_mosaic(Stage& stage, const std::vector<Job>& jobs) {
  if (stage.cameras.kind != CameraKind::handheld) return;
  std::vector<Camera> cameras;
  for (const Job& job : jobs)
    if (job.on_plate) cameras.push_back(crop_camera(stage, job, stage.size));
  if (cameras.empty()) return;
  stage.mosaic =
      mosaic_camera(cameras, kMosaicReach, kMosaicFrames * std::size_t(stage.size) * std::size_t(stage.size));
  stage.small_mosaic = stage.mosaic;
  if (stage.cut_size != stage.size)
    stage.small_mosaic =
        resized(*stage.mosaic, std::max(1, stage.mosaic->intrinsics.width * stage.cut_size / stage.size));
}

cv::Mat onto_plate(const Stage& stage, const Job& job, const cv::Mat& picture, int interpolation,
                   const cv::Scalar& outside) {
  if (!stage.mosaic) return picture;
  const Camera& to = picture.cols == stage.size ? *stage.mosaic : *stage.small_mosaic;
  cv::Mat seen;
  cv::warpPerspective(picture, seen, cv_map(crop_camera(stage, job, picture.cols), to),
                      {to.intrinsics.width, to.intrinsics.height}, interpolation, cv::BORDER_CONSTANT,
                      outside);
  return seen;
}

Plate plate_of_frame(const Stage& stage, const Job& job, const Plate& plate, int size) {
  if (!stage.mosaic) return plate;
  const Camera& whole =
      plate.colour.cols == stage.mosaic->intrinsics.width ? *stage.mosaic : *stage.small_mosaic;
  const cv::Matx33d map = cv_map(whole, crop_camera(stage, job, size));
  Plate part;
  cv::Mat known;
  cv::warpPerspective(plate.colour, part.colour, map, {size, size}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::warpPerspective(plate.noise, part.noise, map, {size, size}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  // Known where everything that a pixel is made of is.
  cv::warpPerspective(plate.known, known, map, {size, size}, cv::INTER_LINEAR, cv::BORDER_CONSTANT, 0);
  part.known = (known == kSeen) & kSeen;
  return part;
}

Plate room_of(const Stage& stage, const Job& job, const cv::Mat& picture, const cv::Mat& possible) {
  if (job.on_plate || !stage.room) return {};
  const Image8 room = stage.room(job.frame);
  if (room.empty()) return {};
  cv::Mat seen = view(room), reach = possible;
  if (seen.cols != picture.cols) seen = reduced(seen, picture.cols);
  if (reach.cols != picture.cols)
    cv::resize(reach, reach, {picture.cols, picture.rows}, 0, 0, cv::INTER_NEAREST);
  return room_plate(picture, seen.clone(), reach == 0, reach);
}

}  // namespace likeness::matting
