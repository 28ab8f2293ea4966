// See live_figures.h.
#include "core/lab/bench/live_figures.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <utility>
#include <vector>

#include "core/base/quantile.h"
#include "core/drive/drive.h"
#include "core/drive/live_driver.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

using Clock = LiveDriver::Clock;

struct Waiting {
  DrivenFrame frame;
  Clock::time_point captured;
};

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

}  // namespace

Result<LiveFigures> measure_live(const Avatar& avatar, const HeadModel& model,
                                 const std::filesystem::path& clip, const LiveStudyOptions& options,
                                 const Progress& progress, std::stop_token stop) {
  const auto info = probe_video(clip);
  if (!info) return info.error();
  const auto made = make_rig(avatar, model);
  if (!made) return made.error();
  const AvatarRig& rig = *made;
  const Camera camera = typical_camera(avatar);
  const RenderOptions quality = render_options(options.quality);
  LiveFigures figures;
  std::mutex mutex;
  std::condition_variable_any changed;
  std::optional<Waiting> newest;
  LiveOptions live;
  live.track = options.track;
  LiveDriver driver([&] { return open_clip_source(clip); }, avatar_subject(avatar, model), live,
                    [&](const DrivenFrame& frame, Clock::time_point captured) {
                      const std::lock_guard lock(mutex);
                      ++figures.driven, figures.lost += frame.bridged;
                      newest = Waiting{frame, captured};
                      changed.notify_one();
                    });
  std::vector<double> latencies, renders;
  std::optional<Clock::time_point> first;
  Clock::time_point last{};
  while (!stop.stop_requested()) {
    std::optional<Waiting> next;
    {
      std::unique_lock lock(mutex);
      changed.wait_for(lock, stop, std::chrono::milliseconds(100), [&] { return newest.has_value(); });
      next = std::exchange(newest, std::nullopt);
    }
    const LiveStatus status = driver.status();
    progress.report(info->frame_count > 0 ? std::min(1.0, double(status.captured) / info->frame_count) : 0.5,
                    "driving live");
    if (!next && status.state == LiveState::failed) return *status.error;
    if (!next && status.state == LiveState::ended) break;
    if (!next) continue;
    const auto start = Clock::now();
    const RenderState state = pose_avatar(rig, next->frame.pose);
    const RenderedFrame picture = render_frame(avatar, camera, state, quality);
    renders.push_back(seconds_since(start));
    latencies.push_back(seconds_since(next->captured));
    last = Clock::now();
    if (!first) first = last;
    figures.shown += !picture.rgba.empty();
  }
  if (stop.stop_requested()) return cancelled_error();
  const LiveStatus status = driver.status();
  figures.captured = status.captured, figures.dropped = status.dropped;
  if (latencies.size() < 2) {
    return status.error.value_or(
        Error{ErrorCode::no_face, "Nothing was driven: the clip is too short, or shows no face.",
              "Use a clip of some seconds in which the face is near and well lit.", clip.string()});
  }
  figures.seconds = std::chrono::duration<double>(last - *first).count();
  figures.frames_per_second = double(figures.shown - 1) / std::max(1e-6, figures.seconds);
  figures.latency_median_s = quantile(latencies, 0.5), figures.latency_p95_s = quantile(latencies, 0.95);
  figures.render_median_s = quantile(renders, 0.5);
  return figures;
}

}  // namespace likeness
