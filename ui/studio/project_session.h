// The studio's project: what is open, read and closed; its clips, choices and consent; its stages at work,
// the capture check before them, and the demo that becomes a project.
#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/camera/camera.h"
#include "core/check/checked_clip.h"
#include "core/project/damaged_project.h"
#include "core/project/window_lock.h"
#include "ui/studio/face_overlay.h"
#include "ui/studio/frame_picture.h"
#include "ui/studio/session_context.h"
#include "ui/studio/solving_cameras.h"

namespace likeness::ui {

// For the panels.
struct ProjectView {
  bool loading = false;                             // a project is being read, and none is open
  std::shared_ptr<const ProjectContents> contents;  // null: none is open
  std::optional<DamagedProject> damaged;            // the one asked for last, where it cannot be read
  PipelineStatus pipeline;
  std::optional<std::filesystem::path> elsewhere;  // the one asked for last, where another window shows it
  bool look_only = false;                          // at the open one, as another window shows it, too
  JobStatus demo;                                  // filming the demo person
  JobStatus checking;                              // the capture check, before anything is built
  // Null: no camera's path is being solved, or none placed yet.
  std::shared_ptr<const SolvingCameras> solving;
  // Of the last look at the clip, or null: the verdict, and what was found of camera, mask and parts.
  std::shared_ptr<const CaptureVerdict> verdict;
  std::shared_ptr<const ClipFacts> checked;
  bool can_undo_camera = false, can_redo_camera = false;  // the choice of what the camera does
  TrainingCurve curve;                                    // of the training at work, or of the last one
  bool deleting = false;                                  // a person is being deleted
  FramePicture clip_picture, check_picture, face_picture;
};

// What the panels ask for of the open project.
struct ProjectRequests {
  std::optional<Consent> consent;  // as answered
  std::optional<bool> look_only;   // at the project that another window shows; false: not even that
  bool nobody_agreed = false;
  std::optional<std::filesystem::path> relink;    // where the clip is now
  std::optional<std::filesystem::path> add_clip;  // a further one of the same person
  std::optional<int> remove_clip;                 // a further one, by its number
  std::optional<bool> delete_person;              // true: the exports are kept
  std::optional<std::vector<int>> left_out;       // frames that shall not train
  std::optional<std::vector<int>> rest_frames;    // that show the resting face; empty: found by the fit
  std::optional<RefitSpan> refit, take_back;      // a span to be fitted again; to be as it was first fitted
  std::optional<int> check_frame, face_frame;
  std::optional<double> budget_s;
  std::optional<int> picture_size;
  // What the camera does, by the user's word; nullopt inside: found out.
  std::optional<std::optional<CameraKind>> camera_kind;
};

// A look at the clip, at work or done.
struct ClipCheck {
  CheckedClip found;
  Result<void> kept;  // in the project
};

struct ProjectReading {
  bool first = false;       // since it was opened
  bool new_avatar = false;  // another than was there before
};

// What the rest of the studio does when something becomes of the project, and what must be known of it. All
// are set; called on the window's thread.
struct ProjectNeighbours {
  std::function<void()> reading_begins;  // changes from now on are not in what will be read
  std::function<void(const ProjectReading&)> was_read;
  std::function<void()> closing;       // while it is still open
  std::function<void()> run_begins;    // its stages are about to read the project's files
  std::function<void()> run_began;     // and they do
  std::function<bool()> are_working;   // an export, a comparison or a recording
  std::function<bool()> is_comparing;  // methods are being compared
};

// A training's budget as chosen now, in place of a number of steps.
void choose_budget(ProjectOptions& options, double budget_s);

class ProjectSession {
 public:
  // open: the project of the context, which this session alone changes.
  ProjectSession(const SessionContext& context, OpenProject& open, ProjectNeighbours neighbours)
      : context_(context), open_(open), neighbours_(std::move(neighbours)) {}

  void tick();
  ProjectView view() const;
  void apply(const ProjectRequests& requests);

  // A project's folder or a file in it, or a clip: a new project's, or the one that the open project misses.
  void open(const std::filesystem::path& path);
  void open_clip(const std::filesystem::path& clip, Consent consent);
  // That could not become a project where new ones go; another folder was chosen.
  void open_waiting_clip();
  void read_again();  // the open project's folder
  void reading_broke_off() { loading_ = false; }
  void close();
  void repair();
  void dismiss_damage() { damaged_.reset(); }
  // With the records of a run that may be newer than the last reading of the folder.
  Project latest() const;

  void make_avatar();
  void train_longer();
  void finish_training();  // with what is learnt
  void check_clip();
  void film_demo();
  void undo_camera();  // the last choice of what the camera does
  void redo_camera();
  // The stages and the demo.
  void pause();
  void go_on();
  void stop();
  void stop_all();  // and the check

  bool is_working() const;  // stages or demo
  bool computes() const;    // and they do not wait for their Continue
  bool goes_on() const;     // and were not asked to stop
  bool is_filming_demo() const;

 private:
  void read(const std::filesystem::path& folder, bool look_only = false);
  void was_read(std::shared_ptr<const ProjectContents> contents);
  void answer_consent(Consent consent);
  void refuse_consent();
  void relink(const std::filesystem::path& clip, bool or_open);
  void delete_person(bool keep_exports);
  void change_clips(const std::function<Result<std::string>(Project&)>& change);
  bool edit_options(const std::function<void(ProjectOptions&)>& change);  // false: could not be saved now
  void leave_out(const std::vector<int>& frames);
  void name_rest(const std::vector<int>& frames);
  void choose_camera(std::optional<CameraKind> kind);
  bool set_camera(std::optional<CameraKind> kind);
  void show_check_frame(int frame);
  void show_face_frame(int frame);

  // Of the work (project_work.cpp).
  // change: of the options as they are on the disk by then.
  void start_run(const std::function<void(ProjectOptions&)>& change, Stage last = Stage::train);
  void refit(const RefitSpan& span, bool again);  // or takes that back
  void report_refit();
  void drop_check();
  void watch_solve();
  void follow_stages();
  void take_demo();

  const SessionContext context_;
  OpenProject& open_;
  const ProjectNeighbours neighbours_;
  bool loading_ = false;
  std::uint64_t readings_ = 0;
  std::optional<DamagedProject> damaged_;  // asked for, and not to be opened
  std::optional<std::filesystem::path> elsewhere_;
  std::shared_ptr<const WindowLock> window_;  // of the open project; null: it is only looked at
  std::optional<std::pair<std::filesystem::path, Consent>> waiting_clip_;
  bool changing_clips_ = false;  // the list of clips is being written
  bool deleting_ = false;
  std::shared_ptr<const FaceOverlay> overlay_;
  FramePicture clip_picture_, check_picture_, face_picture_;
  // What the camera did by the choices before the present one, and after it, the nearest last.
  std::vector<std::optional<CameraKind>> earlier_cameras_, later_cameras_;

  std::array<StageState, kStages.size()> seen_states_{};
  JobState seen_run_ = JobState::none;
  std::optional<RefitSpan> refit_;     // being fitted again, or taken back
  std::optional<double> finish_at_s_;  // the training is being stopped to be finished with this budget
  std::shared_ptr<const SolvingCameras> solving_;
  std::chrono::steady_clock::time_point solve_watched_;  // last
  std::shared_ptr<ClipCheck> checking_;                  // being filled by the check
  std::shared_ptr<const CheckedClip> checked_;           // newer than the contents' own; or null
  std::unique_ptr<Job> demo_, check_;
  std::unique_ptr<PipelineJob> run_;
};

}  // namespace likeness::ui
