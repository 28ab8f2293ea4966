// See head_views.h.
#include "core/capture/head_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "core/base/linalg.h"
#include "core/base/parallel.h"
#include "core/camera/assumed_lens.h"
#include "core/face/face_landmarks.h"
#include "core/face/face_patch.h"
#include "core/face/fit_looks.h"
#include "core/head/builtin_head.h"

namespace likeness {
namespace {

constexpr std::size_t kViewBatch = 32;  // patches examined in parallel
constexpr double kWidestGap = 0.65;     // s between two samples with a view: one or two in a row may lack it
constexpr int kFewestInside = 25;       // of which a tenth measures
constexpr int kFewestBeyond = 5;

struct NumberedPatch {
  int frame = 0;
  FacePatch face;
};

// What a sample says, at the time of its frame.
struct TimedView {
  double time_s = 0;
  Vec3d to_camera;
};

std::vector<TimedView> timed_views(const std::vector<CaptureFrame>& frames,
                                   const std::vector<FaceSample>& samples) {
  std::vector<TimedView> views;
  for (const FaceSample& sample : samples) {
    if (!sample.to_camera) continue;
    const auto at = std::ranges::lower_bound(frames, sample.frame, {}, &CaptureFrame::frame);
    if (at != frames.end() && at->frame == sample.frame) views.push_back({at->time_s, *sample.to_camera});
  }
  return views;
}

std::optional<Vec3d> view_at(const std::vector<TimedView>& views, double time_s) {
  const auto after = std::ranges::lower_bound(views, time_s, {}, &TimedView::time_s);
  if (after != views.end() && after->time_s == time_s) return after->to_camera;
  if (after == views.begin() || after == views.end()) {  // before the first or after the last
    if (views.empty()) return std::nullopt;
    const TimedView& nearest = after == views.end() ? views.back() : *after;
    return std::abs(nearest.time_s - time_s) < 0.5 * kWidestGap ? std::optional(nearest.to_camera)
                                                                : std::nullopt;
  }
  const TimedView &b = *after, &a = *(after - 1);
  if (b.time_s - a.time_s > kWidestGap) return std::nullopt;
  const double t = (time_s - a.time_s) / (b.time_s - a.time_s);
  return Vec3d(((1 - t) * a.to_camera + t * b.to_camera).normalized());
}

// Rows: the subject's left, up and out of the face, turned so that the typical side is the front.
Mat3d side_axes(const Vec3d& typical) {
  const Vec3d out = typical.normalized(), left = Vec3d::UnitY().cross(out).normalized();
  Mat3d axes;
  axes.row(0) = left, axes.row(1) = out.cross(left), axes.row(2) = out;
  return axes;
}

}  // namespace

struct HeadViewFinder::State {
  State(const VideoInfo& info, const FaceDetector& given)
      : detector(given), lens(assumed_intrinsics(info.width, info.height, info.focal_35mm)) {}

  void find_landmarks() {
    std::vector<std::optional<Landmarks>> found(waiting.size());
    parallel_for(waiting.size(),
                 [&](std::size_t i) { found[i] = patch_landmarks(detector, waiting[i].face); });
    for (std::size_t i = 0; i < waiting.size(); ++i)
      if (found[i]) looks.push_back({waiting[i].frame, *found[i]});
    waiting.clear();
  }

  const FaceDetector& detector;
  Intrinsics lens;
  std::vector<NumberedPatch> waiting;
  std::vector<LandmarkLook> looks;
};

HeadViewFinder::HeadViewFinder(const VideoInfo& info, const FaceDetector& detector)
    : state_(std::make_unique<State>(info, detector)) {}
HeadViewFinder::~HeadViewFinder() = default;

void HeadViewFinder::look(const VideoFrame& frame, const FaceSample& sample) {
  if (!sample.face) return;
  state_->waiting.push_back({sample.frame, cut_face_patch(frame.rgb, *sample.face)});
  if (state_->waiting.size() == kViewBatch) state_->find_landmarks();
}

Result<void> HeadViewFinder::put_into(std::vector<FaceSample>& samples, const Progress& progress,
                                      std::stop_token stop) {
  state_->find_landmarks();
  const auto states = fit_looks(make_builtin_head(), state_->lens, state_->looks, progress, stop);
  if (!states) return states.error();
  for (std::size_t i = 0; i < states->size(); ++i) {
    const auto sample = std::ranges::lower_bound(samples, state_->looks[i].frame, {}, &FaceSample::frame);
    const Vec3d to_camera = direction_to_camera((*states)[i]);
    if (to_camera.allFinite() && sample != samples.end() && sample->frame == state_->looks[i].frame)
      sample->to_camera = to_camera;
  }
  return {};
}

void fill_in_views(std::vector<CaptureFrame>& frames, const std::vector<FaceSample>& samples) {
  constexpr double kDegree = std::numbers::pi / 180;
  const std::vector<TimedView> views = timed_views(frames, samples);
  std::vector<std::optional<Vec3d>> own;
  Vec3d sum = Vec3d::Zero();
  for (const CaptureFrame& frame : frames) {
    own.push_back(view_at(views, frame.time_s));
    if (own.back()) sum += *own.back();
  }
  const Mat3d axes = sum.norm() > 0 ? side_axes(sum) : Mat3d::Identity();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].view.reset();
    if (!own[i]) continue;
    const Vec3d v = axes * *own[i];
    frames[i].view = {std::atan2(v.x(), v.z()) / kDegree, std::asin(std::clamp(v.y(), -1.0, 1.0)) / kDegree};
  }
}

SideCounts count_sides(const std::vector<CaptureFrame>& frames, const SideRange& sides) {
  SideCounts counts;
  for (const CaptureFrame& frame : frames) {
    counts.apart += frame.apart;
    if (!frame.view) continue;
    const double off_deg = angle_deg(*frame.view);
    ++counts.known;
    counts.inside += off_deg <= sides.inside_deg;
    counts.beyond += off_deg > sides.beyond_deg;
    counts.widest_deg = std::max(counts.widest_deg, off_deg);
  }
  return counts;
}

Result<void> judge_sides(const std::vector<CaptureFrame>& frames, const SideRange& sides,
                         const std::string& where) {
  const SideCounts counts = count_sides(frames, sides);
  const auto refused = [&](std::string what, std::string fix) {
    return Error{ErrorCode::bad_input, std::move(what), std::move(fix), where};
  };
  if (2 * counts.known < int(frames.size()))
    return refused(fmt::format("From which side the head is seen can be told of {} of {} frames.",
                               counts.known, frames.size()),
                   "Film the face evenly lit and in view all the time, or leave out --split sides.");
  if (counts.beyond < kFewestBeyond)
    return refused(
        fmt::format("The head is seen from at most {:.1f} degrees off its typical side: of {} frames, {} lie "
                    "beyond {:g} degrees, and at least {} are needed to measure on.",
                    counts.widest_deg, frames.size(), counts.beyond, sides.beyond_deg, kFewestBeyond),
        "Choose a smaller --beyond (and --inside), or film the head turning farther to both sides.");
  if (counts.inside < kFewestInside)
    return refused(
        fmt::format("The head is seen from at most {:.1f} degrees off its typical side, but of {} frames "
                    "only {} lie within {:g} degrees, and at least {} are needed to train on.",
                    counts.widest_deg, frames.size(), counts.inside, sides.inside_deg, kFewestInside),
        "Choose a larger --inside (and --beyond), or film longer from one side.");
  return {};
}

}  // namespace likeness
