// project.json and the folder's names: see project.h.
#include "core/project/project.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/project/consent.h"
#include "core/project/option_table.h"
#include "core/project/options_json.h"
#include "core/project/own_names.h"
#include "core/project/private_folder.h"

namespace likeness {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::array<const char*, 5> kStateNames{"to_do", "running", "done", "failed", "stopped"};

constexpr std::array<const char*, 4> kConsentNames{"not_asked", "own", "given", "no_real_person"};

// An answer that this version does not know counts as not asked.
Consent consent_from_json(const json& j) {
  const std::string answer = j.value("consent", kConsentNames[0]);
  for (std::size_t i = 0; i < kConsentNames.size(); ++i) {
    if (answer == kConsentNames[i]) return Consent(i);
  }
  return Consent::not_asked;
}

// Numbers that name no folder are dropped.
std::vector<int> further_clips_from_json(const json& j) {
  constexpr std::int64_t kFirst = 2, kLast = 1'000'000;
  std::vector<int> numbers;
  if (!j.contains("further_clips")) return numbers;
  for (const json& number : j.at("further_clips")) {
    if (!number.is_number_integer()) continue;
    const auto value = number.get<std::int64_t>();
    if (value >= kFirst && value <= kLast) numbers.push_back(int(value));
  }
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

json to_json(const StageRecord& record) {
  json j{{"state", kStateNames[std::size_t(record.state)]},
         {"input_hash", record.input_hash},
         {"seconds", record.seconds},
         {"message", record.message},
         {"warnings", record.warnings}};
  if (!record.track_inputs.empty()) j["track_inputs"] = record.track_inputs;
  if (!record.results.empty()) j["results"] = record.results;
  if (!record.pictures_hash.empty()) j["pictures_hash"] = record.pictures_hash;
  return j;
}

StageRecord record_from_json(const json& j) {
  StageRecord record;
  const std::string state = j.at("state");
  for (std::size_t i = 0; i < kStateNames.size(); ++i) {
    if (state == kStateNames[i]) record.state = StageState(i);
  }
  record.input_hash = j.at("input_hash");
  record.seconds = j.at("seconds");
  record.message = j.at("message");
  record.warnings = j.at("warnings").get<std::vector<std::string>>();
  record.track_inputs = j.value("track_inputs", "");
  record.results = j.value("results", std::map<std::string, std::string>());
  record.pictures_hash = j.value("pictures_hash", "");
  return record;
}

fs::path project_file(const fs::path& folder) { return folder / "project.json"; }

// The clip and models stay where they are; the project remembers them by absolute path, whatever folder a
// later command starts from.
fs::path remembered(const fs::path& path) {
  std::error_code failure;
  const fs::path absolute = path.empty() ? path : fs::absolute(path, failure).lexically_normal();
  return failure ? path : absolute;
}

Error unreadable(const fs::path& folder, std::string_view why) {
  const std::string file = project_file(folder).string();
  return {ErrorCode::bad_input, fmt::format("{} cannot be read: {}.", file, why),
          fmt::format("Put a good copy of this file back, or let it be made again from the rest: likeness "
                      "repair {}",
                      folder.string()),
          file};
}

}  // namespace

fs::path capture_path(const Project& project) { return project.folder / "capture.json"; }
fs::path cameras_path(const Project& project) { return project.folder / "cameras.json"; }
fs::path track_path(const Project& project) { return project.folder / "track.json"; }
fs::path avatar_path(const Project& project) { return project.folder / "avatar.bin"; }
fs::path checkpoint_path(const Project& project) { return project.folder / "checkpoint.bin"; }
fs::path plate_path(const Project& project) { return project.folder / "plate.png"; }
fs::path plate_known_path(const Project& project) { return project.folder / "plate_known.png"; }
fs::path plate_info_path(const Project& project) { return project.folder / "plate.json"; }
fs::path room_path(const Project& project) { return project.folder / "room.bin"; }
fs::path matte_report_path(const Project& project) { return project.folder / "matte_report.json"; }
fs::path detail_path(const Project& project) { return project.folder / "detail.npz"; }
fs::path regions_path(const Project& project) { return project.folder / "regions"; }
fs::path corrections_path(const Project& project) { return project.folder / "corrections"; }

Result<Project> open_project(const fs::path& folder, Links links) {
  const fs::path file = project_file(folder);
  std::error_code failure;
  const bool exists = fs::exists(file, failure);
  if (failure) return file_error(file, "open", failure.value());
  if (!exists) {
    return Error{ErrorCode::not_found,
                 fmt::format("{} is not a Likeness project: it has no project.json.", folder.string()),
                 "Name a project folder, or make one with: likeness build VIDEO --project DIR",
                 folder.string()};
  }
  if (links == Links::refused)
    if (auto own = check_no_links(folder, false); !own) return own.error();
  const auto text = read_text(file);
  if (!text) return text.error();
  try {
    const json j = parse_json(*text);
    const int version = whole_number_in(j.at("version"));
    if (version > kProjectVersion) {
      return Error{ErrorCode::bad_input, fmt::format("{} was made by a newer Likeness.", file.string()),
                   "Update Likeness, or build the project again into another folder.", file.string()};
    }
    Project project;
    project.folder = folder;
    auto options = options_from_json(j.at("options"), version);
    if (!options) return unreadable(folder, options.error().what);
    project.options = std::move(*options);
    project.consent = consent_from_json(j);
    project.further_clips = further_clips_from_json(j);
    for (const Stage stage : kStages) {
      project.record(stage) = record_from_json(j.at("stages").at(std::string(stage_name(stage))));
    }
    return project;
  } catch (const json::exception& e) {
    return unreadable(folder, e.what());
  }
}

namespace {

// Whether a folder holds anything but what a run killed at its start left there.
bool holds_other_files(const fs::path& folder) {
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure)) {
    const std::string name = it->path().filename().string();
    if (!is_lock_name(name) && !(name.starts_with(".project.") && name.ends_with(".part.json"))) return true;
  }
  return false;
}

}  // namespace

