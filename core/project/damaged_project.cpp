// See damaged_project.h.
#include "core/project/damaged_project.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <fstream>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/base/path_text.h"
#include "core/project/further_clips.h"
#include "core/project/option_table.h"
#include "core/project/own_names.h"

namespace likeness {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// The string after "NAME": in a file that need not be whole; empty if there is none.
std::string string_named(std::string_view text, std::string_view name) {
  const auto skip_space = [&](std::size_t at) {
    while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at]))) ++at;
    return at;
  };
  const std::string quoted = fmt::format("\"{}\"", name);
  const std::size_t found = text.find(quoted);
  if (found == std::string_view::npos) return {};
  std::size_t at = skip_space(found + quoted.size());
  if (at >= text.size() || text[at] != ':') return {};
  at = skip_space(at + 1);
  if (at >= text.size() || text[at] != '"') return {};
  std::size_t end = at + 1;
  while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
  if (end >= text.size()) return {};
  const json value = try_parse_json(text.substr(at, end + 1 - at));
  return value.is_string() ? value.get<std::string>() : std::string();
}

bool begins_with(const fs::path& file, std::string_view magic) {
  std::array<char, 8> read{};
  std::ifstream in(file, std::ios::binary);
  return in.read(read.data(), read.size()) && std::string_view(read.data(), read.size()) == magic;
}

bool is_likeness_folder(const fs::path& folder, std::string_view text) {
  // A path that ends in a slash, as "me.likeness/", has no file name.
  const fs::path name = folder.has_filename() ? folder.filename() : folder.parent_path().filename();
  return name.extension() == ".likeness" || string_named(text, "program") == "Likeness" ||
         begins_with(folder / "avatar.bin", "LKNSAVTR") ||
         begins_with(folder / "checkpoint.bin", "LKNSCKPT") || read_capture(folder / "capture.json").ok();
}

bool is_newer(const std::string& text) {
  const json whole = try_parse_json(text);
  return whole.is_object() && whole.contains("version") && whole["version"].is_number_integer() &&
         whole["version"].get<std::int64_t>() > kProjectVersion;
}

}  // namespace

std::optional<DamagedProject> find_damaged_project(const fs::path& folder) {
  const auto opened = open_project(folder, Links::ignored);
  if (opened || opened.error().code != ErrorCode::bad_input) return std::nullopt;
  const auto text = read_text(folder / "project.json");
  if (!text || !is_likeness_folder(folder, *text)) return std::nullopt;
  DamagedProject damaged{.folder = folder, .error = opened.error(), .newer = is_newer(*text)};
  ProjectOptions& options = damaged.options;
  for (const OptionRow& row : option_table())
    with_option(row, options, [&](auto& value) {
      if constexpr (std::is_same_v<decltype(value), fs::path&>)
        value = path_of_text(string_named(*text, row.key));
    });
  std::vector<fs::path> named{options.shared.video};
  if (const auto capture = read_capture(capture_path({.folder = folder}))) {
    named.push_back(capture->video);
    options.import.size = capture->size;
    options.import.split = capture->split;
    options.import.sides = capture->sides;
    options.import.seconds = capture->seconds;
  }
  std::error_code ignored;
  for (const fs::path& clip : named) {
    if (clip.empty()) continue;
    if (options.shared.video.empty()) options.shared.video = clip;
    if (fs::exists(clip, ignored)) damaged.clips.push_back(clip);
  }
  if (!damaged.clips.empty()) options.shared.video = damaged.clips.front();
  const fs::path further = folder / "clips";
  for (fs::directory_iterator it(further, ignored), end; !ignored && it != end; it.increment(ignored)) {
    if (is_link(further) || is_link(it->path())) continue;
    const std::string name = it->path().filename().string();
    int number = 0;
    const auto [rest, wrong] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (wrong != std::errc{} || rest != name.data() + name.size() || number < kFirstFurtherClip) continue;
    if (open_project(it->path())) damaged.further_clips.push_back(number);
  }
  std::ranges::sort(damaged.further_clips);
  return damaged;
}

Result<Project> repair_project(const fs::path& folder) {
  const auto damaged = find_damaged_project(folder);
  if (!damaged || damaged->newer) return open_project(folder);
  Project project{.folder = folder, .options = damaged->options, .further_clips = damaged->further_clips};
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  std::error_code failure;
  const fs::path file = folder / "project.json";
  fs::copy_file(file, folder / "project.damaged.json", fs::copy_options::overwrite_existing, failure);
  if (failure) return file_error(folder / "project.damaged.json", "write", failure.value());
  if (const auto saved = save_project(project); !saved) return saved.error();
  return project;
}

}  // namespace likeness
