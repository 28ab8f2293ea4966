#include "core/track/clip/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/head/pose_head.h"
#include "core/scene/mesh_scene.h"
#include "core/track/clip/error_strip.h"
#include "core/track/photo/gaze.h"
#include "core/track/points/camera_scale.h"
#include "core/video/decode.h"
#include "core/video/encode.h"

namespace likeness {
namespace {

constexpr float kGridStep = 0.014f;   // m between the lines on the skin
constexpr double kGazeLength = 0.06;  // m
constexpr std::size_t kBatch = 8;     // frames drawn at once, in parallel
constexpr int kBand = 64;             // px of the text below the picture
constexpr double kSkinDepth = 0.004;  // m behind the nearest surface that still counts as seen
const cv::Scalar kGridInk(80, 200, 255), kOutlineInk(255, 160, 40), kGazeInk(255, 70, 220);

// A piece of a line on the skin: two points on edges of one triangle.
struct GridPiece {
  int triangle;
  std::array<Vec2f, 2> at;  // barycentric weights of the triangle's vertices 1 and 2
};

bool is_skin(const HeadModel& model, const Triangle& t) {
  if (model.parts.empty()) return true;
  return std::all_of(t.data(), t.data() + 3, [&](int v) {
    const HeadPart p = model.parts[v];
    return p == HeadPart::face || p == HeadPart::scalp_neck || p == HeadPart::unknown;
  });
}

// Where the planes x, y = whole multiples of the step cut the skin at rest.
std::vector<GridPiece> grid_on_skin(const HeadModel& model, const std::vector<Vec3f>& rest) {
  static const Vec2f kCorner[3] = {{0, 0}, {1, 0}, {0, 1}};
  std::vector<GridPiece> pieces;
  for (std::size_t f = 0; f < model.triangles.size(); ++f) {
    const Triangle& t = model.triangles[f];
    if (!is_skin(model, t)) continue;
    for (int axis = 0; axis < 2; ++axis) {
      const float v[3] = {rest[t[0]][axis] / kGridStep, rest[t[1]][axis] / kGridStep,
                          rest[t[2]][axis] / kGridStep};
      const float low = std::min({v[0], v[1], v[2]}), high = std::max({v[0], v[1], v[2]});
      for (float level = std::ceil(low); level < high; level += 1) {
        GridPiece piece{static_cast<int>(f), {}};
        int cuts = 0;
        for (int e = 0; e < 3 && cuts < 2; ++e) {
          const float a = v[e], b = v[(e + 1) % 3];
          if ((a < level) == (b < level)) continue;
          const float s = (level - a) / (b - a);
          piece.at[cuts++] = (1 - s) * kCorner[e] + s * kCorner[(e + 1) % 3];
        }
        if (cuts == 2) pieces.push_back(piece);
      }
    }
  }
  return pieces;
}

cv::Point to_cv(const Vec2d& p) {  // with 4 bits of fraction
  const auto fix = [](double v) {
    return static_cast<int>(std::lround(16 * std::clamp(v - 0.5, -4000.0, 12000.0)));
  };
  return {fix(p.x()), fix(p.y())};
}

void draw_line(cv::Mat& picture, const Vec2d& a, const Vec2d& b, const cv::Scalar& ink, int width) {
  cv::line(picture, to_cv(a), to_cv(b), ink, width, cv::LINE_AA, 4);
}

// Green where the runs agree to 1 % of the eyes' distance, red from 5 %.
cv::Scalar spread_ink(double spread, double eyes) {
  const double doubt = std::clamp((spread / std::max(1.0, eyes) - 0.01) / 0.04, 0.0, 1.0);
  return {255 * std::min(1.0, 2 * doubt), 255 * std::min(1.0, 2 - 2 * doubt), 0};
}

// The verdict in words on a band of its colour, in letters that fit.
void draw_verdict(cv::Mat band, const TrackedFrame& frame) {
  static const cv::Scalar kInk[3] = {{30, 120, 50}, {190, 130, 0}, {180, 30, 30}};
  static const char* kName[3] = {"good", "weak", "lost"};
  const int verdict = static_cast<int>(frame.status);
  band.setTo(kInk[verdict]);
  const std::string lines[2] = {
      fmt::format("frame {}  {:.2f} s  {}  model {:.1f} px off, spread {:.1f} px", frame.frame, frame.time_s,
                  kName[verdict], frame.inner_error_px, mean_inner_spread(frame)),
      frame.reason};
  for (int i = 0; i < 2; ++i) {
    double size = 0.7;
    while (size > 0.3 &&
           cv::getTextSize(lines[i], cv::FONT_HERSHEY_SIMPLEX, size, 1, nullptr).width > band.cols - 16)
      size -= 0.05;
    cv::putText(band, lines[i], {8, 25 + 28 * i}, cv::FONT_HERSHEY_SIMPLEX, size, {255, 255, 255}, 1,
                cv::LINE_AA);
  }
}

TrackedFrame unknown_frame(const VideoFrame& source) {
  TrackedFrame frame;
  frame.frame = source.index;
  frame.time_s = source.time_s;
  frame.status = FrameStatus::lost;
  frame.reason = "the track does not know this frame";
  frame.landmarks.fill(Vec2d::Zero());
  return frame;
}

}  // namespace

struct TrackOverlay::Impl {
  const Track& track;
  const HeadModel& model;
  const CameraSet& cameras;
  OverlayOptions options;
  HeadShape shape;
  EyeBalls eyes;
  std::vector<GridPiece> grid;
  std::vector<Triangle> skin;

