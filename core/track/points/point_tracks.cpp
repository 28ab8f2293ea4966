#include "core/track/points/point_tracks.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/base/parallel.h"

namespace likeness {
namespace {

constexpr int kWindow = 21, kLevels = 3;
constexpr std::size_t kPrefetch = 16;  // pyramids made at once, in parallel

cv::Point2f to_cv(const Vec2d& p) {
  return {static_cast<float>(p.x() - 0.5), static_cast<float>(p.y() - 0.5)};
}
Vec2d from_cv(const cv::Point2f& p) { return {p.x + 0.5, p.y + 0.5}; }

bool inside(const Image8& mask, const Vec2d& p) {
  const int x = static_cast<int>(p.x()), y = static_cast<int>(p.y());
  return x >= 0 && y >= 0 && x < mask.width && y < mask.height && mask.at(x, y)[0] != 0;
}

}  // namespace

struct TrackPicture::Impl {
  cv::Mat evened;
  std::vector<cv::Mat> pyramid;
};

TrackPicture::TrackPicture(const Image8& grey) {
  auto impl = std::make_shared<Impl>();
  const cv::Mat source(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data.data()));
  cv::createCLAHE(2.0, {8, 8})->apply(source, impl->evened);
  cv::buildOpticalFlowPyramid(impl->evened, impl->pyramid, {kWindow, kWindow}, kLevels);
  impl_ = std::move(impl);
}

std::vector<std::optional<Vec2d>> follow_points(const TrackPicture& from, const TrackPicture& to,
                                                std::span<const Vec2d> points, std::span<const Vec2d> guesses,
                                                double forward_backward_px) {
  std::vector<std::optional<Vec2d>> result(points.size());
  if (points.empty()) return result;
  std::vector<cv::Point2f> start, end, back;
  for (const Vec2d& p : points) start.push_back(to_cv(p));
  for (const Vec2d& p : guesses) end.push_back(to_cv(p));
  back = start;
  std::vector<unsigned char> there, home;
  std::vector<float> error;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01);
  const cv::Size window(kWindow, kWindow);
  cv::calcOpticalFlowPyrLK(from.impl()->pyramid, to.impl()->pyramid, start, end, there, error, window,
                           kLevels, until, guesses.empty() ? 0 : cv::OPTFLOW_USE_INITIAL_FLOW);
  cv::calcOpticalFlowPyrLK(to.impl()->pyramid, from.impl()->pyramid, end, back, home, error, window, kLevels,
                           until, cv::OPTFLOW_USE_INITIAL_FLOW);
  const int w = to.impl()->evened.cols, h = to.impl()->evened.rows;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!there[i] || !home[i] ||
        std::hypot(back[i].x - start[i].x, back[i].y - start[i].y) > forward_backward_px)
      continue;
    if (end[i].x < 2 || end[i].y < 2 || end[i].x > static_cast<float>(w - 3) ||
        end[i].y > static_cast<float>(h - 3))
      continue;
    result[i] = from_cv(end[i]);
  }
  return result;
}

std::vector<Vec2d> find_corners(const TrackPicture& picture, const Image8& mask, std::span<const Vec2d> taken,
                                int count, const PointTrackOptions& options) {
  std::vector<Vec2d> found;
  if (count <= 0) return found;
  cv::Mat allowed =
      cv::Mat(mask.height, mask.width, CV_8UC1, const_cast<std::uint8_t*>(mask.data.data())).clone();
  for (const Vec2d& p : taken)
    cv::circle(allowed, {static_cast<int>(p.x()), static_cast<int>(p.y())},
               static_cast<int>(options.corner_distance_px), 0, -1);
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(picture.impl()->evened, corners, count, options.corner_quality,
                          options.corner_distance_px, allowed, 5);
  for (const cv::Point2f& c : corners) found.push_back(from_cv(c));
  return found;
}

Result<std::vector<PointTrack>> track_points(const std::vector<const Image8*>& grey,
                                             const std::vector<int>& pictures,
                                             const std::function<Image8(int)>& mask,
                                             const PointTrackOptions& options, const Progress& progress,
                                             std::stop_token stop, const std::vector<int>& shots) {
  std::vector<PointTrack> done, alive;
  const auto retire = [&](PointTrack& track) {
    if (static_cast<int>(track.seen.size()) >= options.shortest) done.push_back(std::move(track));
  };
  std::vector<TrackPicture> ahead;
  std::vector<Image8> masks;
  TrackPicture before;
  try {
    for (std::size_t k = 0; k < pictures.size(); ++k) {
      if (stop.stop_requested()) return cancelled_error();
      if (k % kPrefetch == 0) {
        const std::size_t n = std::min(kPrefetch, pictures.size() - k);
        ahead.assign(n, {});
        masks.assign(n, {});
        parallel_for(n, [&](std::size_t i) {
          ahead[i] = TrackPicture(*grey[pictures[k + i]]);
          masks[i] = mask(pictures[k + i]);
        });
        progress.report(static_cast<double>(k) / pictures.size(), "following points on the head");
      }
      const TrackPicture& now = ahead[k % kPrefetch];
      const Image8& allowed = masks[k % kPrefetch];
      std::vector<Vec2d> taken;
      const bool cut = k > 0 && !shots.empty() && shots[pictures[k]] != shots[pictures[k - 1]];
      if (cut) {
        for (PointTrack& t : alive) retire(t);
        alive.clear();
      }
      if (k > 0 && !alive.empty()) {
        std::vector<Vec2d> last;
        for (const PointTrack& t : alive) last.push_back(t.seen.back().pixel);
        const auto next = follow_points(before, now, last, {}, options.forward_backward_px);
        std::vector<PointTrack> going;
        for (std::size_t i = 0; i < alive.size(); ++i) {
          if (next[i] && (allowed.empty() || inside(allowed, *next[i]))) {
            alive[i].seen.push_back({pictures[k], *next[i]});
            taken.push_back(*next[i]);
            going.push_back(std::move(alive[i]));
          } else {
            retire(alive[i]);
          }
        }
        alive = std::move(going);
      }
      if ((cut || k % static_cast<std::size_t>(options.top_up_every) == 0) && !allowed.empty())
        for (const Vec2d& corner :
             find_corners(now, allowed, taken, options.corners - static_cast<int>(alive.size()), options))
          alive.push_back({{{pictures[k], corner}}});
      before = now;
    }
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return Error{ErrorCode::failed, "Following points through the pictures failed: " + std::string(e.what()),
                 "Run the fit again; if it fails again, report this message.", "dense tracks"};
  }
  for (PointTrack& t : alive) retire(t);
  progress.report(1);
  return done;
}

}  // namespace likeness
