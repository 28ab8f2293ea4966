// See stage_results.h.
#include "core/project/stage_results.h"

#include <algorithm>
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

std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> pictures;
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure))
    if (it->path().extension() == ".png") pictures.push_back(it->path());
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

std::string result_hash(const Project& project, Stage stage) {
  std::string text;
  for (const fs::path& file : result_files(project, stage)) text += content(file);
  for (const fs::path& folder : picture_folders(project, stage))
    for (const fs::path& picture : pictures_in(folder)) text += picture.filename().string() + "\n";
  return hash_text(text);
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

Result<std::vector<std::string>> set_aside_changed(const Project& project, Stage stage) {
  const StageRecord& record = project.record(stage);
  std::vector<std::string> moved;
  if (record.state != StageState::done) return moved;
  if (record.result_hash.empty() || record.result_hash == result_hash(project, stage)) {
    if (!record.result_hash.empty() || results_readable(project, stage)) return moved;
  }
  for (const fs::path& file : result_files(project, stage)) {
    fs::path aside = file;
    aside.replace_extension(".changed" + file.extension().string());
    std::error_code failure;
    fs::remove_all(aside, failure);
    fs::rename(file, aside, failure);
    if (failure) return file_error(file, "rename", failure.value());
    moved.push_back(aside.filename().string());
  }
  return moved;
}

}  // namespace likeness
