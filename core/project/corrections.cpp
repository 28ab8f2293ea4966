// See corrections.h.
#include "core/project/corrections.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/hash.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// The frame whose strokes a file of this name holds: six digits or more, then .json.
std::optional<int> frame_of(const fs::path& file) {
  const std::string digits = file.stem().string();
  int frame = 0;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), frame);
  const bool whole = read.ec == std::errc() && read.ptr == digits.data() + digits.size();
  if (!whole || frame < 0 || fmt::format("{:06}.json", frame) != file.filename().string())
    return std::nullopt;
  return frame;
}

}  // namespace

fs::path strokes_path(const Project& project, int frame) {
  return corrections_path(project) / fmt::format("{:06}.json", frame);
}

std::vector<int> corrected_frames(const Project& project) {
  std::vector<int> frames;
  std::error_code failure;
  for (fs::directory_iterator it(corrections_path(project), failure), end; !failure && it != end;
       it.increment(failure))
    if (const auto frame = frame_of(it->path())) frames.push_back(*frame);
  std::ranges::sort(frames);
  return frames;
}

Result<FrameStrokes> read_corrections(const Project& project) {
  FrameStrokes all;
  for (const int frame : corrected_frames(project)) {
    auto strokes = read_strokes(strokes_path(project, frame));
    if (!strokes) return strokes.error();
    if (!strokes->empty()) all[frame] = std::move(*strokes);
  }
  return all;
}

std::string corrections_hash(const Project& project) {
  std::string contents;
  for (const int frame : corrected_frames(project)) {
    const auto hash = hash_file(strokes_path(project, frame));
    contents += fmt::format("{} {}\n", frame, hash ? *hash : "unreadable");
  }
  return contents.empty() ? std::string() : hash_text(contents);
}

Result<void> save_corrections(const Project& project, int frame, const Strokes& strokes) {
  const fs::path path = strokes_path(project, frame);
  if (!strokes.empty()) return write_strokes(path, strokes);
  std::error_code failure;
  fs::remove(path, failure);
  if (failure) return file_error(path, "remove", failure.value());
  fs::remove(corrections_path(project), failure);  // only when it is empty
  return {};
}

Result<fs::path> set_aside_strokes(const Project& project, int frame) {
  const fs::path path = strokes_path(project, frame);
  std::error_code failure;
  fs::path aside = corrections_path(project) / fmt::format("{:06}.damaged.json", frame);
  for (int number = 2; fs::exists(aside, failure); ++number)
    aside = corrections_path(project) / fmt::format("{:06}.damaged-{}.json", frame, number);
  fs::rename(path, aside, failure);
  if (failure) return file_error(path, "rename", failure.value());
  return aside;
}

Result<fs::path> set_aside_corrections(const Project& project) {
  const fs::path path = corrections_path(project);
  std::error_code failure;
  fs::path aside = project.folder / "corrections.old";
  for (int number = 2; fs::exists(aside, failure); ++number)
    aside = project.folder / fmt::format("corrections-{}.old", number);
  fs::rename(path, aside, failure);
  if (failure) return file_error(path, "rename", failure.value());
  return aside;
}

}  // namespace likeness
