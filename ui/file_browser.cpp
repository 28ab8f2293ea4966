// See file_browser.h.
#include "ui/file_browser.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "ui/platform/settings.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostEntries = 2000;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

std::string size_words(std::uintmax_t bytes) {
  if (bytes < 1u << 20) return fmt::format("{} kB", std::max<std::uintmax_t>(1, bytes >> 10));
  return fmt::format("{} MB", bytes >> 20);
}

void draw_icon(const BrowserEntry& entry, ImVec2 at, float side) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Palette& p = theme().colours;
  if (entry.folder) {
    const ImU32 ink = colour(entry.project ? p.accent : p.warn, entry.project ? 1 : 0.8f);
    list.AddRectFilled({at.x, at.y + 0.2f * side}, {at.x + 0.42f * side, at.y + 0.5f * side}, ink, px(2));
    list.AddRectFilled({at.x, at.y + 0.3f * side}, {at.x + side, at.y + 0.85f * side}, ink, px(2));
  } else {
    list.AddRectFilled({at.x, at.y + 0.15f * side}, {at.x + side, at.y + 0.85f * side}, colour(p.faint),
                       px(2));
    list.AddTriangleFilled({at.x + 0.38f * side, at.y + 0.32f * side},
                           {at.x + 0.38f * side, at.y + 0.68f * side},
                           {at.x + 0.7f * side, at.y + 0.5f * side}, colour(p.panel));
  }
}

bool wants_video(Wanted wanted) { return wanted == Wanted::clip || wanted == Wanted::driver; }

bool is_wanted_file(const fs::path& path, Wanted wanted) {
  if (wanted == Wanted::project) return false;
  if (wants_video(wanted)) return is_video_name(path);
  // A project's own files are none.
  constexpr std::array<std::string_view, 4> kOwn{"project.json", "capture.json", "cameras.json",
                                                 "track.json"};
  return lower(path.extension().string()) == ".json" &&
         std::ranges::find(kOwn, path.filename().string()) == kOwn.end();
}

const char* title_of(Wanted wanted) {
  switch (wanted) {
    case Wanted::clip:
      return "Open a clip";
    case Wanted::driver:
      return "Drive from a video";
    case Wanted::project:
      return "Open a project";
    case Wanted::performance:
      return "Open a performance";
    case Wanted::new_performance:
      return "Save the performance as";
  }
  return "";
}

const char* nothing_words(Wanted wanted) {
  return wants_video(wanted)         ? "No folder and no video here."
         : wanted == Wanted::project ? "No folder here."
                                     : "No folder and no performance (.json) here.";
}

}  // namespace

bool is_video_name(const fs::path& path) {
  constexpr std::array<std::string_view, 9> kEndings{".mp4", ".mov", ".m4v",  ".mkv", ".webm",
                                                     ".avi", ".3gp", ".mpeg", ".mts"};
  return std::ranges::find(kEndings, lower(path.extension().string())) != kEndings.end();
}

std::vector<BrowserEntry> list_folder(const fs::path& folder, Wanted wanted) {
  std::vector<BrowserEntry> entries;
  std::error_code failure;
  for (fs::directory_iterator it(folder, fs::directory_options::skip_permission_denied, failure), end;
       !failure && it != end && entries.size() < kMostEntries; it.increment(failure)) {
    std::error_code ignored;
    BrowserEntry entry{it->path().filename().string()};
    if (entry.name.starts_with(".")) continue;
    entry.folder = it->is_directory(ignored);
    if (!entry.folder && !is_wanted_file(it->path(), wanted)) continue;
    entry.project = entry.folder && fs::exists(it->path() / "project.json", ignored);
    if (!entry.folder) entry.bytes = it->file_size(ignored);
    entries.push_back(std::move(entry));
  }
  std::ranges::sort(entries, [](const BrowserEntry& a, const BrowserEntry& b) {
    if (a.project != b.project) return a.project;
    if (a.folder != b.folder) return a.folder;
    return lower(a.name) < lower(b.name);
  });
  return entries;
}

void FileBrowser::open(Wanted wanted, const fs::path& start) {
  open_ = appear_ = true;
  wanted_ = wanted;
  name_ = "performance-1.json";
  std::error_code ignored;
  enter(fs::is_directory(start, ignored) ? start : home_folder());
}

void FileBrowser::enter(const fs::path& folder) {
  std::error_code failure;
  const fs::path absolute = fs::absolute(folder, failure).lexically_normal();
  folder_ = failure ? folder : absolute;
  if (folder_.has_relative_path() && folder_.filename().empty()) folder_ = folder_.parent_path();
  entries_ = list_folder(folder_, wanted_);
  typed_ = folder_.string();
  chosen_ = -1;
}