  void draw_head(cv::Mat& picture, const Intrinsics& k, const Pose& cam_from_head,
                 const std::vector<Vec3f>& posed) const {
    const Raster raster = rasterise(posed, skin, k, cam_from_head);
    std::vector<Vec3d> in_cam(posed.size());
    for (std::size_t v = 0; v < posed.size(); ++v) in_cam[v] = cam_from_head * posed[v].cast<double>();
    const auto seen = [&](const Vec3d& p, const Vec2d& px) {
      const int x = static_cast<int>(std::floor(px.x())), y = static_cast<int>(std::floor(px.y()));
      if (x < 0 || y < 0 || x >= raster.width || y >= raster.height) return false;
      const float depth = raster.depth[static_cast<std::size_t>(y) * raster.width + x];
      return depth > 0 && p.z() < depth + kSkinDepth;
    };
    for (const GridPiece& piece : grid) {
      const Triangle& t = model.triangles[piece.triangle];
      std::array<Vec3d, 2> p;
      for (int e = 0; e < 2; ++e) {
        const double v = piece.at[e].x(), w = piece.at[e].y();
        p[e] = (1 - v - w) * in_cam[t[0]] + v * in_cam[t[1]] + w * in_cam[t[2]];
      }
      if (p[0].z() < 0.02 || p[1].z() < 0.02) continue;
      const Vec2d a = project<double>(k, p[0]), b = project<double>(k, p[1]);
      if (seen(0.5 * (p[0] + p[1]), 0.5 * (a + b))) draw_line(picture, a, b, kGridInk, 1);
    }
    cv::Mat mask(raster.height, raster.width, CV_8UC1);
    for (std::size_t i = 0; i < raster.triangle.size(); ++i) mask.data[i] = raster.triangle[i] >= 0 ? 255 : 0;
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    cv::polylines(picture, outlines, true, kOutlineInk, 1, cv::LINE_AA);
  }

  void draw_gaze(cv::Mat& picture, const Intrinsics& k, const Pose& cam_from_head,
                 const Articulation& a) const {
    for (int side = 0; side < 2; ++side) {
      const Vec3f& turn = side == 0 ? a.right_eye : a.left_eye;
      const double angle = turn.norm();
      const Vec3d look = angle < 1e-6
                             ? Vec3d(Vec3d::UnitZ())
                             : Vec3d(rotation_about(turn.cast<double>() / angle, angle) * Vec3d::UnitZ());
      const Vec3d from = cam_from_head * (eyes.centre[side] + eyes.radius * look),
                  to = cam_from_head * (eyes.centre[side] + (eyes.radius + kGazeLength) * look);
      if (from.z() < 0.05 || to.z() < 0.05) continue;
      draw_line(picture, project<double>(k, from), project<double>(k, to), kGazeInk, 2);
    }
  }

