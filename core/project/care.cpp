// See care.h.
#include "core/project/care.h"

#include <algorithm>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/file_names.h"
#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/project/build_forecast.h"
#include "core/project/corrections.h"
#include "core/project/damaged_project.h"
#include "core/project/further_clips.h"
#include "core/project/own_names.h"
#include "core/project/project_attributes.h"
#include "core/video/video_name.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return !a.empty() && fs::equivalent(a, b, ignored);
}

// Whether the clip lies in this folder, or is it.
bool holds_clip(const fs::path& entry, const fs::path& clip) {
  std::error_code failure;
  for (fs::path at = fs::weakly_canonical(clip, failure); !failure && at.has_relative_path();
       at = at.parent_path())
    if (same_file(at, entry)) return true;
  return false;
}

bool holds_video(const fs::path& entry) {
  std::error_code failure;
  for (fs::recursive_directory_iterator it(entry, failure), end; !failure && it != end; it.increment(failure))
    if (is_video_name(it->path())) return true;
  return false;
}

// Which entries of a project's folder may hold the person's clip. A damaged project may no longer name it;
// then every folder with a film in it may.
struct ClipGuard {
  std::vector<fs::path> clips;
  bool known = false;

  bool may_hold_it(const fs::path& entry) const {
    return known ? std::ranges::any_of(clips, [&](const fs::path& clip) { return holds_clip(entry, clip); })
                 : holds_video(entry);
  }
};

Result<ClipGuard> clip_guard(const fs::path& folder) {
  const auto project = open_project(folder, Links::ignored);
  const auto with_further = [&](ClipGuard guard, const std::vector<int>& numbers) {
    for (const int number : numbers)
      if (const auto further = open_further_clip({.folder = folder}, number))
        guard.clips.push_back(further->options.shared.video);
    return guard;
  };
  if (project) return with_further({{project->options.shared.video}, true}, project->further_clips);
  const auto damaged = find_damaged_project(folder);
  if (!damaged) return project.error();
  return with_further({damaged->clips, !damaged->clips.empty()}, damaged->further_clips);
}

Error taken(std::string_view what, const fs::path& out, std::string_view option) {
  return {ErrorCode::bad_input, fmt::format("{} names {}.", option, what),
          fmt::format("Give {} a name of its own.", option), out.string()};
}

}  // namespace

Result<void> check_free(const fs::path& out, std::string_view option) {
  if (auto named = check_can_be_named(out); !named) return named;
  std::error_code failure;
  for (fs::path at = fs::weakly_canonical(fs::absolute(out, failure), failure);
       !failure && at.has_relative_path(); at = at.parent_path()) {
    const std::string name = at.filename().string();
    const bool own =
        is_project_name(name) || (fs::exists(at) && (is_performance(name) || is_attributes_file(name)));
    const fs::path folder = at.parent_path();
    if (own && (find_damaged_project(folder) || open_project(folder)))
      return taken("what a project keeps", out, option);
  }
  return {};
}

Result<void> check_free(const Project& project, const fs::path& out, std::string_view option) {
  std::vector<fs::path> clips{project.options.shared.video};
  for (const int number : project.further_clips)
    if (const auto further = open_further_clip(project, number))
      clips.push_back(further->options.shared.video);
  for (const fs::path& clip : clips)
    if (!clip.empty() && (clip.lexically_normal() == out.lexically_normal() || same_file(clip, out)))
      return taken("a clip that the avatar is made from", out, option);
  return check_free(out, option);
}

std::optional<Error> missing_clip(const Project& project) {
  std::error_code ignored;
  if (fs::exists(project.options.shared.video, ignored)) return std::nullopt;
  return Error{
      ErrorCode::not_found,
      fmt::format("The clip {} is not where it was.", project.options.shared.video.string()),
      fmt::format("Put it back, or say where it is now: likeness relink {} CLIP", project.folder.string()),
      project.options.shared.video.string()};
}

Result<Project> relink_clip(const fs::path& folder, const fs::path& clip) {
  auto project = open_project(folder);
  if (!project) return project.error();
  const auto hash = hash_video(clip);
  if (!hash) return hash.error();
  if (const auto capture = read_capture(capture_path(*project)); capture && capture->video_hash != *hash) {
    return Error{ErrorCode::bad_input,
                 fmt::format("{} is another clip than the one this project was made from.", clip.string()),
                 "Name the same clip at its new place; another clip needs a project of its own.",
                 clip.string()};
  }
  // The lock first, then the newest project.json: another process may just have written it.
  const auto lock = ProjectLock::acquire(*project);
  if (!lock) return lock.error();
  project = open_project(folder);
  if (!project) return project.error();
  std::error_code failure;
  const fs::path absolute = fs::absolute(clip, failure).lexically_normal();
  project->options.shared.video = failure ? clip : absolute;
  if (const auto saved = save_project(*project); !saved) return saved.error();
  return project;
}

