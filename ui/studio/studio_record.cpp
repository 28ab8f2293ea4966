// A clip recorded from a webcam, and opened as any other: see studio.h.
#include <fmt/format.h>

#include <utility>

#include "ui/studio/studio.h"

namespace likeness::ui {

void Studio::start_recorder() {
  if (recorder_) return;
  take_drive();
  directing_.stop_playing();
  // Whoever was driving the avatar lets the camera go before it is opened anew; on the recorder's thread,
  // which may wait.
  std::shared_ptr<LiveDriver> driver = drive_.stop();
  WebcamAccess webcams = options_.webcams;
  webcams.list = [driver, list = std::move(webcams.list)]() mutable {
    driver.reset();
    return list();
  };
  driver.reset();
  request_picture();
  open_recorded_ = true;
  recorder_ = std::make_unique<ClipRecorder>(
      std::move(webcams), RecorderOptions{.folder = options_.projects, .record = options_.recording}, wake_);
}

void Studio::leave_recorder() {
  if (!recorder_ || records()) return;
  background_.retire(std::move(recorder_));
}

// Opens the clip that was recorded, once it is there.
void Studio::take_recording() {
  if (!recorder_) return;
  const RecorderStatus status = recorder_->status();
  if (status.state != RecorderState::kept) return;
  background_.retire(std::move(recorder_));
  if (const auto& fault = status.recording->broken_off)
    notices_.fail(
        {fault->code,
         fmt::format("The recording broke off after {:.0f} s. {}", status.recording->seconds, fault->what),
         "What was recorded until then is kept. " + fault->fix, fault->where});
  if (!open_recorded_) {
    notices_.message = "Recorded: " + status.clip.string();
    return;
  }
  open_clip(status.clip, Consent::not_asked, options_.project);
}

}  // namespace likeness::ui
