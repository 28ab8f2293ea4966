// project.json and the folder's names: see project.h.
#include "core/project/project.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/capture/split.h"

namespace likeness {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::array<const char*, kStages.size()> kStageNames{"import", "align", "fit", "matte", "train"};
constexpr std::array<const char*, 5> kStateNames{"to_do", "running", "done", "failed", "stopped"};

constexpr std::array<const char*, 4> kConsentNames{"not_asked", "own", "given", "no_real_person"};

// An answer this version does not know is none.
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

json to_json(const ProjectOptions& options) {
  json refits = json::array();
  for (const RefitSpan& span : options.fit.refits) refits.push_back({span.first, span.last});
  return {{"video", options.shared.video.string()},
          {"head_model", options.shared.head_model.string()},
          {"landmark_model", options.shared.landmark_model.string()},
          {"matting_network", options.matte.matting_network.string()},
          {"identity", options.fit.identity.string()},
          {"displacement", options.fit.displacement.string()},
          {"size_px", options.import.size},
          {"split", split_name(options.import.split)},
          {"budget_s", options.train.budget_s},
          {"full_budget_s", options.train.full_budget_s},
          {"steps", options.train.steps},
          {"seed", options.shared.seed},
          {"checkpoint_every_s", options.train.checkpoint_every_s},
          // Versions that did not choose read the default here.
          {"mode", mode_name(options.train.mode.value_or(kDefaultMode))},
          {"mode_asked", options.train.mode.has_value()},
          {"resting_camera", options.align.resting_camera},
          {"lens_mm", options.align.lens_mm},
          {"refine_track", options.train.refine_track},
          {"landmark_loss", options.train.landmark_loss},
          {"use_latent", options.train.use_latent},
          {"use_occupancy", options.train.use_occupancy},
          {"refits", refits},
          {"left_out", options.train.left_out}};
}

// Of a project of version 1, which always gave the field the expression.
FieldMode mode_of_switches(const json& j) {
  const ModeParts parts{
      .expression = true, .ambient = j.at("use_ambient"), .warp = j.value("use_warp", true)};
  return *std::ranges::find(kFieldModes, parts, mode_parts);
}

FieldMode mode_from_json(const json& j) {
  const auto mode = mode_named(j.at("mode").get<std::string>());
  if (!mode) throw json::other_error::create(501, "there is no such mode", &j.at("mode"));
  return *mode;
}

// Of a project from before parts were chosen, the default is nobody's wish.
std::optional<FieldMode> asked_mode(const json& j, FieldMode mode) {
  return j.value("mode_asked", mode != kDefaultMode) ? std::optional(mode) : std::nullopt;
}

// Projects from before this choice held out the tail.
Split split_from_json(const json& j) {
  if (!j.contains("split")) return Split::tail;
  const auto split = split_named(j.at("split").get<std::string>());
  if (!split) throw json::other_error::create(501, "there is no such split", &j.at("split"));
  return *split;
}

ProjectOptions options_from_json(const json& j, int version) {
  ProjectOptions options;
  options.shared.video = j.at("video").get<std::string>();
  options.shared.head_model = j.at("head_model").get<std::string>();
  options.shared.landmark_model = j.at("landmark_model").get<std::string>();
  options.matte.matting_network = j.value("matting_network", "");
  options.fit.identity = j.value("identity", "");
  options.fit.displacement = j.value("displacement", "");
  options.import.size = j.at("size_px");
  options.import.split = split_from_json(j);
  options.train.budget_s = j.at("budget_s");
  options.train.full_budget_s = j.value("full_budget_s", 0.0);
  options.train.steps = j.at("steps");
  options.shared.seed = j.at("seed");
  options.train.checkpoint_every_s = j.value("checkpoint_every_s", options.train.checkpoint_every_s);
  options.train.mode = asked_mode(j, version == 1 ? mode_of_switches(j) : mode_from_json(j));
  options.align.resting_camera = j.value("resting_camera", false);
  options.align.lens_mm = j.value("lens_mm", 0.0);
  options.train.refine_track = j.value("refine_track", false);
  options.train.landmark_loss = j.value("landmark_loss", 0.0);
  options.train.use_latent = j.at("use_latent");
  options.train.use_occupancy = j.at("use_occupancy");
  options.train.left_out = j.value("left_out", options.train.left_out);
  std::ranges::sort(options.train.left_out);
  if (j.contains("refits")) {
    for (const json& span : j.at("refits"))
      options.fit.refits.push_back({span.at(0).get<int>(), span.at(1).get<int>()});
    std::erase_if(options.fit.refits, [](const RefitSpan& s) { return s.first < 0 || s.last < s.first; });
    options.fit.refits = merged_spans(std::move(options.fit.refits));
  }
  return options;
}

json to_json(const StageRecord& record) {
  json j{{"state", kStateNames[std::size_t(record.state)]},
         {"input_hash", record.input_hash},
         {"seconds", record.seconds},
         {"message", record.message},
         {"warnings", record.warnings}};
  if (!record.track_inputs.empty()) j["track_inputs"] = record.track_inputs;
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

}  // namespace

std::string_view stage_name(Stage stage) { return kStageNames[std::size_t(stage)]; }

fs::path capture_path(const Project& project) { return project.folder / "capture.json"; }
fs::path cameras_path(const Project& project) { return project.folder / "cameras.json"; }
fs::path track_path(const Project& project) { return project.folder / "track.json"; }
fs::path avatar_path(const Project& project) { return project.folder / "avatar.bin"; }
fs::path checkpoint_path(const Project& project) { return project.folder / "checkpoint.bin"; }
fs::path plate_path(const Project& project) { return project.folder / "plate.png"; }
fs::path plate_known_path(const Project& project) { return project.folder / "plate_known.png"; }
fs::path plate_info_path(const Project& project) { return project.folder / "plate.json"; }
fs::path room_path(const Project& project) { return project.folder / "room.bin"; }
fs::path detail_path(const Project& project) { return project.folder / "detail.npz"; }
fs::path regions_path(const Project& project) { return project.folder / "regions"; }
fs::path corrections_path(const Project& project) { return project.folder / "corrections"; }

void restore_budget(ProjectOptions& options) {
  if (options.train.full_budget_s > 0) options.train.budget_s = std::exchange(options.train.full_budget_s, 0);
}

Result<Project> open_project(const fs::path& folder) {
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
  const auto text = read_text(file);
  if (!text) return text.error();
  try {
    const json j = json::parse(*text);
    const int version = j.at("version").get<int>();
    if (version > kProjectVersion) {
      return Error{ErrorCode::bad_input, fmt::format("{} was made by a newer Likeness.", file.string()),
                   "Update Likeness, or build the project again into another folder.", file.string()};
    }
    Project project;
    project.folder = folder;
    project.options = options_from_json(j.at("options"), version);
    project.consent = consent_from_json(j);
    project.further_clips = further_clips_from_json(j);
    for (const Stage stage : kStages) {
      project.record(stage) = record_from_json(j.at("stages").at(std::string(stage_name(stage))));
    }
    return project;
  } catch (const json::exception& e) {
    return Error{
        ErrorCode::bad_input, fmt::format("{} cannot be read: {}.", file.string(), e.what()),
        fmt::format("Put a good copy of this file back, or let it be made anew from the rest: likeness "
                    "repair {}",
                    folder.string()),
        file.string()};
  }
}

namespace {

// Whether there is anything in a folder but what a run that was killed at once left there.
bool holds_other_files(const fs::path& folder) {
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure)) {
    const std::string name = it->path().filename().string();
    if (name != ".lock" && !(name.starts_with(".project.") && name.ends_with(".part.json"))) return true;
  }
  return false;
}

}  // namespace

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
  if (const auto writable = make_writable_folder(folder); !writable) return writable.error();
  // Another process that works on the project writes project.json too: the lock first, then the newest of it.
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  if (exists) {
    auto opened = open_project(folder);
    if (!opened) return opened.error();
    project = std::move(*opened);
  }
  project.options = options;
  project.options.shared.video = remembered(options.shared.video);
  project.options.shared.head_model = remembered(options.shared.head_model);
  project.options.shared.landmark_model = remembered(options.shared.landmark_model);
  project.options.matte.matting_network = remembered(options.matte.matting_network);
  project.options.fit.identity = remembered(options.fit.identity);
  project.options.fit.displacement = remembered(options.fit.displacement);
  if (const auto saved = save_project(project); !saved) return saved.error();
  return project;
}

