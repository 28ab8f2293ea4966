// The state of the program: the open project, what is at work, the acting. Free of windows and OpenGL; the
// window shows its snapshot and hands it the user's requests.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/priority.h"
#include "core/check/verdict.h"
#include "core/lab/study/model_study.h"
#include "core/project/damaged_project.h"
#include "core/synth/demo_capture.h"
#include "ui/studio/background.h"
#include "ui/studio/clip_recorder.h"
#include "ui/studio/directing.h"
#include "ui/studio/face_overlay.h"
#include "ui/studio/live_drive.h"
#include "ui/studio/session_context.h"
#include "ui/studio/snapshot.h"

namespace likeness::ui {

class Studio {
 public:
  // wake: called from any thread when there is something new to show.
  Studio(StudioOptions options, std::function<void()> wake);
  ~Studio();

  // Takes in what threads have finished. Call before each snapshot.
  void tick();
  Snapshot snapshot() const;
  WindowRequest apply(const Requests& requests);

  // Window size and place, to be remembered.
  void remember_window(int width, int height, bool maximised);
  void licences_were_shown() { settings_.licences_shown = true; }
  void save_settings();
  bool is_working() const;  // the project's stages, the demo, an export or a recording
  bool goes_on() const;     // and was not asked to stop
  bool computes() const;    // work that does not wait for its Continue
  const std::filesystem::path& folder() const { return open_.folder; }  // of the open project
  double patience_s() const;  // until the window should look again though nobody touched it
  // The picture is on the screen.
  void shown(const std::shared_ptr<const AvatarPicture>& picture) { drive_.shown(picture); }
  // Asks everything to stop and keep what it has.
  void stop_work();

 private:
  struct Saves;

  // Recorded, and on its way into the performance.
  struct Take {
    std::uint64_t number = 0;
    std::shared_ptr<const ProjectAvatar> avatar;  // that was driven
    std::shared_ptr<const std::vector<DrivenFrame>> frames;
    double rate = 25, at_s = 0;
    Performance keys() const;  // of a long take a while
  };

  WindowRequest carry_out(Command command);
  void open(const std::filesystem::path& path);
  void open_clip(const std::filesystem::path& clip, Consent consent, ProjectOptions options);
  void load(const std::filesystem::path& folder);
  void loaded(std::shared_ptr<const ProjectContents> contents, std::uint64_t masks_edit);
  void close_project();
  // change: of the options as they are on the disk by then.
  void start_pipeline(const std::function<void(ProjectOptions&)>& change, Stage last = Stage::train);
  // Fits a span again, or takes that back.
  void refit(const RefitSpan& span, bool again);
  void tell_refit();
  void start_demo();
  void start_check();
  void drop_check();
  Project latest_project() const;
  void start_export(ExportKind kind);
  void change_clips(const std::function<Result<std::string>(Project&)>& change);
  bool edit_options(const std::function<void(ProjectOptions&)>& change);  // false: could not be saved now
  // Of the masks (studio_masks.cpp).
  bool masking() const;  // they are shown
  void apply(const MaskRequests& requests);
  void correct(Command command);
  void show_mask();
  void save_strokes();
  void settle_strokes();
  void set_aside(int frame);
  void take_masks(bool first, std::uint64_t edit);
  std::uint64_t painted_edit() const { return masks_.edit() + attributes_.edit(); }
  bool paint(const MaskRequests& requests);  // whether anything changed
  bool change(const AttributeRequests& requests);
  Result<void> check_attribute(const std::string& name) const;  // on the frame shown
  MasksView masks_view() const;
  // Of the Direct step (studio_direct.cpp).
  WindowRequest direct(Command command);
  void apply(const DirectRequests& requests);
  void open_performance(const std::filesystem::path& file);
  void save_performance_as(const std::filesystem::path& file);
  void take_performance(const std::filesystem::path& folder);
  void save_performance(bool at_once);
  std::filesystem::path performance_path() const { return open_.folder / "performance.json"; }
  void edit_performance(std::string what, const std::function<void(Performance&)>& change);
  void start_driving(LiveDriver::Open open);
  std::optional<std::uint64_t> keep_take();  // its number, where something was recorded
  void take_drive();                         // what was recorded, into the performance
  void lay_takes();                          // the same at once, with those on their way
  void lay_take(const Performance& keys, double at_s);
  void request_picture();
  void read_clip_picture();
  void watch_solve();
  void show_frame(FramePicture Studio::*slot, int frame, bool overlay);
  // The comparison with other methods (studio_study.cpp).
  ModelStudyOptions study_options() const;
  bool studies() const;
  void open_study(bool open);
  void forecast_the_study();
  void read_study();
  void start_study();
  void take_study();
  void forget_study();
  void show_study();
  StudyView study_view() const;
  // Of a clip from a webcam (studio_record.cpp).
  void start_recorder();
  void leave_recorder();
  void take_recording();
  bool records() const { return recorder_ && is_recording(recorder_->status()); }
  void save_diagnostics();
  void relink(const std::filesystem::path& clip, bool or_open);
  void repair();
  void delete_person(bool keep_exports);