namespace {

// fix: what to do instead of naming a frame that the split takes out.
Result<void> check_training_frames(const Capture& capture, const std::vector<int>& frames, const char* fix) {
  for (const int frame : frames) {
    const auto own = std::ranges::find(capture.frames, frame, &CaptureFrame::frame);
    if (own == capture.frames.end())
      return Error{
          ErrorCode::bad_input, fmt::format("The clip has no frame {}.", frame),
          fmt::format("Its frames are {} to {}.", capture.frames.empty() ? 0 : capture.frames.front().frame,
                      capture.frames.empty() ? 0 : capture.frames.back().frame),
          ""};
    if (own->held_out)
      return Error{ErrorCode::bad_input,
                   fmt::format("Frame {} is held out: it measures the avatar and never trains.", frame), fix,
                   ""};
    if (own->apart)
      return Error{ErrorCode::bad_input,
                   fmt::format("Frame {} is kept apart by the split: nothing is learnt from it.", frame), fix,
                   ""};
  }
  return {};
}

}  // namespace

Result<void> check_left_out(const Capture& capture, const std::vector<int>& frames) {
  return check_training_frames(capture, frames, "Leave out training frames only.");
}

Result<void> check_rest_frames(const Capture& capture, const std::vector<int>& frames) {
  return check_training_frames(capture, frames, "Name a training frame in which the face rests.");
}

std::string deletion_words(const DeletedPerson& deleted) {
  std::string words =
      fmt::format("The person is deleted: {:.1f} MB were removed.", double(deleted.bytes) / 1e6);
  if (!deleted.links.empty())
    words += fmt::format(" Of {} only the links were removed, not what they lead to.",
                         fmt::join(deleted.links, ", "));
  if (!deleted.kept.empty()) words += fmt::format(" Kept: {}.", fmt::join(deleted.kept, ", "));
  for (const fs::path& clip : deleted.clips)
    words += fmt::format(" The clip stays, delete it yourself if it should go: {}.", clip.string());
  if (!deleted.kept.empty() && !deleted.clip_known)
    words +=
        " The project no longer said which film is the clip, so folders with films in them were kept: look "
        "through them, and delete what should not stay.";
  return words;
}

Result<DeletedPerson> delete_person(const fs::path& folder, bool keep_exports) {
  const auto guard = clip_guard(folder);
  if (!guard) return guard.error();
  const auto lock = ProjectLock::acquire({.folder = folder}, Links::ignored);
  if (!lock) return lock.error();
  std::vector<fs::path> going;
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure)) {
    const std::string name = it->path().filename().string();
    const bool own = is_project_name(name) || is_part_name(name) || is_performance(name) ||
                     is_corrections_folder(name) || is_attributes_file(name) ||
                     (name == "exports" && !keep_exports);
    if (own && name != "project.json" && !guard->may_hold_it(it->path())) going.push_back(it->path());
  }
  if (failure) return file_error(folder, "read", failure.value());
  going.push_back(folder / "project.json");
  DeletedPerson deleted;
  deleted.clip_known = guard->known;
  for (const fs::path& clip : guard->clips)
    if (path_exists(clip)) deleted.clips.push_back(clip);
  // If the folder of further clips may hold the film, only what was made from those clips is deleted.
  const fs::path further = folder / "clips";
  if (std::ranges::find(going, further) == going.end() && !is_link(further))
    for (fs::directory_iterator it(further, failure), end; !failure && it != end; it.increment(failure)) {
      if (is_link(it->path())) continue;
      if (const auto inner = delete_person(it->path(), false)) deleted.bytes += inner->bytes;
    }
  failure.clear();
  for (const fs::path& path : going) {
    const fs::file_type type = fs::symlink_status(path, failure).type();
    const bool is_folder = type == fs::file_type::directory;
    if (type == fs::file_type::symlink) deleted.links.push_back(path.filename().string());
    const std::uint64_t bytes = is_folder ? folder_bytes(path) : fs::file_size(path, failure);
    failure.clear();
    fs::remove_all(path, failure);
    if (failure) return file_error(path, "remove", failure.value());
    deleted.bytes += bytes == std::uint64_t(-1) ? 0 : bytes;
  }
  for (const char* name : {kWorkLock, kWindowLock}) fs::remove(folder / name, failure);
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure))
    deleted.kept.push_back(it->path().filename().string());
  failure.clear();
  if (deleted.kept.empty()) deleted.folder_gone = fs::remove(folder, failure) && !failure;
  return deleted;
}

Result<void> remove_further_clip(Project& project, int number) {
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  auto newest = open_project(project.folder);
  if (!newest) return newest.error();
  if (std::erase(newest->further_clips, number) == 0)
    return Error{ErrorCode::not_found, fmt::format("This project has no clip {}.", number),
                 fmt::format("See its clips: likeness clips {}", project.folder.string()),
                 project.folder.string()};
  if (const auto saved = save_project(*newest); !saved) return saved.error();
  project = std::move(*newest);
  // The project has forgotten the clip even if its folder cannot be removed; what is left belongs to no clip.
  const fs::path folder = further_clip_folder(project, number);
  if (std::error_code ignored; fs::exists(folder, ignored))
    if (const auto deleted = delete_person(folder, false); !deleted) return deleted.error();
  std::error_code ignored;
  fs::remove(project.folder / "clips", ignored);  // only if it is empty
  return {};
}

}  // namespace likeness
