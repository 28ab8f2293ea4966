// See record_session.h.
#include "ui/studio/record_session.h"

#include <fmt/format.h>

#include <utility>

#include "core/video/finish_film.h"

namespace likeness::ui {

void RecordSession::finish_abandoned() {
  recovery_ = std::jthread([context = context_, folder = context_.projects](std::stop_token stop) {
    const auto films = finish_abandoned_films(folder, stop);
    if (films.empty()) return;
    context.background.run("recordings", [context, films](std::stop_token) {
      return Background::Delivery([context, films] {
        context.notices.message =
            fmt::format("A recording that was broken off is now in {}{}.", films.front().string(),
                        films.size() > 1 ? fmt::format(", and {} more beside it", films.size() - 1) : "");
      });
    });
  });
}

void RecordSession::start(std::unique_ptr<LiveDriver> driver) {
  if (recorder_) return;
  // The driver is destroyed on the recorder's thread, which may wait for it.
  WebcamAccess webcams = context_.options.webcams;
  webcams.list = [driver = std::shared_ptr<LiveDriver>(std::move(driver)),
                  list = std::move(webcams.list)]() mutable {
    driver.reset();
    return list();
  };
  opens_ = true;
  recorder_ = std::make_unique<ClipRecorder>(
      std::move(webcams), RecorderOptions{.folder = context_.projects, .record = context_.options.recording},
      context_.wake);
}

std::optional<std::filesystem::path> RecordSession::tick() {
  if (!recorder_) return std::nullopt;
  const RecorderStatus status = recorder_->status();
  if (status.state != RecorderState::kept) return std::nullopt;
  context_.background.retire(std::move(recorder_));
  if (const auto& fault = status.recording->interruption)
    context_.notices.fail({fault->code,
                           fmt::format("The recording was cut short after {:.0f} s. {}",
                                       status.recording->seconds, fault->what),
                           "What was recorded by then is kept. " + fault->fix, fault->where});
  if (opens_) return status.clip;
  context_.notices.message = "Recorded: " + status.clip.string();
  return std::nullopt;
}

std::optional<RecorderStatus> RecordSession::view() const {
  return recorder_ ? std::optional(recorder_->status()) : std::nullopt;
}

void RecordSession::apply(const RecordRequests& requests) {
  if (requests.webcam && recorder_) recorder_->choose(*requests.webcam);
}

void RecordSession::record() {
  if (recorder_) recorder_->record();
}

void RecordSession::finish() {
  if (recorder_) recorder_->finish();
}

void RecordSession::discard() {
  if (recorder_) recorder_->discard();
}

void RecordSession::leave() {
  if (recorder_ && !is_recording()) context_.background.retire(std::move(recorder_));
}

void RecordSession::stop() {
  if (!is_recording()) return;
  opens_ = false;
  recorder_->finish();
}

bool RecordSession::is_recording() const { return recorder_ && ui::is_recording(recorder_->status()); }

bool RecordSession::goes_on() const {
  return recorder_ && recorder_->status().state == RecorderState::recording;
}

}  // namespace likeness::ui