  const LoopsStepBack loops_step_back_;  // whatever is computed, the window comes first
  StudioOptions options_;
  std::function<void()> wake_;
  Settings settings_;
  Notices notices_;
  OpenProject open_;
  ShownStep shown_;
  std::uint64_t pictures_ = 0;
  const SessionContext context_{options_, wake_, background_, settings_, notices_, open_, shown_, pictures_};
  bool loading_ = false;
  std::optional<DamagedProject> damaged_;  // asked for, and not to be opened
  std::shared_ptr<const FaceOverlay> overlay_;
  Directing directing_;
  std::shared_ptr<Saves> saves_;  // of the performance
  std::uint64_t save_number_ = 0;
  std::shared_ptr<const Performance> saving_;  // queued or being written
  std::vector<Take> takes_;
  std::uint64_t take_number_ = 0;
  std::uint64_t moment_number_ = 0;
  std::uint64_t walks_ = 0;  // each other than the one before
  int view_px_ = 256;
  bool comparing_ = false;
  FramePicture clip_picture_, check_picture_, face_picture_, compare_picture_;
  Masks masks_;
  AttributePaint attributes_;
  // What the window last read or wrote of them: after it was made only work of the background, which runs in
  // order, touches it.
  using SavedAttributes = std::shared_ptr<const PaintedAttributes>;
  std::shared_ptr<SavedAttributes> attributes_saved_;
  MaskPicture mask_picture_;
  std::uint64_t masks_read_ = 0;                   // how often the project's were
  std::shared_ptr<const MaskSource> mask_source_;  // of the picture, or of one like it
  std::optional<Directing::Clock::time_point>
      strokes_changed_;  // and it was not yet seen what is stale by it
  std::uint64_t load_number_ = 0;
  ExportChoice export_choice_;
  std::array<StageState, kStages.size()> seen_states_{};
  JobState seen_pipeline_ = JobState::none;
  bool changing_clips_ = false;        // the list of clips is being written
  std::optional<RefitSpan> refit_;     // being fitted again, or taken back
  std::optional<double> finish_at_s_;  // the training is being stopped to be finished with this budget
  std::shared_ptr<const SolvingCameras> solving_;
  std::chrono::steady_clock::time_point solve_watched_;  // last
  AvatarRenderer renderer_;
  LiveDrive drive_{renderer_};
  std::shared_ptr<CaptureVerdict> checked_;  // being filled by the check
  std::shared_ptr<const CaptureVerdict> verdict_;
  bool deleting_ = false;
  bool study_open_ = false;
  StudyChoice study_choice_;
  std::optional<StudyForecast> study_forecast_;  // of the choice
  std::shared_ptr<const FinishedStudy> studied_;
  std::optional<Error> study_unreadable_;
  JobState seen_study_ = JobState::none;
  std::unique_ptr<Job> demo_, check_, study_;
  std::unique_ptr<ClipRecorder> recorder_;
  bool open_recorded_ = true;  // the clip, once it is there; not where the program ends
  ExportQueue exports_;
  std::unique_ptr<PipelineJob> pipeline_job_;
  Background background_;  // last: its deliveries use the rest
};

}  // namespace likeness::ui
