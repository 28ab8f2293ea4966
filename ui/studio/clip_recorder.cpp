// See clip_recorder.h.
#include "ui/studio/clip_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "core/base/fault_words.h"

namespace likeness::ui {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

constexpr int kPictureSide = 800;       // px: the window shows no more
constexpr double kBetween_s = 1 / 15.;  // between shown pictures: encoding needs the processor, too

Image8 small(const Image8& rgb) {
  const double scale = std::min(1.0, double(kPictureSide) / std::max(rgb.width, rgb.height));
  if (scale == 1) return rgb;
  return resize(rgb, std::max(1, int(rgb.width * scale)), std::max(1, int(rgb.height * scale)));
}

}  // namespace

WebcamAccess real_webcams() {
  return {list_webcams, [](const std::string& device) { return open_webcam(device, kToRecord); }};
}

bool is_recording(const RecorderStatus& status) {
  return status.state == RecorderState::recording || status.state == RecorderState::finishing;
}

fs::path clip_path(const fs::path& folder, std::time_t now) {
  std::tm local{};
  ::localtime_r(&now, &local);
  const std::string time =
      fmt::format("clip-{:04}-{:02}-{:02}-{:02}{:02}{:02}", local.tm_year + 1900, local.tm_mon + 1,
                  local.tm_mday, local.tm_hour, local.tm_min, local.tm_sec);
  for (int number = 1;; ++number) {
    const std::string name = number == 1 ? time : fmt::format("{}-{}", time, number);
    std::error_code ignored;
    if (!fs::exists(folder / (name + ".mp4"), ignored) && !fs::exists(folder / (name + ".likeness"), ignored))
      return folder / (name + ".mp4");
  }
}

ClipRecorder::ClipRecorder(WebcamAccess webcams, RecorderOptions options, std::function<void()> wake)
    : webcams_(std::move(webcams)), options_(std::move(options)), wake_(std::move(wake)) {
  status_.longest_s = options_.record.longest_s;
  thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
}

ClipRecorder::~ClipRecorder() { stop(); }

RecorderStatus ClipRecorder::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void ClipRecorder::choose(const std::string& device) {
  {
    const std::lock_guard lock(mutex_);
    if (is_recording(status_) || status_.state == RecorderState::kept) return;
    status_.device = device;
    status_.state = RecorderState::opening;
    status_.picture.reset();
    status_.error.reset();
    chosen_ = true;
  }
  changed_.notify_all();
}

void ClipRecorder::record() {
  const std::lock_guard lock(mutex_);
  if (status_.state != RecorderState::watching) return;
  status_.state = RecorderState::recording;
  status_.recorded_s = 0;
  recorded_ = std::stop_source();
  record_wanted_ = true, discarded_ = false;
}

void ClipRecorder::finish() {
  std::stop_source recorded;
  {
    const std::lock_guard lock(mutex_);
    if (status_.state != RecorderState::recording) return;
    status_.state = RecorderState::finishing;
    recorded = recorded_;
  }
  recorded.request_stop();
}

void ClipRecorder::discard() {
  {
    const std::lock_guard lock(mutex_);
    if (status_.state == RecorderState::recording) discarded_ = true;
  }
  finish();
}

void ClipRecorder::stop() { thread_.request_stop(); }

void ClipRecorder::run(std::stop_token stop) {
  for (;;) {
    std::string device;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return chosen_; })) return;
      chosen_ = false;
      device = status_.device;
    }
    try {
      use_camera(device, stop);
    } catch (const std::exception& e) {  // usually for want of memory
      fail({ErrorCode::failed, "The recording was cut short: " + fault_words(e) + ".",
            "Close other programs and try again.", ""});
    }
    const std::lock_guard lock(mutex_);
    if (!status_.recording) continue;
    if (discarded_) {  // while the camera was being released: open it again
      std::error_code ignored;
      fs::remove(status_.clip, ignored);
      status_.recording.reset();
      status_.clip.clear();
      status_.state = RecorderState::opening;
      chosen_ = true;
      continue;
    }
    status_.state = RecorderState::kept;
    wake_();
    return;
  }
}

// Returns once the camera is released: for another one, after a failure, at the end.
void ClipRecorder::use_camera(const std::string& device, std::stop_token stop) {
  std::vector<Webcam> webcams = webcams_.list();
  {
    const std::lock_guard lock(mutex_);
    status_.webcams = std::move(webcams);
  }
  auto source = webcams_.open(device);
  if (!source) return fail(source.error());
  while (watch(**source, stop) && film(**source, stop)) {
  }
}

// True if pictures are to be kept from now on.
bool ClipRecorder::watch(FrameSource& source, std::stop_token stop) {
  while (!stop.stop_requested()) {
    {
      const std::lock_guard lock(mutex_);
      if (chosen_) return false;
      if (std::exchange(record_wanted_, false)) return true;
    }
    auto next = source.next(stop);
    if (!next) {
      fail(next.error());
      return false;
    }
    if (!*next) break;
    show(**next);
    const std::lock_guard lock(mutex_);
    if (status_.state == RecorderState::opening && !chosen_) {
      status_.state = RecorderState::watching;
      wake_();
    }
  }
  if (!stop.stop_requested())
    fail({ErrorCode::failed, "The webcam sends no more pictures.",
          "Close other programs that use it, or plug it in again.", source.name()});
  return false;
}

// True if nothing was kept, so that the camera stays open.
bool ClipRecorder::film(FrameSource& source, std::stop_token stop) {
  std::stop_source recorded;
  fs::path clip;
  {
    const std::lock_guard lock(mutex_);
    recorded = recorded_;
    clip = status_.clip = clip_path(options_.folder, options_.clock());
  }
  const std::stop_callback both(stop, [recorded]() mutable { recorded.request_stop(); });
  std::optional<double> start_s;
  const auto seen = [&](const CapturedFrame& picture) {
    if (!start_s) start_s = picture.time_s;
    {
      const std::lock_guard lock(mutex_);
      status_.recorded_s = picture.time_s - *start_s;
    }
    show(picture);
  };
  const auto recording = record_clip(source, clip, options_.record, seen, recorded.get_token());
  std::unique_lock lock(mutex_);
  const bool cancelled = !recording && recording.error().code == ErrorCode::cancelled;
  if (discarded_ || cancelled) {  // cancelled: stopped before the first picture
    if (recording) {
      std::error_code ignored;
      fs::remove(clip, ignored);
    }
    status_.state = RecorderState::watching;
    status_.clip.clear();
    wake_();
    return true;
  }
  if (recording) {
    status_.recording = *recording;
    return false;
  }
  lock.unlock();
  fail(recording.error());
  return false;
}

void ClipRecorder::show(const CapturedFrame& picture) {
  const auto now = Clock::now();
  if (shown_ && std::chrono::duration<double>(now - *shown_).count() < kBetween_s) return;
  if (picture.rgb.empty() || picture.rgb.channels != 3) return;
  shown_ = now;
  auto image = std::make_shared<const Image8>(small(picture.rgb));
  {
    const std::lock_guard lock(mutex_);
    if (!chosen_) status_.picture = std::move(image);
  }
  wake_();
}

void ClipRecorder::fail(Error error) {
  {
    const std::lock_guard lock(mutex_);
    if (chosen_) return;  // another camera has been chosen already
    record_wanted_ = false;
    status_.state = RecorderState::failed;
    status_.picture.reset();
    status_.error = std::move(error);
  }
  wake_();
}

}  // namespace likeness::ui
