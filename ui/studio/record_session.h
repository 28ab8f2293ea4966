// The studio's recorder: a clip from a webcam, until there is a file that can be opened as any other.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "core/drive/live_driver.h"
#include "ui/studio/clip_recorder.h"
#include "ui/studio/session_context.h"

namespace likeness::ui {

// What the panels ask for; the panels see a RecorderStatus (clip_recorder.h).
struct RecordRequests {
  std::optional<std::string> webcam;  // the device to record with; the same again: another try
};

class RecordSession {
 public:
  explicit RecordSession(const SessionContext& context) : context_(context) {}

  // Finishes recordings that a killed studio left in the folder of new projects, on a thread of its own: a
  // long one is copied for a while. Once, when the window is there.
  void finish_abandoned();
  void end_recovery() { recovery_ = {}; }  // before what it tells is gone

  // driver: of an avatar; it lets its camera go before one is opened to record. Null: nothing is driven.
  void start(std::unique_ptr<LiveDriver> driver);
  // The clip that was recorded, once, when it is there and to be opened.
  std::optional<std::filesystem::path> tick();
  std::optional<RecorderStatus> view() const;  // nullopt: no camera is on
  void apply(const RecordRequests& requests);
  void record();
  void finish();
  void discard();
  void leave();  // without a clip; not while it records
  void stop();   // keeps what is recorded, and does not open it

  bool is_on() const { return recorder_ != nullptr; }
  bool is_recording() const;  // or brings the clip to its end
  bool goes_on() const;       // it records, and was not asked to end

 private:
  const SessionContext context_;
  std::unique_ptr<ClipRecorder> recorder_;
  bool opens_ = true;  // the clip, once it is there; not where the program ends
  std::jthread recovery_;
};

}  // namespace likeness::ui
