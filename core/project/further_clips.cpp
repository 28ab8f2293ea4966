// See further_clips.h.
#include "core/project/further_clips.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/hash.h"
#include "core/capture/capture.h"
#include "core/project/option_table.h"
#include "core/video/decode.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// The choices of a further clip: the first clip's, but for those that concern one clip alone.
ProjectOptions further_options(const Project& project, ProjectOptions own) {
  for (const OptionRow& row : option_table())
    if (row.of_the_person) copy_option(row, project.options, own);
  return own;
}

// Which of the project's clips has this content, in words for a message; empty: none.
std::string holder_of(const Project& project, const std::string& hash) {
  const auto of = [](const Project& any) {
    if (const auto capture = read_capture(capture_path(any))) return capture->video_hash;
    const auto content = hash_video(any.options.shared.video);
    return content ? *content : std::string();
  };
  if (of(project) == hash) return "the project's first clip";
  for (const int number : project.further_clips)
    if (const auto further = open_further_clip(project, number); further && of(*further) == hash)
      return fmt::format("clip {}", number);
  return "";
}

}  // namespace

bool is_further(const Project& project) { return !project.first_clip.empty(); }

fs::path further_clip_folder(const Project& project, int number) {
  return project.folder / "clips" / std::to_string(number);
}

Result<Project> open_further_clip(const Project& project, int number) {
  auto further = open_project(further_clip_folder(project, number));
  if (!further) {
    Error error = further.error();
    error.what = fmt::format("Clip {} of this project cannot be read. {}", number, error.what);
    error.fix = fmt::format("Remove it and add it again: likeness clips {} --remove {}",
                            project.folder.string(), number);
    return error;
  }
  further->options = further_options(project, std::move(further->options));
  further->first_clip = project.folder;
  return further;
}

Result<int> add_further_clip(Project& project, const fs::path& video, std::optional<CameraKind> camera) {
  const auto probed = probe_video(video);
  if (!probed) return probed.error();
  const auto hash = hash_video(video);
  if (!hash) return hash.error();
  // The lock first, then the newest project.json.
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  auto newest = open_project(project.folder);
  if (!newest) return newest.error();
  if (const std::string holder = holder_of(*newest, *hash); !holder.empty())
    return Error{ErrorCode::bad_input, fmt::format("{} is already {}.", video.string(), holder),
                 "Add another clip of the same person: one that shows what the first one did not.",
                 video.string()};
  int number = kFirstFurtherClip;
  for (const int taken : newest->further_clips) number = std::max(number, taken + 1);
  std::error_code ignored;
  while (fs::exists(further_clip_folder(*newest, number), ignored)) ++number;  // left by hand or by a failure
  ProjectOptions options;
  options.shared.video = video;
  options.align.camera = camera;
  const auto further =
      open_or_create_project(further_clip_folder(*newest, number), further_options(*newest, options));
  if (!further) return further.error();
  newest->further_clips.push_back(number);
  if (const auto saved = save_project(*newest); !saved) return saved.error();
  project = std::move(*newest);
  return number;
}

std::string further_clip_name(const Project& further, int number) {
  return fmt::format("Clip {} ({})", number, further.options.shared.video.filename().string());
}

}  // namespace likeness
