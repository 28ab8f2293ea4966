// Step 7: what is exported, how, and the queue of exports.
#include <fmt/format.h>

#include <cmath>

#include "ui/steps.h"
#include "ui/studio/channel_words.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr float kLabel = 108;

struct KindWords {
  const char* words;
  const char* what;
  Command command;
};

const KindWords& words_of(ExportKind kind) {
  static constexpr KindWords kWords[] = {
      {"A still", "One PNG of the avatar as it stands in Direct.", Command::export_still},
      {"An orbit", "The view swings to both sides of the posed avatar and back.", Command::export_orbit},
      {"The performance", "What was directed on the timeline, with its camera.", Command::export_performance},
      {"A driven clip", "The avatar does what a person in another clip does, with that clip's sound.",
       Command::export_driven},
      {"The head's mesh", "The posed head for other programs, without hair and colour.",
       Command::export_mesh}};
  return kWords[std::size_t(kind)];
}

void row_label(const char* words) {
  const float start = ImGui::GetCursorPosX();
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(words);
  ImGui::SameLine(start + px(kLabel));
}

// The next choice of a row: on the same line if it fits, otherwise below the first one.
bool next_choice(const char* words, bool chosen) {
  if (!same_line_if_fits(words)) {
    ImGui::Dummy({px(kLabel) - ImGui::GetStyle().ItemSpacing.x, 0});
    ImGui::SameLine();
  }
  return choice(words, chosen);
}

void chosen_file(const char* button, const std::filesystem::path& file, const char* none, Wanted wanted,
                 Requests& requests) {
  if (plain_button(button)) requests.browse = wanted;
  ImGui::SameLine(0, px(12));
  ImGui::AlignTextToFramePadding();
  ImGui::PushStyleColor(ImGuiCol_Text, theme().colours.faint);
  clipped_text(file.empty() ? none : file.filename().string(), ImGui::GetContentRegionAvail().x);
  ImGui::PopStyleColor();
  if (!file.empty()) tooltip(file.string());
}

void draw_orbit_choices(const ProjectAvatar& avatar, ExportChoice& asked) {
  const float width = std::max(px(120), ImGui::GetContentRegionAvail().x - px(kLabel) - px(8));
  constexpr float kOwnAngle_deg = 25;
  const ValueRange whole = orbit_of(avatar);
  choice_label("How far", px(kLabel));
  const std::string words = fmt::format("{:.0f}\u00b0 and {:.0f}\u00b0", -whole.low, whole.high);
  if (choice(words.c_str(), !asked.half_angle_deg)) asked.half_angle_deg.reset();
  if (next_choice("My own", asked.half_angle_deg.has_value()) && !asked.half_angle_deg)
    asked.half_angle_deg = kOwnAngle_deg;
  if (!asked.half_angle_deg)
    faint_text(limits_hold(avatar.avatar, "camera yaw") ? "As far as the avatar holds."
                                                        : "About as far as the clip shows.");
  if (asked.half_angle_deg) {
    row_label("To each side");
    float angle = float(*asked.half_angle_deg);
    if (slider("##orbit angle", &angle, {.low = 5, .high = kOrbitLimit_deg, .rest = kOwnAngle_deg},
               "%.0f\u00b0", width))
      asked.half_angle_deg = std::round(angle);
  }
  float seconds = float(asked.seconds);
  row_label("Length");
  if (slider("##orbit length", &seconds, {.low = 0.4f, .high = 20, .rest = 4}, "%.1f s", width))
    asked.seconds = std::round(10 * seconds) / 10;
}

void draw_kinds(const Snapshot& snapshot, ExportChoice& asked, Requests& requests) {
  strong_text("What");
  for (const ExportKind kind : kExportKinds)
    if (choice(words_of(kind).words, asked.kind == kind)) asked.kind = kind;
  ImGui::Dummy({0, px(4)});
  faint_text(words_of(asked.kind).what);
  ImGui::Dummy({0, px(2)});
  const bool performs =
      asked.kind == ExportKind::performance || (asked.kind == ExportKind::mesh && asked.moving);
  if (asked.kind == ExportKind::orbit) draw_orbit_choices(*snapshot.project.contents->avatar, asked);
  if (asked.kind == ExportKind::mesh) {
    choice_label("Moves", px(kLabel));
    if (choice("No, as posed", !asked.moving)) asked.moving = false;
    if (next_choice("It performs", asked.moving)) asked.moving = true;
  }
  if (performs) {
    chosen_file("Choose a performance...", asked.performance, "The one directed in this project",
                Wanted::export_performance, requests);
    if (!asked.performance.empty() && plain_button("Take the project's own")) asked.performance.clear();
  }
  if (asked.kind == ExportKind::driven) {
    chosen_file("Choose a clip...", asked.clip, "No clip is chosen yet", Wanted::driving_clip, requests);
    choice_label("Head", px(kLabel));
    if (choice("Moves as driven", !asked.keep_head)) asked.keep_head = false;
    if (next_choice("Stays", asked.keep_head)) asked.keep_head = true;
    choice_label("Beside it", px(kLabel));
    if (choice("Nothing", !asked.side_by_side)) asked.side_by_side = false;
    ImGui::BeginDisabled(asked.ground == ExportGround::transparent);
    if (next_choice("The driver", asked.side_by_side)) asked.side_by_side = true;
    ImGui::EndDisabled();
  }
}

