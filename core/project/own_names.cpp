// See own_names.h.
#include "core/project/own_names.h"

#include <algorithm>
#include <regex>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace likeness {

namespace fs = std::filesystem;

namespace {

// All that is ever written into a project's folder. project.json comes last: as long as it exists, a failed
// deletion can be repeated.
constexpr std::string_view kNames[] = {"frames",
                                       "masks",
                                       "regions",
                                       "masks.part",
                                       "masks.old",
                                       "regions.part",
                                       "regions.old",
                                       "colmap",
                                       "decoded",
                                       "clips",
                                       kComparisonFolder,
                                       "plate.png",
                                       "plate_known.png",
                                       "plate.json",
                                       "matte_report.json",
                                       "attribute_values.json",
                                       "attribute_values.next.json",
                                       "detail.npz",
                                       "track.json",
                                       "cameras.json",
                                       "capture.json",
                                       "checkpoint.bin",
                                       "avatar.bin",
                                       "room.bin",
                                       "training_curve.json",
                                       "check.json",
                                       "diagnostics.txt",
                                       "project.damaged.json",
                                       "track_first.json",
                                       "refits.json",
                                       "project.json"};

// Links count, whatever they lead to; nothing is entered through one.
std::optional<fs::path> first_link(const fs::path& folder) {
  std::error_code failure;
  for (fs::recursive_directory_iterator it(folder, failure), end; !failure && it != end;
       it.increment(failure))
    if (it->is_symlink(failure)) return it->path();
  return std::nullopt;
}

}  // namespace

bool is_project_name(const std::string& name) {
  // As keep_changed (core/project/stage_results.h) names its copies.
  static const std::regex changed(R"(\.changed(-\d+)?(?=\.))");
  return std::ranges::find(kNames, std::regex_replace(name, changed, "")) != std::end(kNames);
}

bool is_lock_name(const std::string& name) { return name == kWorkLock || name == kWindowLock; }

bool is_performance(const std::string& name) {
  return name.starts_with("performance") && name.ends_with(".json");
}

bool is_corrections_folder(const std::string& name) {
  static const std::regex form(R"(corrections((-\d+)?\.old)?)");
  return std::regex_match(name, form);
}

bool is_attributes_file(const std::string& name) {
  static const std::regex form(R"(attributes((-\d+)?\.old)?\.json)");
  return std::regex_match(name, form);
}

bool is_link(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() == fs::file_type::symlink;
}

std::optional<fs::path> link_within(const fs::path& folder, bool deep) {
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure)) {
    const std::string name = it->path().filename().string();
    const bool own = is_project_name(name) || is_performance(name) || is_corrections_folder(name) ||
                     is_attributes_file(name) || is_lock_name(name);
    if (!own) continue;
    if (it->is_symlink(failure)) return it->path();
    // Nothing is written into a comparison but by a study, which shares the project's own files there.
    if (!it->is_directory(failure) || name == kComparisonFolder) continue;
    if (deep) {
      if (auto link = first_link(it->path())) return link;
    } else if (name == "clips") {
      for (fs::directory_iterator clip(it->path(), failure); !failure && clip != end; clip.increment(failure))
        if (clip->is_symlink(failure)) return clip->path();
    }
  }
  return std::nullopt;
}

Result<void> check_no_links(const fs::path& folder, bool deep) {
  const auto link = link_within(folder, deep);
  if (!link) return {};
  std::error_code ignored;
  return Error{ErrorCode::io,
               fmt::format("{} is a link to {}. Likeness goes through no link inside a project: what lies "
                           "there may be somebody else's.",
                           link->string(), fs::read_symlink(*link, ignored).string()),
               "Put what belongs there in its place, or remove the link; then run this again.",
               link->string()};
}

}  // namespace likeness