std::string_view consent_name(Consent consent) { return kConsentNames[std::size_t(consent)]; }

Result<Project> open_or_create_project(const fs::path& folder, const ProjectOptions& options) {
  Project project;
  project.folder = folder;
  std::error_code failure;
  const bool exists = fs::exists(project_file(folder), failure);
  if (failure) return file_error(folder, "open", failure.value());
  if (!exists && fs::is_directory(folder, failure) && holds_other_files(folder))
    return Error{ErrorCode::bad_input,
                 fmt::format("The folder {} holds other files and no project.json.", folder.string()),
                 "Name a new or empty folder for the project.", folder.string()};
  if (const auto writable = make_project_folder(folder); !writable) return writable.error();
  // Another process working on the project writes project.json, too: take the lock, then read the newest one.
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  if (exists) {
    auto opened = open_project(folder);
    if (!opened) return opened.error();
    project = std::move(*opened);
  }
  project.options = options;
  for (const OptionRow& row : option_table())
    with_option(row, project.options, [&row](auto& value) {
      if constexpr (std::is_same_v<decltype(value), fs::path&>)
        if (std::ranges::find(row.words, value.native()) == row.words.end()) value = remembered(value);
    });
  if (const auto saved = save_project(project); !saved) return saved.error();
  return project;
}

Result<void> save_project(const Project& project) {
  json stages = json::object();
  for (const Stage stage : kStages) stages[std::string(stage_name(stage))] = to_json(project.record(stage));
  json j{{"version", kProjectVersion},
         {"program", "Likeness"},
         {"consent", consent_name(project.consent)},
         {"options", options_to_json(project.options)},
         {"stages", stages}};
  if (!project.further_clips.empty()) j["further_clips"] = project.further_clips;
  return write_text(project_file(project.folder), json_text(j, 2) + "\n");
}

Result<Project> change_project(const fs::path& folder, const std::function<void(Project&)>& change) {
  const auto lock = ProjectLock::acquire({.folder = folder});
  if (!lock) return lock.error();
  auto project = open_project(folder);
  if (!project) return project.error();
  change(*project);
  if (const auto saved = save_project(*project); !saved) return saved.error();
  return project;
}

Result<ProjectLock> ProjectLock::acquire(const Project& project, Links links) {
  const fs::path path = project.folder / kWorkLock;
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
  if (const int failed = errno; fd < 0) {
    if (failed == ELOOP)
      if (auto own = check_no_links(project.folder, false); !own) return own.error();
    return file_error(path, "write", failed);
  }
  std::string note;
  int failed = ::flock(fd, LOCK_EX | LOCK_NB);
  while (failed != 0 && errno == EINTR) failed = ::flock(fd, LOCK_EX | LOCK_NB);
  if (failed != 0) {
    const int why = errno;
    if (why == EWOULDBLOCK) {
      ::close(fd);
      return Error{ErrorCode::failed,
                   fmt::format("Another Likeness is working on {}.", project.folder.string()),
                   "Wait for it to finish, or stop it, then run this again.", project.folder.string()};
    }
    // As of shares without a lock service.
    note = fmt::format(
        "The disk of {} keeps no locks ({}): see to it that no second Likeness works on this project.",
        project.folder.string(), std::strerror(why));
  }
  ProjectLock lock(fd);
  lock.note_ = std::move(note);
  if (links == Links::refused)
    if (auto own = check_no_links(project.folder, true); !own) return own.error();
  return lock;
}

ProjectLock::~ProjectLock() {
  if (fd_ >= 0) ::close(fd_);
}

ProjectLock::ProjectLock(ProjectLock&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), note_(std::move(other.note_)) {}

}  // namespace likeness