DirectedScene scene_of(const Snapshot& snapshot) {
  const DirectingView& directing = snapshot.direct.directing;
  return directed_scene(*directing.performance, directing.view);
}

void draw_background(const Snapshot& snapshot, ExportChoice& asked, Requests& requests) {
  const auto ground = [&](const char* words, ExportGround of, bool first = false) {
    if (first ? choice(words, asked.ground == of) : next_choice(words, asked.ground == of)) asked.ground = of;
  };
  choice_label("Background", px(kLabel));
  const bool room = room_possible(asked, scene_of(snapshot), snapshot.project.contents->avatar->avatar);
  ImGui::BeginDisabled(!room);
  ground("The filmed room", ExportGround::room, true);
  ImGui::EndDisabled();
  if (!room)
    tooltip(
        "The room is known only from where the camera stood: not for an orbit, nor for a turned or nearer "
        "view. "
        "A clip that begins with a walk round the head shows it from everywhere.");
  ground("Light", ExportGround::light);
  ground("Dark", ExportGround::dark);
  ground("A colour", ExportGround::colour);
  ground("A picture", ExportGround::picture);
  ground("Transparent", ExportGround::transparent);
  if (asked.ground == ExportGround::colour) {
    row_label("");
    ImGui::SetNextItemWidth(px(230));
    ImGui::ColorEdit3("##colour", asked.colour.data(), ImGuiColorEditFlags_DisplayHex);
    note_widget("##colour");
  }
  if (asked.ground == ExportGround::picture) {
    row_label("");
    chosen_file("Choose a picture...", asked.picture, "No picture is chosen yet", Wanted::background,
                requests);
  }
}

void draw_rate(ExportChoice& asked) {
  choice_label("Pictures/s", px(kLabel));
  bool first = true;
  for (const int rate : {24, 25, 30, 50, 60}) {
    const std::string words = fmt::format("{}", rate);
    const bool chosen = asked.frames_per_second == rate;
    if (first ? choice(words.c_str(), chosen) : next_choice(words.c_str(), chosen))
      asked.frames_per_second = rate;
    first = false;
  }
}

void draw_manner(const Snapshot& snapshot, ExportChoice& asked, Requests& requests) {
  strong_text("How");
  const bool moves = asked.kind == ExportKind::orbit || asked.kind == ExportKind::performance;
  if (!makes_pictures(asked)) {
    choice_label("File", px(kLabel));
    if (choice("glTF (.glb)", asked.mesh == MeshForm::glb)) asked.mesh = MeshForm::glb;
    ImGui::BeginDisabled(asked.moving);
    if (next_choice("PLY", asked.mesh == MeshForm::ply)) asked.mesh = MeshForm::ply;
    ImGui::EndDisabled();
    if (asked.moving) {
      tooltip("A PLY holds one moment only.");
      draw_rate(asked);
    }
    return;
  }
  const int size = snapshot.project.contents->avatar->avatar.size;
  if (asked.kind != ExportKind::still) {
    choice_label("File", px(kLabel));
    ImGui::BeginDisabled(asked.ground == ExportGround::transparent);
    if (choice("Film (MP4)", asked.form == ExportForm::film)) asked.form = ExportForm::film;
    ImGui::EndDisabled();
    if (asked.ground == ExportGround::transparent) tooltip("An MP4 holds no transparency.");
    if (next_choice("Pictures (PNG)", asked.form == ExportForm::pictures)) asked.form = ExportForm::pictures;
  }
  choice_label("Size", px(kLabel));
  for (int times = 1; times <= kMostTimes; times *= 2) {
    const std::string words = fmt::format("{} px", times * size);
    if (times == 1 ? choice(words.c_str(), asked.times == times)
                   : next_choice(words.c_str(), asked.times == times))
      asked.times = times;
  }
  if (moves) draw_rate(asked);
  draw_background(snapshot, asked, requests);
  choice_label("Visible mark", px(kLabel));
  if (choice("None", !asked.mark)) asked.mark = false;
  if (next_choice("\"synthetic - Likeness\"", asked.mark)) asked.mark = true;
  ImGui::Dummy({0, px(2)});
  faint_text("Every file is labelled synthetic inside, with or without the visible mark.");
}

