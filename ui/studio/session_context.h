// What the sessions of the studio share: the project that is open, the step that is shown, what is said to
// the user, the thread that reads and writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/base/result.h"
#include "ui/platform/settings.h"
#include "ui/studio/background.h"
#include "ui/studio/pipeline_job.h"
#include "ui/studio/project_contents.h"
#include "ui/studio/step_views.h"
#include "ui/studio/studio_options.h"

namespace likeness::ui {

struct OpenProject {
  std::filesystem::path folder;                     // of the open or opening project; empty: there is none
  std::shared_ptr<const ProjectContents> contents;  // null: none is open
  PipelineStatus pipeline;                          // of the last tick
  bool look_only = false;  // another window shows it, too: nothing is saved from here

  bool is_running() const { return is_working(pipeline.job); }  // its stages are at work
  bool may_change() const { return !is_running() && !look_only; }
};

struct ShownStep {
  Step step = Step::film;
  bool follow = true;  // show the step at work
};

// For the status bar and the error box.
struct Notices {
  std::optional<Error> error;  // of the last thing asked for
  std::string message;         // what the last thing asked for did

  void fail(Error reason) { error = std::move(reason); }
};

// All of it outlives the sessions. Used on the window's thread alone, but for `wake`.
struct SessionContext {
  const StudioOptions& options;
  const std::function<void()>& wake;  // called from any thread when there is something new to show
  Background& background;
  Settings& settings;
  Notices& notices;
  const OpenProject& open;
  ShownStep& shown;
  std::uint64_t& pictures;                // pictures of frames so far; each takes the next number
  const std::filesystem::path& projects;  // folder of new ones
};

// Where that fails, the message says so.
inline void save_settings(const SessionContext& context) {
  if (const auto saved = write_settings(context.options.settings, context.settings); !saved)
    context.notices.message = saved.error().what;
}

}  // namespace likeness::ui
