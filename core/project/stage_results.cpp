// See stage_results.h.
#include "core/project/stage_results.h"

#include <algorithm>
#include <regex>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/image/files.h"
#include "core/matte/matte_report.h"
#include "core/matte/plate_file.h"
#include "core/project/project_attributes.h"
#include "core/render/avatar.h"
#include "core/render/room_picture.h"
#include "core/scene/track.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

std::vector<fs::path> all_files(const Project& project, Stage stage) {
  switch (stage) {
    case Stage::import:
      return {capture_path(project)};
    case Stage::align:
      return {cameras_path(project)};
    case Stage::fit:
      return {track_path(project), detail_path(project)};
    case Stage::matte:
      return {plate_path(project), plate_known_path(project), plate_info_path(project),
              matte_report_path(project), room_path(project)};
    case Stage::train:
      return {avatar_path(project), attribute_values_path(project)};
  }
  return {};
}

std::vector<fs::path> picture_folders(const Project& project, Stage stage) {
  if (stage == Stage::import) return {project.folder / "frames"};
  if (stage == Stage::matte) return {project.folder / "masks", regions_path(project)};
  return {};
}

// Ours alone: a sheet that somebody put beside them is no result.
std::vector<fs::path> pictures_in(const fs::path& folder) {
  static const std::regex form(R"(\d+(\.alpha)?\.png)");
  std::vector<fs::path> pictures;
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure))
    if (std::regex_match(it->path().filename().string(), form)) pictures.push_back(it->path());
  std::ranges::sort(pictures);
  return pictures;
}

std::string content(const fs::path& path) {
  const auto hash = hash_file(path);
  return fmt::format("{} {}\n", path.filename().string(), hash ? *hash : "unreadable");
}

bool readable_picture(const fs::path& path) { return !path_exists(path) || read_image(path).ok(); }

}  // namespace

std::vector<fs::path> result_files(const Project& project, Stage stage) {
  std::vector<fs::path> files = all_files(project, stage);
  std::erase_if(files, [](const fs::path& path) { return !path_exists(path); });
  return files;
}

std::map<std::string, std::string> stage_results(const Project& project, Stage stage) {
  std::map<std::string, std::string> results;
  for (const fs::path& file : result_files(project, stage)) {
    const auto hash = hash_file(file);
    results[file.filename().string()] = hash ? *hash : "unreadable";
  }
  for (const fs::path& folder : picture_folders(project, stage)) {
    std::string names;
    for (const fs::path& picture : pictures_in(folder)) names += picture.filename().string() + "\n";
    if (!names.empty()) results[folder.filename().string() + "/"] = hash_text(names);
  }
  return results;
}

std::string pictures_hash(const Project& project, Stage stage) {
  std::string text;
  for (const fs::path& folder : picture_folders(project, stage))
    for (const fs::path& picture : pictures_in(folder)) text += content(picture);
  return text.empty() ? "" : hash_text(text);
}

bool results_readable(const Project& project, Stage stage) {
  switch (stage) {
    case Stage::import:
      return read_capture(capture_path(project)).ok();
    case Stage::align:
      return read_cameras(cameras_path(project)).ok();
    case Stage::fit:
      return read_track(track_path(project)).ok();
    case Stage::matte:
      return readable_picture(plate_path(project)) && readable_picture(plate_known_path(project)) &&
             read_plate_info(plate_info_path(project)).ok() &&
             read_matte_report(matte_report_path(project)).ok() &&
             (!path_exists(room_path(project)) || read_room(room_path(project)).ok());
    case Stage::train:
      return read_avatar(avatar_path(project)).ok();
  }
  return true;
}

Result<std::vector<std::string>> keep_changed(const Project& project, Stage stage) {
  const StageRecord& record = project.record(stage);
  std::vector<std::string> kept;
  if (record.state != StageState::done || (record.results.empty() && results_readable(project, stage)))
    return kept;
  const auto now = stage_results(project, stage);
  for (const fs::path& file : result_files(project, stage)) {
    const std::string name = file.filename().string();
    const auto made = record.results.find(name);
    const bool same = made != record.results.end() && made->second == now.at(name);
    if (same || !fs::is_regular_file(file)) continue;
    fs::path copy;
    for (int number = 1; copy.empty() || path_exists(copy); ++number)
      copy = project.folder / fmt::format("{}.changed{}{}", file.stem().string(),
                                          number > 1 ? fmt::format("-{}", number) : "",
                                          file.extension().string());
    std::error_code failure;
    fs::copy_file(file, copy, failure);
    if (failure) return file_error(copy, "write", failure.value());
    kept.push_back(copy.filename().string());
  }
  return kept;
}

}  // namespace likeness
