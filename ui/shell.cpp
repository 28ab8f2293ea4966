// See shell.h.
#include "ui/shell.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <vector>

#include "ui/keyboard.h"
#include "ui/platform/imgui_versions.h"
#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kPathWidth = 264, kStatusHeight = 32;
constexpr ImGuiWindowFlags kFixed =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
    ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoScrollWithMouse;

// GLFW numbers keys by their place on a US keyboard; here the key that writes a letter in the user's layout.
int key_that_writes(char letter, int otherwise) {
  for (int k = GLFW_KEY_APOSTROPHE; k <= GLFW_KEY_GRAVE_ACCENT; ++k)
    if (const char* name = glfwGetKeyName(k, 0);
        name && name[0] && !name[1] && std::toupper(static_cast<unsigned char>(name[0])) == letter)
      return k;
  return otherwise;
}

int glfw_key(const std::string& key) {
  if (key.size() == 1) return key_that_writes(key[0], key[0]);
  if (key == "F1") return GLFW_KEY_F1;
  if (key == "Enter") return GLFW_KEY_ENTER;
  if (key == "Up") return GLFW_KEY_UP;
  if (key == "Down") return GLFW_KEY_DOWN;
  if (key == "Left") return GLFW_KEY_LEFT;
  if (key == "Right") return GLFW_KEY_RIGHT;
  if (key == "Home") return GLFW_KEY_HOME;
  if (key == "End") return GLFW_KEY_END;
  if (key == "Space") return GLFW_KEY_SPACE;
  if (key == "Delete") return GLFW_KEY_DELETE;
  if (key == "Plus") return key_that_writes('+', GLFW_KEY_EQUAL);
  if (key == "Minus") return key_that_writes('-', GLFW_KEY_MINUS);
  return -1;
}

bool is_pressed(const Shortcut& keys) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.KeyCtrl != keys.ctrl) return false;
  const auto pressed = [](int key) { return key_pressed(key, false); };
  // Plus is on the number pad as well, and many layouts write it only with Shift.
  const bool plus = keys.key == "Plus";
  if (plus && (pressed(GLFW_KEY_KP_ADD) || pressed(glfw_key(keys.key)))) return true;
  if (keys.key == "Minus" && pressed(GLFW_KEY_KP_SUBTRACT)) return true;
  return !plus && io.KeyShift == keys.shift && pressed(glfw_key(keys.key));
}

// Keys that a text field needs for itself while it is typed into.
bool belongs_to_typing(const Shortcut& keys) {
  constexpr std::array<std::string_view, 10> kEditing{"A", "C",    "V",     "X",    "Z",
                                                      "Y", "Left", "Right", "Home", "End"};
  return (!keys.ctrl && keys.key != "F1") || std::ranges::find(kEditing, keys.key) != kEditing.end();
}

void begin_part(const char* name, ImVec2 at, ImVec2 size, const ImVec4& ground, ImVec2 padding) {
  ImGui::SetNextWindowPos(at);
  ImGui::SetNextWindowSize(size);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ground);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, padding);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::Begin(name, nullptr, kFixed);
  ImGui::PopStyleVar(2);
  ImGui::PopStyleColor();
}

void draw_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  const StepView& view = snapshot.step(snapshot.shown);
  const float top = ImGui::GetCursorPosY();
  ImGui::PushFont(theme().fonts.heading);
  ImGui::TextUnformatted(step_words(snapshot.shown).data());
  ImGui::PopFont();
  const float below = top + theme().fonts.heading->FontSize + px(6) + ImGui::GetStyle().ItemSpacing.y;
  std::string words = view.found;
  if (!view.next.empty() && !view.error) words += (words.empty() ? "" : "  ") + view.next;
  if (!words.empty()) {
    ImGui::SameLine(0, px(14));
    const bool fits = ImGui::CalcTextSize(words.c_str()).x <= ImGui::GetContentRegionAvail().x;
    if (fits) {
      ImGui::SetCursorPosY(ImGui::GetCursorPosY() + px(6));
    } else {
      ImGui::NewLine();  // large letters in a small window: below the heading, in as many lines as it takes
    }
    faint_text(words);
  }
  // What is below keeps its place whether there are words or not.
  ImGui::SetCursorPosY(std::max(below, ImGui::GetCursorPosY()));
  ImGui::Dummy({0, px(2)});
  if (!snapshot.project.contents) return draw_nothing_yet("Reading the project...");
  switch (snapshot.shown) {
    case Step::film:
      return draw_film_step(snapshot, views, requests);
    case Step::check:
      return draw_check_step(snapshot, views, requests);
    case Step::cameras:
      return draw_cameras_step(snapshot, views, requests);
    case Step::face:
      return draw_face_step(snapshot, views, requests);
    case Step::train:
      return draw_train_step(snapshot, views, requests);
    case Step::direct:
      return draw_direct_step(snapshot, views, requests);
    case Step::export_out:
      return draw_export_step(snapshot, views, requests);
  }
}

