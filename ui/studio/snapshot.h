// What the panels draw and what they ask for: a part of each session (project, direct, masks, study,
// recorder, exports) beside what all share. A panel sees a Snapshot, changes nothing, and returns Requests;
// the studio carries them out.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/export/write_film.h"
#include "ui/platform/settings.h"
#include "ui/studio/commands.h"
#include "ui/studio/direct_session.h"
#include "ui/studio/export_session.h"
#include "ui/studio/folder_list.h"
#include "ui/studio/mask_session.h"
#include "ui/studio/project_session.h"
#include "ui/studio/record_session.h"
#include "ui/studio/step_views.h"
#include "ui/studio/study_session.h"

namespace likeness::ui {

struct SystemStatus {
  int threads = 0;
  std::uint64_t memory = 0, available = 0;  // bytes in use by this program, and free
  std::string backend = "CPU";
};

struct Snapshot {
  ProjectView project;
  DirectView direct;
  MasksView masks;
  StudyView study;                         // the comparison with other methods
  std::optional<RecorderStatus> recorder;  // a webcam is on to record a clip
  ExportsView exports;
  std::array<StepView, kSteps.size()> steps;
  Step shown = Step::film;
  Situation situation;
  Settings settings;
  SystemStatus system;
  std::filesystem::path projects;  // folder of new ones
  bool projects_refuse = false;    // the error is that nothing can be put there
  std::optional<Error> error;      // of the last thing asked for
  std::string message;             // what the last thing asked for did

  const StepView& step(Step s) const { return steps[std::size_t(s)]; }
};

struct Requests {
  std::vector<Command> commands;
  std::optional<std::filesystem::path> open;  // a clip or a project folder
  std::optional<std::filesystem::path> forget_recent;
  std::optional<std::filesystem::path> projects;  // folder of new ones, from now on
  std::optional<Step> show;
  ProjectRequests project;
  DirectRequests direct;
  MaskRequests masks;
  StudyRequests study;
  RecordRequests recorder;
  ExportRequests exports;
  std::optional<Wanted> browse;  // for a file that the panel asks for
  bool dismiss_error = false, dismiss_message = false;

  void ask(Command command) { commands.push_back(command); }
};

}  // namespace likeness::ui
