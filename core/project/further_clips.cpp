// See further_clips.h.
#include "core/project/further_clips.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>
#include <vector>

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

// What of its film a clip learns from: the shots that serve, once it was read.
struct Serving {
  std::string video_hash;
  std::vector<ClipSeconds> seconds;
};

Serving serving_of(const Project& clip) {
  const ClipSeconds& chosen = clip.options.import.seconds;
  Serving serving;
  if (const auto capture = read_capture(capture_path(clip))) {
    serving.video_hash = capture->video_hash;
    if (capture->seconds == chosen)
      for (const ClipShot& shot : capture->shots)
        if (shot.used) serving.seconds.push_back({shot.from_s, shot.to_s});
  } else if (const auto content = hash_video(clip.options.shared.video)) {
    serving.video_hash = *content;
  }
  if (serving.seconds.empty()) serving.seconds.push_back(chosen);
  return serving;
}

// Which of the project's clips learns from these seconds of this content already.
struct Holder {
  std::string name;       // in words for a message
  ClipSeconds seconds{};  // of it
};

std::optional<Holder> holder_of(const Project& project, const std::string& hash, const ClipSeconds& seconds) {
  const auto found = [&](const Project& clip, const std::string& name) -> std::optional<Holder> {
    const Serving serving = serving_of(clip);
    if (serving.video_hash != hash) return std::nullopt;
    for (const ClipSeconds& own : serving.seconds)
      if (overlap(own, seconds)) return Holder{name, own};
    return std::nullopt;
  };
  if (auto first = found(project, "the project's first clip")) return first;
  for (const int number : project.further_clips)
    if (const auto further = open_further_clip(project, number))
      if (auto held = found(*further, fmt::format("clip {}", number))) return held;
  return std::nullopt;
}

Error already_there(const fs::path& video, const ClipSeconds& seconds, const Holder& holder) {
  if (seconds.whole())
    return {ErrorCode::bad_input, fmt::format("{} is already {}.", video.string(), holder.name),
            "Add another clip of the same person: one that shows what the first one did not.",
            video.string()};
  if (holder.seconds.whole())
    return {ErrorCode::bad_input, fmt::format("{} is already {}, all of it.", video.string(), holder.name),
            "Add another clip of the same person. If a film is cut, other seconds of it can be added once it "
            "was read: only then it is known which of them serve.",
            video.string()};
  return {ErrorCode::bad_input,
          fmt::format("{} {} is already {}.", video.string(), seconds_words(holder.seconds), holder.name),
          "Choose --from and --to so that they have nothing of that.", video.string()};
}

// Whether the clip has these seconds.
Result<void> check_seconds(const fs::path& video, const VideoInfo& info, const ClipSeconds& seconds) {
  const auto& [from_s, to_s] = seconds;
  const auto refuse = [&](std::string what, std::string fix) -> Result<void> {
    return Error{ErrorCode::bad_input, std::move(what), std::move(fix), video.string()};
  };
  if (!std::isfinite(from_s) || !std::isfinite(to_s) || from_s < 0 || to_s < 0)
    return refuse("The seconds of a clip are numbers from 0 on.", "Choose others with --from and --to.");
  if (seconds.whole()) return {};
  std::error_code ignored;
  if (fs::is_directory(video, ignored))
    return refuse(fmt::format("{} is a folder of photographs, which have no seconds.", video.string()),
                  "Leave out --from and --to; put those that are to be added into a folder of their own.");
  if (to_s > 0 && to_s <= from_s)
    return refuse(fmt::format("Second {:.6g} is not after second {:.6g}.", to_s, from_s),
                  "Choose a --to that is later than --from.");
  // What a container declares is a little off at times.
  constexpr double kDeclared = 0.1;  // s
  const double last = std::max(from_s, to_s);
  if (info.duration_s > 0 && (from_s >= info.duration_s || last > info.duration_s + kDeclared))
    return refuse(
        fmt::format("{} is {:.1f} s long, and has no second {:.6g}.", video.string(), info.duration_s, last),
        "Choose --from and --to within the clip; without --to it is read to its end.");
  return {};
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

Result<int> add_further_clip(Project& project, const fs::path& video, std::optional<CameraKind> camera,
                             const ClipSeconds& seconds) {
  const auto probed = probe_video(video);
  if (!probed) return probed.error();
  if (const auto there = check_seconds(video, *probed, seconds); !there) return there.error();
  const auto hash = hash_video(video);
  if (!hash) return hash.error();
  // The lock first, then the newest project.json.
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  auto newest = open_project(project.folder);
  if (!newest) return newest.error();
  if (const auto holder = holder_of(*newest, *hash, seconds)) return already_there(video, seconds, *holder);
  int number = kFirstFurtherClip;
  for (const int taken : newest->further_clips) number = std::max(number, taken + 1);
  std::error_code ignored;
  while (fs::exists(further_clip_folder(*newest, number), ignored)) ++number;  // left by hand or by a failure
  ProjectOptions options;
  options.shared.video = video;
  options.align.camera = camera;
  options.import.seconds = seconds;
  const auto further =
      open_or_create_project(further_clip_folder(*newest, number), further_options(*newest, options));
  if (!further) return further.error();
  newest->further_clips.push_back(number);
  if (const auto saved = save_project(*newest); !saved) return saved.error();
  project = std::move(*newest);
  return number;
}

std::string further_clip_name(const Project& further, int number) {
  std::string film = further.options.shared.video.filename().string();
  if (const std::string words = seconds_words(further.options.import.seconds); !words.empty())
    film += " " + words;
  return fmt::format("Clip {} ({})", number, film);
}

}  // namespace likeness