// In as many columns as fit; scrolled if they are still too high.
void draw_shortcuts() {
  heading("Keyboard shortcuts");
  std::vector<std::pair<std::string_view, std::string_view>> rows{
      {"Go to the next control", "Tab"}, {"Press it", "Enter"}, {"Go to the menus", "F10"}};
  for (const CommandInfo& info : command_table())
    if (!info.shortcut.empty()) rows.emplace_back(info.words, info.shortcut);
  const ImVec2 screen = ImGui::GetMainViewport()->WorkSize;
  const float width = std::min(px(1100), 0.86f * screen.x);
  const std::size_t columns = width >= px(1000)  ? 3
                              : width >= px(700) ? 2
                                                 : 1,
                    high = (rows.size() + columns - 1) / columns;
  const float line = ImGui::GetTextLineHeight() + 2 * px(3);
  ImGui::BeginChild("key list", {width, std::min((float(high) + 0.5f) * line, 0.68f * screen.y)});
  scroll_by_keys();
  ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, ImVec2(px(8), px(3)));
  if (ImGui::BeginTable("keys", int(2 * columns), ImGuiTableFlags_None)) {
    for (std::size_t c = 0; c < columns; ++c) {
      ImGui::TableSetupColumn(fmt::format("words {}", c).c_str(), ImGuiTableColumnFlags_WidthStretch);
      ImGui::TableSetupColumn(fmt::format("keys {}", c).c_str(), ImGuiTableColumnFlags_WidthFixed, px(130));
    }
    for (std::size_t r = 0; r < high; ++r) {
      ImGui::TableNextRow();
      for (std::size_t c = 0; c < columns && c * high + r < rows.size(); ++c) {
        const auto& [words, keys] = rows[c * high + r];
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(words.data(), words.data() + words.size());
        ImGui::TableNextColumn();
        ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
        ImGui::TextUnformatted(keys.data(), keys.data() + keys.size());
        ImGui::PopStyleColor();
      }
    }
    ImGui::EndTable();
  }
  ImGui::PopStyleVar();
  ImGui::EndChild();
  note_view("key list");
}

// Whether the thing that a command turns on and off is on now.
bool is_on(Command command, const Snapshot& snapshot) {
  switch (command) {
    case Command::record_keys:
      return snapshot.direct.directing.record_keys;
    case Command::repeat:
      return snapshot.direct.directing.looping;
    case Command::compare:
      return snapshot.direct.comparing;
    case Command::record_drive:
      return snapshot.direct.live.status.recording;
    default:
      return false;
  }
}

bool keeps_work(const Snapshot& snapshot) {
  return is_working(snapshot.project.pipeline.job) || is_working(snapshot.study.job) ||
         snapshot.situation.recording;
}

