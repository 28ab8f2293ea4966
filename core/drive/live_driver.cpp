// See live_driver.h.
#include "core/drive/live_driver.h"

#include <algorithm>
#include <deque>
#include <exception>
#include <utility>

#include "core/base/fault_words.h"
#include "core/drive/drive_stream.h"

namespace likeness {
namespace {

constexpr double kRate_s = 2;       // over which the rate is counted
constexpr double kPicture_s = 0.2;  // between two pictures of the driver
constexpr int kPictureSide = 160;   // px, its longer side
constexpr int kMinRest = 5;         // pictures of a face from which a rest is learnt
// With fewer faces than that in this many pictures, over as many times the wanted seconds, learning the rest
// fails.
constexpr int kMaxLooks = 20;
constexpr double kLongest_rest = 3;

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

Image8 small(const Image8& rgb) {
  const double scale = std::min(1.0, double(kPictureSide) / std::max(rgb.width, rgb.height));
  return resize(rgb, std::max(1, int(rgb.width * scale)), std::max(1, int(rgb.height * scale)));
}

// The recent frame rate.
class Rate {
 public:
  double count(Clock::time_point now) {
    times_.push_back(now);
    while (seconds_between(times_.front(), now) > kRate_s) times_.pop_front();
    const double span = seconds_between(times_.front(), now);
    return span > 0.2 ? double(times_.size() - 1) / span : 0;
  }

 private:
  std::deque<Clock::time_point> times_;
};

}  // namespace

struct LiveDriver::Step {
  TrackedFrame tracked;
  std::optional<DrivenFrame> driven;  // empty while the rest is learnt
  std::optional<Error> unsettled;     // why the rest could not be learnt
  double rest_share = 1;
};

// The tracking thread's own: the tracker, and the mapping once the driver's rest is known.
class LiveDriver::Session {
 public:
  Session(LiveTracker tracker, const DriveSubject& avatar, const LiveOptions& options)
      : tracker_(std::move(tracker)), avatar_(avatar), options_(options) {}

  void begin_rest(double time_s) {
    tracker_.begin_rest();
    resting_since_s_ = time_s;
    looked_ = 0;
  }

  void set_gains(std::map<std::string, float> gains) {
    if (stream_ && !stream_->set_gains(gains)) return;  // of an action the model does not have
    options_.drive.gains = std::move(gains);
  }

  Step next(const CapturedFrame& frame) {
    Step step;
    step.tracked = tracker_.next(frame.rgb, frame.time_s, frame.focal_35mm);
    if (resting_since_s_) {
      const double rested_s = frame.time_s - *resting_since_s_;
      const bool enough = rested_s >= options_.rest_s && tracker_.rest_frames() >= kMinRest;
      if (enough || (++looked_ >= kMaxLooks && rested_s >= kLongest_rest * options_.rest_s))
        step.unsettled = settle();
      step.rest_share = resting_since_s_ ? std::clamp(rested_s / options_.rest_s, 0.0, 1.0) : 1;
    }
    if (stream_ && !resting_since_s_) step.driven = stream_->next(step.tracked);
    return step;
  }

 private:
  std::optional<Error> settle() {
    resting_since_s_.reset();
    auto driver = tracker_.settle();
    if (!driver) return driver.error();
    auto stream = DriveStream::create(std::move(*driver), avatar_, options_.drive);
    if (!stream) return stream.error();
    stream_ = std::move(*stream);
    return std::nullopt;
  }

  LiveTracker tracker_;
  DriveSubject avatar_;
  LiveOptions options_;
  std::unique_ptr<DriveStream> stream_;
  std::optional<double> resting_since_s_;
  int looked_ = 0;  // pictures since then
};

LiveDriver::LiveDriver(Open open, DriveSubject avatar, LiveOptions options, OnFrame on_frame)
    : open_(std::move(open)),
      avatar_(std::move(avatar)),
      options_(std::move(options)),
      on_frame_(std::move(on_frame)),
      tracker_([this](std::stop_token stop) { track(stop); }),
      reader_([this](std::stop_token stop) { read(stop); }) {}

LiveDriver::~LiveDriver() { stop(); }

LiveStatus LiveDriver::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void LiveDriver::stop() {
  reader_.request_stop();
  tracker_.request_stop();
}

void LiveDriver::rest_now() {
  const std::lock_guard lock(mutex_);
  rest_wanted_ = true;
}

void LiveDriver::set_gains(std::map<std::string, float> gains) {
  const std::lock_guard lock(mutex_);
  gains_wanted_ = std::move(gains);
}

void LiveDriver::record(bool on) {
  const std::lock_guard lock(mutex_);
  status_.recording = on;
}

std::vector<DrivenFrame> LiveDriver::take_recording() {
  const std::lock_guard lock(mutex_);
  status_.recorded_s = 0;
  return std::exchange(recorded_, {});
}

void LiveDriver::fail(Error error) {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    status_.state = LiveState::failed;
    status_.error = std::move(error);
  }
  changed_.notify_all();
}

