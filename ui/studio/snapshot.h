// What the panels draw and what they ask for. A panel sees a Snapshot, changes nothing, and returns Requests;
// the studio carries them out.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/check/verdict.h"
#include "core/drive/live_driver.h"
#include "core/export/write_film.h"
#include "core/project/damaged_project.h"
#include "ui/platform/settings.h"
#include "ui/studio/avatar_renderer.h"
#include "ui/studio/clip_recorder.h"
#include "ui/studio/commands.h"
#include "ui/studio/directing.h"
#include "ui/studio/export_order.h"
#include "ui/studio/export_queue.h"
#include "ui/studio/folder_list.h"
#include "ui/studio/job.h"
#include "ui/studio/masks.h"
#include "ui/studio/pipeline_job.h"
#include "ui/studio/project_contents.h"
#include "ui/studio/solving_cameras.h"
#include "ui/studio/step_views.h"
#include "ui/studio/study_page.h"

namespace likeness::ui {

// A picture of one frame of the clip, read in the background.
struct FramePicture {
  int frame = -1;            // that is asked for
  std::uint64_t number = 0;  // another one is another picture
  std::shared_ptr<const Image8> image;
  std::string missing;  // why there is none
};

// A frame's mask or the plate, drawn with the strokes after this change; its frame is the one that is drawn.
struct MaskPicture {
  FramePicture picture;
  MaskLook look = MaskLook::picture;
  std::uint64_t edit = 0;
};

// The avatar driven by a video or a webcam as it happens.
struct LiveView {
  bool on = false;
  LiveStatus status;
  // On the screen, of late: pictures a second, and the last one's time since its capture. 0: none came.
  double shown_per_second = 0, latency_s = 0;
  std::map<std::string, float> gains;  // per named action, those that are not 1
};

struct SystemStatus {
  int threads = 0;
  std::uint64_t memory = 0, available = 0;  // bytes in use by this program, and free
  std::string backend = "CPU";
};

struct Snapshot {
  bool loading = false;                             // a project is being read
  std::shared_ptr<const ProjectContents> contents;  // null: none is open
  std::optional<DamagedProject> damaged;            // the one asked for last, where it cannot be read
  std::array<StepView, kSteps.size()> steps;
  Step shown = Step::film;
  Situation situation;
  PipelineStatus pipeline;
  JobStatus demo;       // filming the demo person
  JobStatus exporting;  // the export at work, or the one that ended last
  std::vector<ExportItem> exports;
  JobStatus checking;  // the capture check, before anything is built
  std::shared_ptr<const SolvingCameras>
      solving;  // null: no camera's path is being solved, or none placed yet
  std::shared_ptr<const CaptureVerdict> verdict;  // null: the clip was not looked at since it was opened
  std::filesystem::path exported;                 // what the last finished export wrote
  ExportChoice export_choice;
  StudyView study;        // the comparison with other methods
  TrainingCurve curve;    // of the training at work, or of the last one
  bool deleting = false;  // a person is being deleted
  Settings settings;
  DirectingView directing;
  LiveView live;
  std::optional<RecorderStatus> recorder;  // a webcam is on to record a clip
  std::uint64_t moment = 0;                // number of what the picture is asked to show
  std::shared_ptr<const AvatarPicture> picture;
  bool rendering = false;
  bool comparing = false;
  FramePicture clip_picture, check_picture, face_picture, compare_picture;
  MasksView masks;
  MaskPicture mask_picture;
  SystemStatus system;
  std::optional<Error> error;  // of the last thing asked for
  std::string message;         // what the last thing asked for did

  const StepView& step(Step s) const { return steps[std::size_t(s)]; }
};

// Consent as answered: nullopt where it was not.
struct Requests {
  std::vector<Command> commands;
  std::optional<std::filesystem::path> open;  // a clip or a project folder
  std::optional<std::filesystem::path> forget_recent;
  std::optional<std::string> webcam;  // the device to record with; the same again: another try
  std::optional<Step> show;
  std::optional<Consent> consent;
  bool nobody_agreed = false;
  std::optional<std::filesystem::path> relink;    // where the clip is now
  std::optional<std::filesystem::path> add_clip;  // a further one of the same person
  std::optional<int> remove_clip;                 // a further one, by its number
  std::optional<bool> delete_person;              // true: the exports are kept
  std::optional<std::vector<int>> left_out;       // frames that shall not train
  std::optional<RefitSpan> refit, take_back;      // a span to be fitted again; to be as it was first fitted
  std::optional<int> check_frame, face_frame, compare_frame;
  MaskRequests masks;
  DirectRequests direct;
  std::optional<std::filesystem::path> open_performance, save_performance, drive_video;
  std::optional<std::map<std::string, float>> gains;
  std::optional<int> view_px;  // size of the avatar's picture on the screen
  std::optional<double> budget_s;
  std::optional<int> picture_size;
  std::optional<ExportChoice> export_choice;
  std::optional<int> stop_export, retry_export, forget_export;  // numbers of the queue's items
  std::optional<StudyChoice> study_choice;
  bool close_study = false;
  std::optional<Wanted> browse;  // for a file that the panel asks for
  bool dismiss_error = false, dismiss_message = false;

  void ask(Command command) { commands.push_back(command); }
};

}  // namespace likeness::ui