// What ends when the program does, and how much of it is kept.
void draw_closing(const Snapshot& snapshot) {
  const bool exporting = snapshot.situation.exporting, recording = snapshot.situation.recording;
  heading(recording                           ? "A clip is being recorded"
          : is_working(snapshot.study.job)    ? "Methods are being compared"
          : keeps_work(snapshot)              ? "An avatar is being made"
          : exporting                         ? "Something is being exported"
          : is_working(snapshot.project.demo) ? "The demo person is being filmed"
                                              : "The work has finished in the meantime");
  ImGui::Dummy({px(460), 0});
  if (is_working(snapshot.project.pipeline.job))
    body_text(
        "Closing stops the work. What is done is kept, and the work continues from there when you open the "
        "project again.");
  if (is_working(snapshot.study.job))
    body_text("Closing stops the comparison. Finished trainings are kept, and it continues from there.");
  if (recording)
    body_text("Closing ends the recording. What has been recorded is kept: " +
              snapshot.recorder->clip.string());
  if (exporting)
    body_text(
        "Closing stops the exports. Finished ones are kept; the one under way leaves nothing behind, and "
        "those still waiting are dropped.");
  if (is_working(snapshot.project.demo))
    body_text("Closing stops it, and nothing of it is kept: it starts afresh next time.");
  ImGui::Dummy({0, px(6)});
}

// Asks before everything made of a person is deleted. True once it is answered.
bool draw_deletion(const Snapshot& snapshot, Requests& requests) {
  heading("Delete this person?");
  ImGui::Dummy({px(560), 0});
  if (!snapshot.project.contents && !snapshot.project.damaged) return true;
  const std::filesystem::path& folder = snapshot.project.contents ? snapshot.project.contents->project.folder
                                                                  : snapshot.project.damaged->folder;
  body_text(
      "Frames, masks and what was painted on them, tracks, checkpoints, performances and the avatar are "
      "removed from this computer, and cannot be brought back. Stop other programs that show them first.");
  ImGui::Dummy({0, px(4)});
  if (snapshot.project.contents) {
    faint_text("The clip stays where it is: " +
               snapshot.project.contents->project.options.shared.video.string());
  } else if (!snapshot.project.damaged->clips.empty()) {
    faint_text("The clip stays where it is: " + snapshot.project.damaged->clips.front().string());
  } else {
    body_text(
        "This project is damaged and no longer says which film is the clip: folders with films in them, "
        "exports included, are kept for you to look through.");
  }
  faint_text("The project: " + folder.string());
  ImGui::Dummy({0, px(6)});
  bool answered = false;
  if (plain_button("Delete all, exports too")) requests.project.delete_person = false, answered = true;
  ImGui::SameLine();
  if (plain_button("Delete, but keep the exports")) requests.project.delete_person = true, answered = true;
  ImGui::SameLine();
  if (primary_button("Keep the person")) answered = true;
  return answered;
}

// Of two windows that save the same files, one would undo what was done in the other. True once it is
// answered.
bool draw_elsewhere(const Snapshot& snapshot, Requests& requests) {
  if (!snapshot.project.elsewhere) return true;
  heading("This project is open in another window");
  ImGui::Dummy({px(560), 0});
  body_text(
      "Here you can look at it and turn the avatar; what you do is not saved, and nothing is made, painted "
      "or "
      "exported. To work in this window, close the project in the other one first.");
  faint_text("The project: " + snapshot.project.elsewhere->string());
  ImGui::Dummy({0, px(6)});
  if (primary_button("Open to look at only")) requests.project.look_only = true;
  ImGui::SameLine();
  if (plain_button("Do not open")) requests.project.look_only = false;
  return requests.project.look_only.has_value();
}