std::string item_words(const ExportItem& item) {
  const JobStatus& status = item.status;
  switch (status.state) {
    case JobState::none:
      return "Waits for its turn";
    case JobState::running: {
      const std::string left = time_left(status.seconds_left);
      return status.text + (left.empty() || status.text.empty() ? "" : "  \u00b7  ") + left;
    }
    case JobState::stopping:
      return "Stopping\u2026";
    case JobState::done:
      return fmt::format("Done in {}: {}", duration(status.seconds), status.outcome);
    case JobState::failed:
      return status.error ? status.error->what : "Failed";
    case JobState::stopped:
      return "Stopped; nothing half-written is left.";
  }
  return {};
}

void draw_item(const ExportItem& item, Requests& requests) {
  const JobState state = item.status.state;
  const bool working = is_working(item.status);
  ImGui::PushID(item.number);
  const Palette& p = theme().colours;
  // The buttons are at the right edge, however many there are.
  const ImGuiStyle& style = ImGui::GetStyle();
  const auto width_of = [&](const char* words) {
    return ImGui::CalcTextSize(words).x + 2 * style.FramePadding.x;
  };
  const char* own = working || state == JobState::none ? "Stop" : "Remove from the list";
  const bool again = state == JobState::failed || state == JobState::stopped;
  const float buttons = width_of(own) + (again ? width_of("Try again") + style.ItemSpacing.x : 0),
              line = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float wide = ImGui::GetContentRegionAvail().x - buttons - px(12);
  draw_mark(*ImGui::GetWindowDrawList(), {at.x + 0.55f * line, at.y + 0.62f * line}, line,
            working                      ? StepMark::running
            : state == JobState::done    ? StepMark::done
            : state == JobState::failed  ? StepMark::failed
            : state == JobState::stopped ? StepMark::attention
                                         : StepMark::number,
            item.number);
  ImGui::SetCursorScreenPos({at.x + 1.6f * line, at.y});
  ImGui::BeginGroup();
  ImGui::PushFont(theme().fonts.strong);
  clipped_text(item.out.filename().string(), wide - 1.6f * line);
  ImGui::PopFont();
  ImGui::PushStyleColor(ImGuiCol_Text, state == JobState::failed ? p.bad : p.faint);
  clipped_text(item_words(item), wide - 1.6f * line);
  ImGui::PopStyleColor();
  if (state == JobState::failed && item.status.error) {
    ImGui::PushStyleColor(ImGuiCol_Text, p.faint);
    clipped_text(item.status.error->fix, wide - 1.6f * line);
    ImGui::PopStyleColor();
  }
  ImGui::EndGroup();
  ImGui::SameLine(ImGui::GetContentRegionMax().x - buttons);
  ImGui::BeginGroup();
  if (again) {
    if (plain_button("Try again")) requests.exports.retry = item.number;
    ImGui::SameLine();
  }
  if (plain_button(own, state != JobState::stopping))
    (working || state == JobState::none ? requests.exports.stop : requests.exports.forget) = item.number;
  ImGui::EndGroup();
  if (working) progress_bar(float(item.status.fraction), 4);
  ImGui::Dummy({0, px(2)});
  ImGui::PopID();
}

void draw_queue(const Snapshot& snapshot, Requests& requests) {
  if (!snapshot.exports.items.empty()) ImGui::AlignTextToFramePadding();
  strong_text("Exports");
  if (snapshot.exports.items.empty()) {
    faint_text("Files go to " + (snapshot.project.contents->project.folder / "exports").string());
    return;
  }
  ImGui::SameLine(0, px(16));
  if (command_button(Command::show_exports, snapshot.situation)) requests.ask(Command::show_exports);
  if (snapshot.situation.exporting && same_line_if_fits(command_info(Command::stop_export).words.data()))
    if (command_button(Command::stop_export, snapshot.situation)) requests.ask(Command::stop_export);
  for (auto item = snapshot.exports.items.rbegin(); item != snapshot.exports.items.rend(); ++item)
    draw_item(*item, requests);
  faint_text("Files are in " + (snapshot.project.contents->project.folder / "exports").string());
}