std::optional<fs::path> FileBrowser::draw() {
  if (!open_) return std::nullopt;
  const char* title = title_of(wanted_);
  const bool saves = wanted_ == Wanted::new_performance;
  if (appear_) ImGui::OpenPopup(title);
  appear_ = false;
  const ImVec2 screen = ImGui::GetMainViewport()->WorkSize;
  ImGui::SetNextWindowSize({std::min(px(720), 0.9f * screen.x), std::min(px(540), 0.85f * screen.y)});
  ImGui::SetNextWindowPos(ImGui::GetMainViewport()->GetCenter(), ImGuiCond_Always, {0.5f, 0.5f});
  std::optional<fs::path> picked;
  if (!ImGui::BeginPopupModal(title, nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoTitleBar)) {
    open_ = false;
    return std::nullopt;
  }
  heading(title);
  std::optional<fs::path> next;
  if (plain_button("Home")) next = home_folder();
  ImGui::SameLine();
  if (plain_button("Videos")) next = home_folder() / "Videos";
  ImGui::SameLine();
  if (plain_button("Projects")) next = projects_folder();
  ImGui::SameLine();
  if (plain_button("Up")) next = folder_.parent_path();
  ImGui::SetNextItemWidth(-1);
  if (ImGui::InputText("##path", &typed_, ImGuiInputTextFlags_EnterReturnsTrue)) {
    std::error_code ignored;
    const fs::path typed(typed_);
    if (fs::is_directory(typed, ignored) &&
        !(wanted_ == Wanted::project && fs::exists(typed / "project.json", ignored))) {
      next = typed;
    } else if (fs::exists(typed, ignored) && !saves) {
      picked = typed;
    }
  }
  note_widget("browser path");
  begin_card("entries", {0, -float(saves ? 2 : 1) * ImGui::GetFrameHeightWithSpacing() - px(6)}, true);
  if (entries_.empty()) faint_text(nothing_words(wanted_));
  const float line = ImGui::GetTextLineHeight();
  for (int i = 0; i < int(entries_.size()); ++i) {
    const BrowserEntry& entry = entries_[std::size_t(i)];
    ImGui::PushID(i);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    if (ImGui::Selectable("##entry", chosen_ == i, ImGuiSelectableFlags_AllowDoubleClick,
                          {0, line + px(4)})) {
      chosen_ = i;
      if (!entry.folder) name_ = entry.name;
      if (ImGui::IsMouseDoubleClicked(0)) {
        if (entry.folder && !(entry.project && wanted_ == Wanted::project)) {
          next = folder_ / entry.name;
        } else {
          if (!saves) picked = folder_ / entry.name;
        }
      }
    }
    note_widget("entry " + entry.name);
    draw_icon(entry, {at.x + px(2), at.y + px(2)}, line);
    ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + line + px(10));
    clipped_text(entry.name, ImGui::GetContentRegionAvail().x - px(120));
    if (entry.bytes > 0) {
      ImGui::SameLine(ImGui::GetContentRegionMax().x - px(90));
      ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
      ImGui::TextUnformatted(size_words(entry.bytes).c_str());
      ImGui::PopStyleColor();
    }
    ImGui::PopID();
  }
  end_card();
  const bool any = chosen_ >= 0 && chosen_ < int(entries_.size());
  const bool enters = any && entries_[std::size_t(chosen_)].folder &&
                      !(entries_[std::size_t(chosen_)].project && wanted_ == Wanted::project);
  if (saves) {
    ImGui::SetNextItemWidth(-1);
    ImGui::InputText("##name", &name_);
    note_widget("browser name");
    fs::path file = folder_ / name_;
    if (file.extension() != ".json") file += ".json";
    std::error_code ignored;
    if (primary_button(fs::exists(file, ignored) ? "Replace it" : "Save", !name_.empty(), px(120)))
      picked = file;
  } else if (primary_button("Open", any, px(120))) {
    const fs::path path = folder_ / entries_[std::size_t(chosen_)].name;
    if (enters) {
      next = path;
    } else {
      picked = path;
    }
  }
  ImGui::SameLine();
  const bool escape = ImGui::IsKeyPressed(ImGui::GetIO().KeyMap[ImGuiKey_Escape]);
  if (plain_button("Cancel", true, px(120)) || escape || picked) {
    open_ = false;
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
  if (next) enter(*next);
  return picked;
}

}  // namespace likeness::ui