// What was done or went wrong, in the lower right corner, until it is dismissed.
void draw_notices(const Snapshot& snapshot, Requests& requests) {
  if (!snapshot.error && snapshot.message.empty()) return;
  const ImGuiViewport& screen = *ImGui::GetMainViewport();
  const float width = std::min(px(520), screen.Size.x - px(40));
  ImGui::SetNextWindowPos(
      {screen.Pos.x + screen.Size.x - px(20), screen.Pos.y + screen.Size.y - px(kStatusHeight + 16)},
      ImGuiCond_Always, {1, 1});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, theme().colours.panel);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1);
  ImGui::Begin("notice", nullptr,
               (kFixed & ~ImGuiWindowFlags_NoBringToFrontOnFocus) | ImGuiWindowFlags_NoFocusOnAppearing);
  if (snapshot.error) {
    note("what", Tone::bad, snapshot.error->what, snapshot.error->fix);
    if (snapshot.situation.repairable) {
      if (command_button(Command::repair_project, snapshot.situation, true))
        requests.ask(Command::repair_project);
      (void)same_line_if_fits(command_info(Command::delete_person).words.data());
    }
    if (snapshot.projects_refuse) {
      if (command_button(Command::choose_projects, snapshot.situation, true))
        requests.ask(Command::choose_projects);
      (void)same_line_if_fits("Dismiss");
    }
    if (snapshot.situation.damaged) {
      if (command_button(Command::delete_person, snapshot.situation)) requests.ask(Command::delete_person);
      (void)same_line_if_fits("Dismiss");
    }
    if (snapshot.situation.repairable || snapshot.projects_refuse ? plain_button("Dismiss")
                                                                  : primary_button("Dismiss"))
      requests.dismiss_error = true;
    (void)same_line_if_fits(command_info(Command::save_diagnostics).words.data());
    if (command_button(Command::save_diagnostics, snapshot.situation))
      requests.ask(Command::save_diagnostics);
  } else {
    note("what", Tone::plain, snapshot.message);
    if (plain_button("Dismiss")) requests.dismiss_message = true;
  }
  ImGui::End();
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
}

}  // namespace

Result<std::unique_ptr<Shell>> Shell::create(std::function<void()> wake) {
  auto views = Views::create();
  if (!views) return views.error();
  auto shell = std::make_unique<Shell>(std::move(wake));
  shell->views_ = std::move(*views);
  return shell;
}

void Shell::draw_menus(const Snapshot& snapshot, Requests& requests) {
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(px(10), px(8)));
  if (ImGui::BeginMainMenuBar()) {
    for (const Menu menu : {Menu::file, Menu::edit, Menu::timeline, Menu::avatar, Menu::view, Menu::help}) {
      const bool open = ImGui::BeginMenu(menu_words(menu).data());
      note_view(std::string("menu ") + menu_words(menu).data());
      if (menu == Menu::file && !open) note_first_menu();
      if (!open) continue;
      for (const CommandInfo& info : command_table()) {
        if (info.menu != menu) continue;
        if (info.begins_group) ImGui::Separator();
        if (ImGui::MenuItem(info.words.data(), info.shortcut.data(), is_on(info.command, snapshot),
                            info.enabled(snapshot.situation)))
          requests.ask(info.command);
        note_widget(std::string("item ") + info.words.data());
      }
      ImGui::EndMenu();
    }
    ImGui::EndMainMenuBar();
  }
  ImGui::PopStyleVar();
}

void Shell::press_keys(const Snapshot& snapshot, Requests& requests) {
  const ImGuiIO& io = ImGui::GetIO();
  if (browser_.is_open() || shown_ != Question::none) return;
  for (const CommandInfo& info : command_table()) {
    if (info.shortcut.empty() || !info.enabled(snapshot.situation)) continue;
    const Shortcut keys = parse_shortcut(info.shortcut);
    if (io.WantTextInput && belongs_to_typing(keys)) continue;
    if (keys.key == "Space" && io.NavVisible) continue;  // it presses the focused control
    if (is_pressed(keys)) requests.ask(info.command);
  }
}

