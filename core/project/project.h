// A project folder: every stage's result, and what is stale.
//
//   NAME.likeness/   project.json  capture.json cameras.json track.json  frames/ masks/ regions/ plate.png
//   room.bin matte_report.json (how far masks and background can be trusted: core/matte/matte_report.h)
//                    detail.npz (what the given detail maps say: core/project/project_detail.h)
//                    track_first.json refits.json (spans fitted again: core/project/refits.h)
//                    decoded/ (what import found for align and fit: core/project/kept_decoding.h)
//                    corrections/ (strokes painted on masks: core/project/corrections.h)
//                    checkpoint.bin avatar.bin training_curve.json
//                    check.json (the capture check's verdict: core/check/checked_clip.h)
//                    clips/2 clips/3 ... (further clips of the person: core/project/further_clips.h)
//
// Only this library knows about the folder; the stages are free functions from files to files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/project/project_options.h"
#include "core/project/stage.h"

namespace likeness {

inline constexpr int kProjectVersion = 2;  // of project.json; 1 had two switches instead of the mode

enum class StageState { to_do, running, done, failed, stopped };

struct StageRecord {
  StageState state = StageState::to_do;
  std::string input_hash;  // of options and inputs; another one makes the result stale
  double seconds = 0;      // spent on it, over all runs
  std::string message;     // what was found, or why it failed
  std::vector<std::string> warnings;
  // Of the fit: what the whole clip's track was fitted from, spans fitted again and detail maps apart, while
  // track.json is that track, however the stage ended. Empty otherwise.
  std::string track_inputs{};
  // Of what it wrote, when it was done (core/project/stage_results.h): each file's content by its name, and
  // that of its pictures. Empty in projects from before these were kept.
  std::map<std::string, std::string> results{};
  std::string pictures_hash{};
};

// Whether the filmed person agreed to an avatar of themselves. Asked before anything is made of a clip.
enum class Consent {
  not_asked,      // nor answered: a program made the project, and nobody was there to ask
  own,            // the person who answered is the one in the clip
  given,          // somebody else, who agreed
  no_real_person  // the built-in demo
};

struct Project {
  std::filesystem::path folder;
  ProjectOptions options;
  Consent consent = Consent::not_asked;
  std::vector<int> further_clips;    // numbers of the folders in clips/, ascending
  std::filesystem::path first_clip;  // of a further clip: the folder of the project it belongs to, known to
                                     // whoever opened it, not stored
  std::array<StageRecord, kStages.size()> stages;

  StageRecord& record(Stage stage) { return stages[std::size_t(stage)]; }
  const StageRecord& record(Stage stage) const { return stages[std::size_t(stage)]; }
};

// Paths inside a project folder.
std::filesystem::path capture_path(const Project& project);
std::filesystem::path cameras_path(const Project& project);
std::filesystem::path track_path(const Project& project);
std::filesystem::path avatar_path(const Project& project);
std::filesystem::path checkpoint_path(const Project& project);
std::filesystem::path plate_path(const Project& project);
std::filesystem::path plate_known_path(const Project& project);  // absent: the whole plate was seen
std::filesystem::path plate_info_path(const Project& project);
// Absent: no moving camera filmed, or what was learnt does not show the room.
std::filesystem::path room_path(const Project& project);
std::filesystem::path matte_report_path(const Project& project);
std::filesystem::path detail_path(const Project& project);  // absent: no detail maps were given
std::filesystem::path regions_path(const Project& project);
std::filesystem::path corrections_path(const Project& project);  // absent: nobody painted on the masks

// Whether links in the place of a project's names are refused (core/project/own_names.h), or none is followed
// anyhow.
enum class Links { refused, ignored };

Result<Project> open_project(const std::filesystem::path& folder, Links links = Links::refused);
// Opens the project in `folder`, or makes one; `options` replace the stored ones either way.
Result<Project> open_or_create_project(const std::filesystem::path& folder, const ProjectOptions& options);
Result<void> save_project(const Project& project);
// The project as it is on the disk now, changed and written back, under its lock. An Error where another
// process works on it.
Result<Project> change_project(const std::filesystem::path& folder,
                               const std::function<void(Project&)>& change);

// Held while a process works on a project: two at once would overwrite each other's results. Ends with the
// process. Where the disk keeps no locks, work goes on without.
class ProjectLock {
 public:
  static Result<ProjectLock> acquire(const Project& project, Links links = Links::refused);
  ~ProjectLock();
  ProjectLock(ProjectLock&&) noexcept;
  ProjectLock& operator=(ProjectLock&&) = delete;
  // That nothing keeps a second process out, in a sentence for the user; empty: the lock holds.
  const std::string& note() const { return note_; }

 private:
  explicit ProjectLock(int fd) : fd_(fd) {}
  int fd_;
  std::string note_;
};

}  // namespace likeness
