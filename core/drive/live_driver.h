// An avatar driven live: one thread takes pictures from the source, another tracks the newest and carries it
// over. Pictures that arrive while one is being tracked are dropped, so that the delay never grows.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/drive/drive.h"
#include "core/drive/live_tracker.h"
#include "core/video/frame_source.h"

namespace likeness {

enum class LiveState {
  opening,  // the source
  resting,  // learning the driver's identity and rest
  driving,
  lost,   // no face: the avatar holds still
  ended,  // the source came to its end, or stop() was called
  failed
};

struct LiveStatus {
  LiveState state = LiveState::opening;
  std::string source;          // its name
  std::string reason;          // of a lost face
  std::optional<Error> error;  // of a failure; or why the rest could not be learnt, which is tried again
  double rest_share = 0;       // of the resting face learnt so far, 0..1
  int captured = 0, tracked = 0, dropped = 0;  // pictures
  double frames_per_second = 0;                // tracked, recently
  double track_s = 0;                          // of the last picture, from capture to the avatar's pose
  bool recording = false;
  double recorded_s = 0;
  std::shared_ptr<const Image8> picture;  // of the driver, small, a few times a second
};

struct LiveOptions {
  LiveTrackOptions track;
  DriveOptions drive;
  double rest_s = 1;  // of pictures from which the driver's identity and rest are learnt
};

class LiveDriver {
 public:
  using Clock = std::chrono::steady_clock;
  using Open = std::function<Result<std::unique_ptr<FrameSource>>()>;
  // Called for every driven frame, on the tracking thread: slow work here costs frames, not delay.
  using OnFrame = std::function<void(const DrivenFrame& frame, Clock::time_point captured)>;

  // avatar: refers to its model, which must outlive the driver; the driver is tracked with that model, too.
  LiveDriver(Open open, DriveSubject avatar, LiveOptions options, OnFrame on_frame);
  ~LiveDriver();  // stops and waits

  LiveStatus status() const;
  void stop();
  // "This is my resting face": it is learnt from the next second.
  void rest_now();
  void set_gains(std::map<std::string, float> gains);
  // Keeps what is driven from now on; turning it off keeps what has been recorded.
  void record(bool on);
  std::vector<DrivenFrame> take_recording();

 private:
  void read(std::stop_token stop);
  struct Step;
  class Session;
  void track(std::stop_token stop);
  void note(const Step& step, const CapturedFrame& frame, double frames_per_second,
            std::shared_ptr<const Image8> picture);
  std::optional<CapturedFrame> newest(std::stop_token stop);
  void fail(Error error);

  Open open_;
  DriveSubject avatar_;
  LiveOptions options_;
  OnFrame on_frame_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<CapturedFrame> waiting_;
  bool ready_ = false;  // to track: pictures are taken from then on
  bool ended_ = false, rest_wanted_ = true;
  std::optional<std::map<std::string, float>> gains_wanted_;
  std::vector<DrivenFrame> recorded_;
  LiveStatus status_;
  std::jthread tracker_, reader_;  // last: they stop before the other members are destroyed
};

}  // namespace likeness