void LiveDriver::read(std::stop_token stop) {
  const auto broke = [&](const char* what) {
    fail({ErrorCode::failed, std::string("Reading the pictures failed: ") + what + ".",
          "Close other programs and start again.", "live"});
  };
  try {
    auto source = open_();
    if (!source) return fail(source.error());
    {
      const std::lock_guard lock(mutex_);
      status_.source = (*source)->name();
    }
    {
      // A file's clock starts with its first picture: not before the tracker is ready.
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [this] { return ready_ || ended_; });
    }
    while (!stop.stop_requested()) {
      auto frame = (*source)->next(stop);
      if (!frame) return fail(frame.error());
      const bool end = !*frame;
      {
        const std::lock_guard lock(mutex_);
        if (status_.state == LiveState::failed) return;  // its pictures are no longer used
        if (end) {
          ended_ = true;
        } else {
          ++status_.captured;
          status_.dropped += waiting_.has_value();
          waiting_ = std::move(**frame);
        }
      }
      changed_.notify_all();
      if (end) return;
    }
  } catch (const std::exception& e) {
    broke(fault_words(e).c_str());
  }
}

std::optional<CapturedFrame> LiveDriver::newest(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [this] { return waiting_ || ended_; });
  if (stop.stop_requested()) return std::nullopt;
  return std::exchange(waiting_, std::nullopt);
}

void LiveDriver::note(const Step& step, const CapturedFrame& frame, double frames_per_second,
                      std::shared_ptr<const Image8> picture) {
  const std::lock_guard lock(mutex_);
  ++status_.tracked;
  status_.frames_per_second = frames_per_second;
  status_.track_s = seconds_between(frame.captured, Clock::now());
  if (picture) status_.picture = std::move(picture);
  if (status_.state == LiveState::failed) return;
  const bool lost = step.tracked.status == FrameStatus::lost;
  status_.reason = lost ? step.tracked.reason : "";
  status_.state = lost ? LiveState::lost : step.driven ? LiveState::driving : LiveState::resting;
  status_.rest_share = step.rest_share;
  if (step.unsettled) {
    status_.error = step.unsettled;
    rest_wanted_ = true;  // tried again until it succeeds
  } else if (step.driven) {
    status_.error.reset();
  }
  if (step.driven && !step.driven->bridged && status_.recording) {
    recorded_.push_back(*step.driven);
    status_.recorded_s = step.driven->time_s - recorded_.front().time_s;
  }
}

void LiveDriver::track(std::stop_token stop) {
  try {
    auto tracker = LiveTracker::create(*avatar_.model, options_.track);
    if (!tracker) return fail(tracker.error());
    Session session(std::move(*tracker), avatar_, options_);
    {
      const std::lock_guard lock(mutex_);
      ready_ = true;
    }
    changed_.notify_all();
    Rate rate;
    Clock::time_point shown{};
    while (auto frame = newest(stop)) {
      bool rest = false;
      std::optional<std::map<std::string, float>> gains;
      {
        const std::lock_guard lock(mutex_);
        rest = std::exchange(rest_wanted_, false);
        gains = std::exchange(gains_wanted_, std::nullopt);
      }
      if (rest) session.begin_rest(frame->time_s);
      if (gains) session.set_gains(std::move(*gains));
      const Step step = session.next(*frame);
      if (step.driven) on_frame_(*step.driven, frame->captured);
      const auto now = Clock::now();
      std::shared_ptr<const Image8> picture;
      if (seconds_between(shown, now) >= kPicture_s) {
        picture = std::make_shared<const Image8>(small(frame->rgb));
        shown = now;
      }
      note(step, *frame, rate.count(now), std::move(picture));
    }
  } catch (const std::exception& e) {
    fail({ErrorCode::failed, "Tracking failed: " + fault_words(e) + ".",
          "Close other programs and start again.", "live"});
  }
  const std::lock_guard lock(mutex_);
  if (status_.state != LiveState::failed) status_.state = LiveState::ended;
}

}  // namespace likeness
