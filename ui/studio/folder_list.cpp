// See folder_list.h.
#include "ui/studio/folder_list.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string_view>

#include "core/base/natural_order.h"
#include "core/project/own_names.h"
#include "core/video/video_name.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxEntries = 2000;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

bool ends_in(const fs::path& path, std::span<const std::string_view> endings) {
  return std::ranges::find(endings, lower(path.extension().string())) != endings.end();
}

// Files that make up a project are not performances.
bool is_project_file(const fs::path& file) {
  const std::string name = file.filename().string();
  return is_project_name(name) || is_attributes_file(name);
}

bool is_wanted(const fs::path& file, Wanted wanted) {
  switch (wanted) {
    case Wanted::clip:
    case Wanted::further_clip:
    case Wanted::driver:
    case Wanted::driving_clip:
    case Wanted::moved_clip:
      return is_video_name(file);
    case Wanted::background:
      return is_picture_name(file);
    case Wanted::performance:
    case Wanted::new_performance:
    case Wanted::export_performance:
      return lower(file.extension().string()) == ".json" && !is_project_file(file);
    case Wanted::project:
    case Wanted::projects:
      return false;
  }
  return false;
}

}  // namespace

bool is_picture_name(const fs::path& path) {
  constexpr std::array<std::string_view, 6> kEndings{".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp"};
  return ends_in(path, kEndings);
}

std::vector<FolderEntry> list_folder(const fs::path& folder, Wanted wanted) {
  std::vector<FolderEntry> entries;
  std::error_code failure;
  for (fs::directory_iterator it(folder, fs::directory_options::skip_permission_denied, failure), end;
       !failure && it != end && entries.size() < kMaxEntries; it.increment(failure)) {
    std::error_code ignored;
    FolderEntry entry{it->path().filename().string()};
    if (entry.name.starts_with(".")) continue;
    entry.folder = it->is_directory(ignored);
    if (!entry.folder && !is_wanted(it->path(), wanted)) continue;
    entry.project = entry.folder && fs::exists(it->path() / "project.json", ignored);
    if (!entry.folder) entry.bytes = it->file_size(ignored);
    entries.push_back(std::move(entry));
  }
  std::ranges::sort(entries, [](const FolderEntry& a, const FolderEntry& b) {
    if (a.project != b.project) return a.project;
    if (a.folder != b.folder) return a.folder;
    return naturally_before(a.name, b.name);
  });
  return entries;
}

}  // namespace likeness::ui