void Shell::draw_questions(const Snapshot& snapshot, Requests& requests) {
  constexpr const char* kPopup = "question";
  if (asked_ != Question::none) {
    shown_ = std::exchange(asked_, Question::none);
    ImGui::OpenPopup(kPopup);
  }
  if (shown_ == Question::none) return;
  ImGui::SetNextWindowPos(ImGui::GetMainViewport()->GetCenter(), ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(px(26), px(22)));
  const bool open = ImGui::BeginPopupModal(
      kPopup, nullptr,
      ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove);
  ImGui::PopStyleVar();
  if (!open) {
    shown_ = Question::none;
    return;
  }
  bool close = key_pressed(GLFW_KEY_ESCAPE);
  if (shown_ == Question::closing) {
    draw_closing(snapshot);
    if (primary_button(keeps_work(snapshot) ? "Keep and stop" : "Stop and quit")) {
      closing_ = Closing::keep_and_stop;
      close = true;
    }
    ImGui::SameLine();
    if (plain_button(snapshot.situation.recording ? "Go on recording" : "Go on working")) close = true;
  } else if (shown_ == Question::delete_person) {
    close |= draw_deletion(snapshot, requests);
  } else if (shown_ == Question::open_elsewhere) {
    if (close) requests.project.look_only = false;
    close |= draw_elsewhere(snapshot, requests);
  } else {
    if (shown_ == Question::shortcuts) draw_shortcuts();
    if (shown_ == Question::film_guide) draw_film_guide();
    if (shown_ == Question::licences) draw_licences();
    ImGui::Dummy({0, px(6)});
    if (primary_button("Close", true, px(120))) close = true;
  }
  if (close) {
    shown_ = Question::none;
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

Requests Shell::draw(const Snapshot& snapshot) {
  Requests requests;
  forget_widgets();
  press_keys(snapshot, requests);
  draw_menus(snapshot, requests);
  const ImGuiViewport& screen = *ImGui::GetMainViewport();
  const float top = screen.WorkPos.y, status = px(kStatusHeight), height = screen.WorkSize.y - status;
  const Palette& p = theme().colours;
  if (snapshot.recorder) {
    begin_part("record", {0, top}, {screen.Size.x, height}, p.ground, {px(22), px(16)});
    draw_record_page(snapshot, *views_, requests);
    ImGui::End();
  } else if (!snapshot.project.contents && !snapshot.project.loading) {
    begin_part("start", {0, top}, {screen.Size.x, height}, p.ground, {px(40), px(28)});
    draw_start_screen(snapshot, requests);
    ImGui::End();
  } else {
    const float path = std::min(px(kPathWidth), 0.25f * screen.Size.x);
    begin_part("path", {0, top}, {path, height}, p.panel, {px(14), px(14)});
    draw_path(snapshot, requests);
    ImGui::End();
    begin_part("step", {path, top}, {screen.Size.x - path, height}, p.ground, {px(22), px(16)});
    draw_step(snapshot, *views_, requests);
    ImGui::End();
  }
  begin_part("status", {0, top + height}, {screen.Size.x, status}, p.panel, {px(16), px(6)});
  draw_status_bar(snapshot, requests);
  ImGui::End();
  draw_notices(snapshot, requests);
  if (snapshot.project.elsewhere && shown_ == Question::none) ask(Question::open_elsewhere);
  draw_questions(snapshot, requests);
  if (requests.browse) {
    const bool in_project = *requests.browse == Wanted::export_performance && snapshot.project.contents;
    browse(*requests.browse, in_project ? snapshot.project.contents->project.folder : home_folder());
  }
  if (const auto picked = browser_.draw(snapshot.projects)) take_picked(*picked, snapshot, requests);
  walk_by_keyboard();
  return requests;
}

void Shell::take_picked(const std::filesystem::path& picked, const Snapshot& snapshot, Requests& requests) {
  ExportChoice choice = requests.exports.choice.value_or(snapshot.exports.choice);
  switch (browser_.wanted()) {
    case Wanted::clip:
    case Wanted::project:
      requests.open = picked;
      return;
    case Wanted::projects:
      requests.projects = picked;
      return;
    case Wanted::driving_clip:
      choice.clip = picked;
      break;
    case Wanted::background:
      choice.picture = picked;
      choice.ground = ExportGround::picture;
      break;
    case Wanted::driver:
      requests.direct.drive_video = picked;
      return;
    case Wanted::performance:
      requests.direct.open_performance = picked;
      return;
    case Wanted::new_performance:
      requests.direct.save_performance = picked;
      return;
    case Wanted::export_performance:
      choice.performance = picked;
      break;
    case Wanted::moved_clip:
      requests.project.relink = picked;
      return;
    case Wanted::further_clip:
      requests.project.add_clip = picked;
      return;
  }
  requests.exports.choice = choice;
}

}  // namespace likeness::ui
