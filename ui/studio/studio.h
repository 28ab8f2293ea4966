// The state of the program, put together: a session each for the project, the Direct step, the masks, the
// comparison, the recorder and the exports. Free of windows and OpenGL; the window shows its snapshot and
// hands it the user's requests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "core/base/priority.h"
#include "ui/studio/sessions.h"
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
  bool is_working() const;  // the project's stages, the demo, an export, a comparison or a recording
  bool goes_on() const;     // and was not asked to stop
  bool computes() const;    // work that does not wait for its Continue
  const std::filesystem::path& folder() const { return open_.folder; }  // of the open project
  const std::filesystem::path& projects() const { return projects_; }   // folder of new ones
  double patience_s() const;  // until the window should look again though nobody touched it
  // The picture is on the screen.
  void shown(const std::shared_ptr<const AvatarPicture>& picture) { direct_.shown(picture); }
  // Asks everything to stop and keep what it has.
  void stop_work();

 private:
  ProjectNeighbours neighbours();
  void open(const std::filesystem::path& path);
  void show(Step step);
  void choose_projects(const std::filesystem::path& folder);
  bool projects_refuse() const;

  const LowPriorityLoops loops_step_back_;  // whatever is computed, the window comes first
  const StudioOptions options_;
  const std::function<void()> wake_;
  Settings settings_;
  Notices notices_;
  OpenProject open_;
  ShownStep shown_;
  std::uint64_t pictures_ = 0;
  std::filesystem::path projects_;
  const SessionContext context_{options_, wake_,  background_, settings_, notices_,
                                open_,    shown_, pictures_,   projects_};
  ProjectSession project_{context_, open_, neighbours()};
  DirectSession direct_{context_};
  MaskSession masks_{context_, [this] { project_.read_again(); }};
  StudySession study_{context_};
  RecordSession recorder_{context_};
  ExportSession exports_{context_};
  const Sessions sessions_{project_, direct_, masks_, study_, recorder_, exports_, context_};
  Background background_;  // last: its deliveries use the rest
};

}  // namespace likeness::ui