  void draw_landmarks(cv::Mat& picture, const Intrinsics& k, const Pose& cam_from_head,
                      const std::vector<Vec3f>& posed, const TrackedFrame& frame, double scale) const {
    const auto points = landmark_positions(model, posed);
    const double eyes_px = scale * (frame.landmarks[36] - frame.landmarks[45]).norm();
    const int radius = static_cast<int>(std::lround(16 * std::clamp(eyes_px / 60, 1.6, 4.0)));
    for (int i = 0; i < kLandmarkCount; ++i) {
      const Vec2d seen = scale * frame.landmarks[i];
      const cv::Scalar ink = spread_ink(scale * frame.landmark_spread[i], eyes_px);
      const Vec3d p = cam_from_head * points[i].cast<double>();
      if (i >= 17 && p.z() > 0.05) draw_line(picture, seen, project<double>(k, p), {255, 255, 255}, 1);
      cv::circle(picture, to_cv(seen), radius, {0, 0, 0}, 2, cv::LINE_AA, 4);
      cv::circle(picture, to_cv(seen), radius, ink, cv::FILLED, cv::LINE_AA, 4);
    }
  }
};

TrackOverlay::TrackOverlay(const Track& track, const HeadModel& model, const CameraSet& cameras,
                           const OverlayOptions& options)
    : impl_(new Impl{track, model, cameras, options, shape_head(model, track.person), {}, {}, {}}) {
  impl_->eyes = eye_balls(model, impl_->shape);
  impl_->grid = grid_on_skin(model, impl_->shape.vertices);
  for (const Triangle& t : model.triangles)
    if (is_skin(model, t)) impl_->skin.push_back(t);
}
TrackOverlay::~TrackOverlay() = default;
TrackOverlay::TrackOverlay(TrackOverlay&&) noexcept = default;
TrackOverlay& TrackOverlay::operator=(TrackOverlay&&) noexcept = default;

Image8 TrackOverlay::draw(const Image8& rgb, const TrackedFrame& frame) const {
  const Impl& my = *impl_;
  const double scale = static_cast<double>(my.options.longer_side) / std::max(rgb.width, rgb.height);
  const int w = static_cast<int>(std::lround(rgb.width * scale)) & ~1,
            h = static_cast<int>(std::lround(rgb.height * scale)) & ~1;
  const Image8 small = resize(rgb, w, h);
  Image8 out(w, h + kBand, 3);
  std::copy(small.data.begin(), small.data.end(), out.data.begin());
  cv::Mat all(out.height, w, CV_8UC3, out.data.data());
  cv::Mat picture = all.rowRange(0, h);
  const Camera* camera = find_camera(my.cameras, frame.frame);
  const bool has_landmarks = frame.landmarks[30] != Vec2d::Zero();
  if (camera && frame.status != FrameStatus::lost) {
    Intrinsics k = camera->intrinsics;
    const double sx = static_cast<double>(w) / k.width, sy = static_cast<double>(h) / k.height;
    k.width = w, k.height = h, k.fx *= sx, k.cx *= sx, k.fy *= sy, k.cy *= sy;
    const Pose cam_from_head =
        metric_camera(camera->cam_from_world, my.track.metres_per_unit) * frame.pose.world_from_head;
    const std::vector<Vec3f> posed = pose_head(my.model, my.shape, frame.pose.articulation);
    my.draw_head(picture, k, cam_from_head, posed);
    my.draw_gaze(picture, k, cam_from_head, frame.pose.articulation);
    if (has_landmarks) my.draw_landmarks(picture, k, cam_from_head, posed, frame, sx);
  }
  draw_verdict(all.rowRange(h, h + kBand), frame);
  return out;
}

Result<void> write_overlay(const std::filesystem::path& video, const Track& track, const HeadModel& model,
                           const CameraSet& cameras, const std::filesystem::path& out,
                           const OverlayOptions& options, const Progress& progress, std::stop_token stop) {
  auto reader = VideoReader::open(video);
  if (!reader) return reader.error();
  const TrackOverlay overlay(track, model, cameras, options);
  std::optional<VideoWriter> writer;
  std::vector<VideoFrame> batch;
  std::vector<Image8> drawn;
  std::size_t done = 0;
  double first_s = 0;
  for (bool end = false; !end;) {
    auto next = reader->next();
    if (!next) return next.error();
    if (stop.stop_requested()) return cancelled_error();
    end = !next->has_value();
    if (!end) batch.push_back(std::move(**next));
    if (batch.empty() || (!end && batch.size() < kBatch)) continue;
    drawn.assign(batch.size(), {});
    parallel_for(batch.size(), [&](std::size_t i) {
      const TrackedFrame* frame = find_tracked(track, batch[i].index);
      drawn[i] = overlay.draw(batch[i].rgb, frame ? *frame : unknown_frame(batch[i]));
    });
    if (!writer) {
      auto created = VideoWriter::create(out, drawn[0].width, drawn[0].height,
                                         {.frames_per_second = options.frames_per_second, .timed = true});
      if (!created) return created.error();
      writer = std::move(*created);
    }
    if (done == 0) first_s = batch[0].time_s;
    for (std::size_t i = 0; i < batch.size(); ++i)
      if (auto added = writer->add(drawn[i], std::max(0.0, batch[i].time_s - first_s)); !added)
        return added.error();
    done += batch.size();
    batch.clear();
    progress.report(track.frames.empty() ? 1 : static_cast<double>(done) / track.frames.size(), "overlay");
  }
  if (!writer)
    return Error{ErrorCode::bad_input, "The video holds no frame.", "Choose another video.", video.string()};
  return writer->finish();
}

}  // namespace likeness