Result<void> save_project(const Project& project) {
  json stages = json::object();
  for (const Stage stage : kStages) stages[std::string(stage_name(stage))] = to_json(project.record(stage));
  json j{{"version", kProjectVersion},
         {"program", "Likeness"},
         {"consent", kConsentNames[std::size_t(project.consent)]},
         {"options", to_json(project.options)},
         {"stages", stages}};
  if (!project.further_clips.empty()) j["further_clips"] = project.further_clips;
  // A path need not be valid UTF-8; the odd byte is replaced rather than refused.
  return write_text(project_file(project.folder),
                    j.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
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

Result<ProjectLock> ProjectLock::acquire(const Project& project) {
  const fs::path path = project.folder / ".lock";
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return file_error(path, "write", errno);
  int failed = ::flock(fd, LOCK_EX | LOCK_NB);
  while (failed != 0 && errno == EINTR) failed = ::flock(fd, LOCK_EX | LOCK_NB);
  if (failed != 0) {
    const int why = errno;
    ::close(fd);
    if (why != EWOULDBLOCK) return file_error(path, "lock", why);  // a file system without locks
    return Error{ErrorCode::failed,
                 fmt::format("Another Likeness is working on {}.", project.folder.string()),
                 "Wait for it to finish, or stop it, then run this again.", project.folder.string()};
  }
  return ProjectLock(fd);
}

ProjectLock::~ProjectLock() {
  if (fd_ >= 0) ::close(fd_);
}

ProjectLock::ProjectLock(ProjectLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

}  // namespace likeness
