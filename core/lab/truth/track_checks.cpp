// Fresh landmarks and stillness: see track_checks.h.
#include "core/lab/truth/track_checks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/face/landmarks.h"
#include "core/head/pose_head.h"
#include "core/track/points/camera_scale.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

constexpr int kFirstInner = 17, kNoseTip = 30, kHalfWindow = 4;
constexpr int kRestWindow = 2;
constexpr double kStill_px = 0.3, kRestExtent_px = 1.5, kLargestPitch = 20 * std::numbers::pi / 180;
constexpr std::size_t kMaxFresh = 200, kBatch = 16;

TrackRegion inside(const TrackRegion& region, int width, int height) {
  if (region.width <= 0 || region.height <= 0) return {0, 0, width, height};
  const int x = std::clamp(region.x, 0, width), y = std::clamp(region.y, 0, height);
  return {x, y, std::min(region.width, width - x), std::min(region.height, height - y)};
}

// The detector's usual box about a face, moved and scaled a little at random.
FaceBox shaken_box(const ProjectedLandmarks& face, std::uint32_t seed) {
  Vec2d low = Vec2d::Constant(1e9), high = -low;
  for (int k = kFirstInner; k < kLandmarkCount; ++k)
    low = low.cwiseMin(face.points[std::size_t(k)]), high = high.cwiseMax(face.points[std::size_t(k)]);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-1, 1);
  const double usual = 1.45 * std::max(high.x() - low.x(), 0.95 * (high.y() - low.y()));
  const double side = usual * (1 + 0.05 * shake(random));
  const Vec2d centre = 0.5 * (low + high) + usual * Vec2d(0.03 * shake(random), 0.02 + 0.03 * shake(random));
  return {centre.x() - 0.5 * side, centre.y() - 0.5 * side, side, side, 0};
}

// Coordinates with the outer eye corners on a level line, one apart: offsets in them neither turn nor grow
// with the face.
struct UprightFace {
  Eigen::Matrix2d turn;
  double size = 1;  // px
};
UprightFace upright(const ProjectedLandmarks& face) {
  const Vec2d across = face.points[45] - face.points[36];
  const double size = std::max(1.0, across.norm());
  Eigen::Matrix2d turn;
  turn << across.x(), across.y(), -across.y(), across.x();
  return {turn / size, size};
}

}  // namespace

std::vector<ProjectedLandmarks> project_track(const Track& track, const HeadModel& model,
                                              const CameraSet& cameras, const TrackRegion& region,
                                              int working_size) {
  std::vector<ProjectedLandmarks> projected(track.frames.size());
  const HeadShape shape = shape_head(model, track.person);
  parallel_for(projected.size(), [&](std::size_t i) {
    const TrackedFrame& frame = track.frames[i];
    const Camera* camera = find_camera(cameras, frame.frame);
    if (!camera || frame.status == FrameStatus::lost) return;
    const TrackRegion cut = inside(region, camera->intrinsics.width, camera->intrinsics.height);
    const double scale = double(working_size) / std::max(cut.width, cut.height);
    const Pose cam_from_head =
        metric_camera(camera->cam_from_world, track.metres_per_unit) * frame.pose.world_from_head;
    const auto points = landmark_positions(model, pose_head(model, shape, frame.pose.articulation));
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec2d source =
          project<double>(camera->intrinsics, Vec3d(cam_from_head * points[k].cast<double>()));
      projected[i].points[k] = (source - Vec2d(cut.x, cut.y)) * scale;
    }
    projected[i].pitch = std::asin(std::clamp(cam_from_head.linear()(1, 2), -1.0, 1.0));
    projected[i].known = true;
  });
  return projected;
}

FreshLandmarks compare_fresh(const std::vector<std::array<Vec2d, kLandmarkCount>>& found,
                             const std::vector<ProjectedLandmarks>& fitted) {
  FreshLandmarks fresh;
  fresh.frames = int(found.size());
  fresh.usual_offset.fill(Vec2d::Zero());
  if (found.empty()) return fresh;
  for (std::size_t k = kFirstInner; k < kLandmarkCount; ++k) {
    std::vector<Vec2d> offset;
    std::vector<double> x, y;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const UprightFace face = upright(fitted[i]);
      const Vec2d apart = found[i][k] - fitted[i].points[k];
      fresh.mean_px += apart.norm();
      offset.push_back(face.turn * apart / face.size);
      x.push_back(offset.back().x()), y.push_back(offset.back().y());
    }
    const Vec2d usual(median(x), median(y));
    fresh.usual_offset[k] = usual;
    for (std::size_t i = 0; i < found.size(); ++i)
      fresh.moving_px += (offset[i] - usual).norm() * upright(fitted[i]).size;
  }
  const double count = double(found.size()) * (kLandmarkCount - kFirstInner);
  fresh.mean_px /= count;
  fresh.moving_px /= count;
  return fresh;
}