// What is exported begins like this.
void draw_first(const Snapshot& snapshot, Views& views, ImVec2 size) {
  const FramePicture& first = snapshot.exports.first;
  views.first.follow(first);
  begin_card("first", size);
  strong_text("The first picture");
  if (first.image && !views.first.texture.empty()) {
    draw_picture("first picture", views.first.texture, ImGui::GetContentRegionAvail());
  } else {
    draw_nothing_yet(first.missing.empty() ? "Rendering\u2026" : first.missing.c_str());
  }
  end_card();
}

// What must be chosen before the export; empty: nothing.
std::string missing_words(const ExportChoice& choice, const Performance& directed) {
  if (choice.kind == ExportKind::driven && choice.clip.empty())
    return "Choose the clip that drives the avatar first.";
  const bool performs = choice.kind == ExportKind::performance || (!makes_pictures(choice) && choice.moving);
  if (performs && choice.performance.empty() && directed.channels.empty())
    return "There is no performance yet: direct one in the Direct step, or choose a performance file.";
  if (makes_pictures(choice) && choice.ground == ExportGround::picture && choice.picture.empty())
    return "Choose the picture of the background first.";
  return {};
}

// The height of what the card held, for the next frame.
void note_height(float& height) {
  height = ImGui::GetCursorPosY() - ImGui::GetStyle().ItemSpacing.y + ImGui::GetStyle().WindowPadding.y;
}

}  // namespace

void draw_export_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  if (!snapshot.project.contents || !snapshot.project.contents->avatar) {
    draw_nothing_yet("Pictures and films of the avatar are written here, as soon as there is one.");
    return;
  }
  if (!snapshot.situation.consent)
    note("consent", Tone::warn, "Whether the filmed person agreed was not answered yet.",
         "Answer it in the Film step.");
  if (snapshot.situation.running && !snapshot.situation.paused)
    note("busy", Tone::plain, "The avatar is being made: pause or finish that before exporting.");
  if (snapshot.situation.studying)
    note("compared", Tone::plain,
         "Methods are being compared: wait until that ends, or stop it, before exporting.");
  // In a low window the whole step scrolls, so that the queue is never squeezed to nothing.
  const bool narrow = ImGui::GetContentRegionAvail().x < px(520);  // large letters: one card below the other
  const bool low = narrow || ImGui::GetContentRegionAvail().y < px(430);
  if (low) ImGui::BeginChild("export step", ImGui::GetContentRegionAvail());
  const ImVec2 area = ImGui::GetContentRegionAvail();
  // Nothing scrolls inside what scrolls: the cards are then as high as what is in them.
  const float both = std::max(views.export_what, views.export_how), gap = px(16);
  const float tall = low ? both : std::max(px(200), std::min(px(364), 0.6f * area.y));
  const Avatar& avatar = snapshot.project.contents->avatar->avatar;
  const ExportChoice shown = settled(snapshot.exports.choice, scene_of(snapshot), avatar);
  ExportChoice asked = shown;
  begin_card("what", {narrow ? 0 : 0.42f * (area.x - gap), narrow ? views.export_what : tall}, true);
  draw_kinds(snapshot, asked, requests);
  note_height(views.export_what);
  end_card();
  if (!narrow) ImGui::SameLine(0, gap);
  begin_card("how", {0, narrow ? views.export_how : tall}, true);
  draw_manner(snapshot, asked, requests);
  note_height(views.export_how);
  end_card();
  const ExportChoice wished = with_wishes(snapshot.exports.choice, shown, asked);
  if (!(wished == snapshot.exports.choice)) requests.exports.choice = wished;
  asked = settled(wished, scene_of(snapshot), avatar);
  const Command command = words_of(asked.kind).command;
  const std::string missing = missing_words(asked, *snapshot.direct.directing.performance);
  const std::string beside = !missing.empty()               ? missing
                             : snapshot.situation.exporting ? "It will follow those below."
                                                            : "";
  ImGui::BeginDisabled(!missing.empty());
  if (command_button(command, snapshot.situation, true)) requests.ask(command);
  ImGui::EndDisabled();
  if (!beside.empty()) {
    ImGui::SameLine(0, px(14));
    ImGui::AlignTextToFramePadding();
    faint_text(beside);
  }
  if (makes_pictures(asked)) {
    const float high = low ? px(240) : ImGui::GetContentRegionAvail().y;
    draw_first(snapshot, views, {std::min(0.36f * ImGui::GetContentRegionAvail().x, high), high});
    ImGui::SameLine(0, gap);
  }
  begin_card("queue", {0, low ? px(240) : 0}, true);
  draw_queue(snapshot, requests);
  end_card();
  if (low) ImGui::EndChild();
}

}  // namespace likeness::ui
