// A file played as if filmed live: see frame_source.h.
#include "core/video/frame_source.h"

#include <condition_variable>
#include <mutex>
#include <utility>

#include "core/video/decode.h"

namespace likeness {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLate_s = 0.1;        // a picture this late is skipped
constexpr double kLongestGap_s = 0.3;  // but a caller waits no longer than this for the next

class ClipSource : public FrameSource {
 public:
  ClipSource(VideoReader reader, std::string name) : reader_(std::move(reader)), name_(std::move(name)) {}

  Result<std::optional<CapturedFrame>> next(std::stop_token stop) override {
    const auto asked = Clock::now();
    while (!stop.stop_requested()) {
      auto frame = reader_.next();
      if (!frame) return frame.error();
      if (!*frame) return std::optional<CapturedFrame>();
      const double time_s = (*frame)->time_s;
      if (!start_) {
        start_ = Clock::now();
        first_s_ = time_s;
      }
      const auto due = *start_ + std::chrono::duration_cast<Clock::duration>(
                                     std::chrono::duration<double>(time_s - first_s_));
      const auto now = Clock::now();
      if (now > due + std::chrono::duration<double>(kLate_s)) {
        // Skipped to catch up; a clip that is never decoded in time still delivers one now and then.
        if (now < asked + std::chrono::duration<double>(kLongestGap_s)) continue;
        return std::optional(CapturedFrame{std::move((*frame)->rgb), time_s - first_s_, now, focal_35mm()});
      }
      wait_until(due, stop);
      if (!stop.stop_requested())
        return std::optional(CapturedFrame{std::move((*frame)->rgb), time_s - first_s_, due, focal_35mm()});
    }
    return std::optional<CapturedFrame>();
  }

  std::string name() const override { return name_; }

 private:
  double focal_35mm() const { return reader_.info().focal_35mm; }
  static void wait_until(Clock::time_point due, std::stop_token stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    stopped.wait_until(lock, stop, due, [] { return false; });
  }

  VideoReader reader_;
  std::string name_;
  std::optional<Clock::time_point> start_;
  double first_s_ = 0;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> open_clip_source(const std::filesystem::path& video) {
  auto reader = VideoReader::open(video);
  if (!reader) return reader.error();
  return std::unique_ptr<FrameSource>(
      std::make_unique<ClipSource>(std::move(*reader), video.filename().string()));
}

}  // namespace likeness