Stillness measure_stillness(const std::vector<ProjectedLandmarks>& projected) {
  const int count = int(projected.size());
  const auto tip = [&](int i) { return projected[std::size_t(i)].points[kNoseTip]; };
  std::vector<bool> whole(projected.size(), false);  // the averaging window is complete
  std::vector<Vec2d> path(projected.size(), Vec2d::Zero());
  for (int i = kHalfWindow; i + kHalfWindow < count; ++i) {
    whole[std::size_t(i)] = true;
    for (int k = -kHalfWindow; k <= kHalfWindow; ++k) {
      whole[std::size_t(i)] = whole[std::size_t(i)] && projected[std::size_t(i + k)].known;
      path[std::size_t(i)] += tip(i + k) / (2 * kHalfWindow + 1);
    }
  }
  const auto rests = [&](int i) {  // from frame i to the next
    return whole[std::size_t(i)] && whole[std::size_t(i + 1)] &&
           (path[std::size_t(i + 1)] - path[std::size_t(i)]).norm() < kStill_px;
  };
  const auto keeps_place = [&](int i) {
    Vec2d low = tip(i), high = low;
    for (int k = -kRestWindow; k <= kRestWindow; ++k)
      low = low.cwiseMin(tip(i + k)), high = high.cwiseMax(tip(i + k));
    return (high - low).maxCoeff() < kRestExtent_px;
  };
  Stillness still;
  double sum = 0;
  for (int i = 1; i + 1 < count; ++i) {
    if (!rests(i - 1) || !rests(i) || !keeps_place(i)) continue;
    ++still.frames;
    sum += (tip(i - 1) - 2 * tip(i) + tip(i + 1)).squaredNorm();
  }
  if (still.frames > 0) still.jitter_px = std::sqrt(sum / still.frames);
  return still;
}

Result<FreshLandmarks> find_fresh_landmarks(const std::filesystem::path& video, const Track& track,
                                            const std::vector<ProjectedLandmarks>& projected,
                                            const TrackRegion& region, const TrackOptions& options,
                                            const Progress& progress, std::stop_token stop) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < projected.size(); ++i)
    if (projected[i].known && std::abs(projected[i].pitch) < kLargestPitch) chosen.push_back(i);
  std::map<int, std::size_t> wanted;  // by number in the source
  const std::size_t stride = std::max<std::size_t>(1, (chosen.size() + kMaxFresh - 1) / kMaxFresh);
  for (std::size_t k = 0; k < chosen.size(); k += stride) wanted[track.frames[chosen[k]].frame] = chosen[k];

  auto detector = FaceDetector::load(options.predictor);
  if (!detector) return detector.error();
  auto reader = VideoReader::open(video, VideoPixels::luma);
  if (!reader) return reader.error();
  const TrackRegion cut = inside(region, reader->info().width, reader->info().height);
  const double scale = double(options.working_size) / std::max(cut.width, cut.height);
  std::vector<std::array<Vec2d, kLandmarkCount>> all;
  std::vector<ProjectedLandmarks> fitted;
  std::vector<std::pair<std::size_t, Image8>> batch;
  for (bool end = false; !end;) {
    if (stop.stop_requested()) return cancelled_error();
    auto next = reader->next();
    if (!next) return next.error();
    end = !next->has_value();
    if (const auto found = end ? wanted.end() : wanted.find((*next)->index); found != wanted.end()) {
      const Image8 part = crop((*next)->rgb, cut.x, cut.y, cut.width, cut.height);
      batch.emplace_back(found->second, resize(part, std::max(1, int(std::lround(cut.width * scale))),
                                               std::max(1, int(std::lround(cut.height * scale)))));
    }
    if (batch.size() < kBatch && !end) continue;
    std::vector<std::array<Vec2d, kLandmarkCount>> found(batch.size());
    parallel_for(batch.size(), [&](std::size_t k) {
      const auto& [i, grey] = batch[k];
      const std::uint32_t seed = 90001u + std::uint32_t(i);
      found[k] = detector->landmarks(grey, shaken_box(projected[i], seed), seed).points;
    });
    all.insert(all.end(), found.begin(), found.end());
    for (const auto& [i, grey] : batch) fitted.push_back(projected[i]);
    batch.clear();
    progress.report(wanted.empty() ? 1 : double(all.size()) / double(wanted.size()), "fresh landmarks");
  }
  return compare_fresh(all, fitted);
}

}  // namespace likeness
