// A clip recorded from a webcam while its picture is watched. One thread opens the camera, takes its pictures
// and encodes them; the window sees a status.
#pragma once

#include <condition_variable>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "core/base/result.h"
#include "core/video/frame_source.h"
#include "core/video/record.h"
#include "core/video/webcam.h"

namespace likeness::ui {

// Where pictures come from. Both are called on the recorder's thread.
struct WebcamAccess {
  std::function<std::vector<Webcam>()> list;
  // device: empty = the first there is.
  std::function<Result<std::unique_ptr<FrameSource>>(const std::string& device)> open;
};
WebcamAccess real_webcams();

enum class RecorderState {
  opening,    // the camera
  watching,   // pictures are shown, none is kept
  recording,  // they are kept
  finishing,  // the clip is brought to its end
  kept,       // the clip is there, and the camera is let go
  failed      // another camera, or the same again, can be chosen
};

struct RecorderStatus {
  RecorderState state = RecorderState::opening;
  std::vector<Webcam> webcams;
  std::string device;                     // asked for; empty: the first there is
  std::shared_ptr<const Image8> picture;  // the newest, small, a few times a second; null: none came yet
  double recorded_s = 0;
  double longest_s = 0;                // it ends by itself after so long
  std::filesystem::path clip;          // being recorded, or kept
  std::optional<Recording> recording;  // of a kept clip
  std::optional<Error> error;          // of a failure
};
// Pictures are being kept, or the clip is being brought to its end.
bool is_recording(const RecorderStatus& status);

struct RecorderOptions {
  std::filesystem::path folder;  // of the clips; made if it is not there
  RecordOptions record;
  std::function<std::time_t()> clock = [] { return std::time(nullptr); };  // names the clips
};

// A name for a clip by the time of its recording that neither a file nor a project in the folder has: what
// was recorded never counts as the clip of another one's project.
std::filesystem::path clip_path(const std::filesystem::path& folder, std::time_t now);

class ClipRecorder {
 public:
  // wake: called from the recorder's thread when there is something new to show.
  ClipRecorder(WebcamAccess webcams, RecorderOptions options, std::function<void()> wake);
  ~ClipRecorder();  // stops and waits; a clip that is being recorded is kept

  RecorderStatus status() const;
  void choose(const std::string& device);  // not while it records; the same again: another try
  void record();                           // where pictures are watched; nothing otherwise
  void finish();                           // the recording; it is kept
  void discard();                          // the recording; the camera stays on
  void stop();                             // as the destructor, without waiting

 private:
  void run(std::stop_token stop);
  void use_camera(const std::string& device, std::stop_token stop);
  bool watch(FrameSource& source, std::stop_token stop);
  bool film(FrameSource& source, std::stop_token stop);
  void show(const CapturedFrame& picture);
  void fail(Error error);

  const WebcamAccess webcams_;
  const RecorderOptions options_;
  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  RecorderStatus status_;
  bool chosen_ = true;          // a camera is to be opened
  bool record_wanted_ = false;  // pictures are to be kept from the next one on
  bool discarded_ = false;      // of the recording
  std::stop_source recorded_;   // ends the recording
  std::optional<std::chrono::steady_clock::time_point> shown_;  // when a picture last was
  std::jthread thread_;                                         // last: it stops before the rest goes
};

}  // namespace likeness::ui
