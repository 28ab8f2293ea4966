// See file_browser.h.
#include "ui/file_browser.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <utility>

#include "ui/letters.h"
#include "ui/platform/imgui_versions.h"
#include "ui/platform/settings.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

const char* title_of(Wanted wanted) {
  switch (wanted) {
    case Wanted::clip:
      return "Open a clip";
    case Wanted::project:
      return "Open a project";
    case Wanted::projects:
      return "Folder of new projects";
    case Wanted::driver:
      return "Drive from a video";
    case Wanted::driving_clip:
      return "A clip that drives the avatar";
    case Wanted::background:
      return "A picture for the background";
    case Wanted::performance:
      return "Open a performance";
    case Wanted::new_performance:
      return "Save the performance as";
    case Wanted::export_performance:
      return "A performance to export";
    case Wanted::moved_clip:
      return "Where is the clip now?";
    case Wanted::further_clip:
      return "Another clip of this person";
  }
  return "";
}

const char* nothing_of(Wanted wanted) {
  switch (wanted) {
    case Wanted::clip:
    case Wanted::driver:
    case Wanted::driving_clip:
    case Wanted::moved_clip:
    case Wanted::further_clip:
      return "There are no folders or videos here.";
    case Wanted::background:
      return "There are no folders or pictures here.";
    case Wanted::performance:
    case Wanted::new_performance:
    case Wanted::export_performance:
      return "There are no folders or performances here.";
    case Wanted::project:
    case Wanted::projects:
      return "There are no folders here.";
  }
  return "";
}

std::string size_words(std::uintmax_t bytes) {
  if (bytes < 1u << 20) return fmt::format("{} kB", std::max<std::uintmax_t>(1, bytes >> 10));
  return fmt::format("{} MB", bytes >> 20);
}

void draw_icon(const FolderEntry& entry, ImVec2 at, float side) {
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

}  // namespace

FileBrowser::FileBrowser(std::function<void()> wake)
    : reader_([this](const std::string&) { reading_ = false; }, std::move(wake)) {}

void FileBrowser::open(Wanted wanted, const fs::path& start) {
  open_ = appear_ = true;
  wanted_ = wanted;
  name_ = "performance-1.json";
  std::error_code ignored;
  enter(fs::is_directory(start, ignored) ? start : home_folder());
}

void FileBrowser::enter(const fs::path& folder) {
  std::error_code failure;
  const fs::path absolute = fs::absolute(folder.empty() ? "/" : folder, failure).lexically_normal();
  folder_ = failure ? folder : absolute;
  if (folder_.has_relative_path() && folder_.filename().empty()) folder_ = folder_.parent_path();
  typed_ = folder_.string();
  chosen_ = -1;
  entries_.clear();
  reading_ = true;
  // In the background: a folder may be large, or on a disk that sleeps.
  reader_.run("list", [this, folder = folder_, wanted = wanted_](std::stop_token) -> Background::Delivery {
    auto entries = list_folder(folder, wanted);
    return [this, folder, wanted, entries = std::move(entries)]() mutable {
      if (folder != folder_ || wanted != wanted_) return;
      entries_ = std::move(entries);
      reading_ = false;
    };
  });
}

std::optional<fs::path> FileBrowser::draw(const fs::path& projects) {
  reader_.deliver();
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
  if (plain_button("Projects")) next = projects;
  ImGui::SameLine();
  if (plain_button("Up")) next = folder_.parent_path();
  ImGui::SetNextItemWidth(-1);
  std::string field = for_window(typed_);
  const bool entered = ImGui::InputText("##path", &field, ImGuiInputTextFlags_EnterReturnsTrue);
  typed_ = from_window(field);
  if (entered) {
    std::error_code ignored;
    const fs::path typed(typed_);
    if (fs::is_directory(typed, ignored) &&
        !(wanted_ == Wanted::project && fs::exists(typed / "project.json", ignored))) {
      next = typed;
    } else if (wanted_ == Wanted::projects || (fs::exists(typed, ignored) && !saves)) {
      picked = typed;  // a folder that is not there yet is made
    }
  }
  note_widget("browser path");
  begin_card("entries", {0, -float(saves ? 2 : 1) * ImGui::GetFrameHeightWithSpacing() - px(6)}, true);
  if (entries_.empty()) faint_text(reading_ ? "Reading\u2026" : nothing_of(wanted_));
  const float line = ImGui::GetTextLineHeight();
  for (int i = 0; i < int(entries_.size()); ++i) {
    const FolderEntry& entry = entries_[std::size_t(i)];
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
      const std::string size = size_words(entry.bytes);
      ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(size.c_str()).x - px(6));
      ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
      ImGui::TextUnformatted(size.c_str());
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
    std::string name = for_window(name_);
    ImGui::InputText("##name", &name);
    name_ = from_window(name);
    note_widget("browser name");
    fs::path file = folder_ / name_;
    if (file.extension() != ".json") file += ".json";
    std::error_code ignored;
    if (primary_button(fs::exists(file, ignored) ? "Replace it" : "Save", !name_.empty(), px(120)))
      picked = file;
  } else if (wanted_ == Wanted::projects) {
    if (primary_button("Use this folder", true, px(150)))
      picked = any ? folder_ / entries_[std::size_t(chosen_)].name : folder_;
  } else if (primary_button("Open", any, px(120))) {
    const fs::path path = folder_ / entries_[std::size_t(chosen_)].name;
    if (enters) {
      next = path;
    } else {
      picked = path;
    }
  }
  ImGui::SameLine();
  const bool escape = key_pressed(GLFW_KEY_ESCAPE);
  if (plain_button("Cancel", true, px(120)) || escape || picked) {
    open_ = false;
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
  if (next) enter(*next);
  return picked;
}

}  // namespace likeness::ui
