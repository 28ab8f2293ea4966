// Second page of step 3: what was separated from the background, frame by frame, and the brush that corrects
// it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "ui/letters.h"
#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

constexpr int kInkSide = 384;                           // px of the picture of the stroke under the mouse
constexpr float kMinShare = 0.004f, kMaxShare = 0.15f;  // of the picture's side: the brush's radius

ImU32 ink_of(StrokeMark mark, float alpha = 1) {
  const auto ink = stroke_ink(mark);
  return IM_COL32(ink[0], ink[1], ink[2], int(255 * alpha));
}

const CaptureFrame* capture_frame(const Snapshot& snapshot, int frame) {
  const auto& frames = snapshot.project.contents->capture->frames;
  const auto own = std::ranges::lower_bound(frames, frame, {}, &CaptureFrame::frame);
  return own == frames.end() || own->frame != frame ? nullptr : &*own;
}

std::string frame_words(const Snapshot& snapshot, int frame) {
  const CaptureFrame* own = capture_frame(snapshot, frame);
  std::string words = fmt::format("Frame {}, {:.2f} s", frame, own ? own->time_s : 0.0);
  if (snapshot.masks.corrected.contains(frame)) words += ", corrected";
  if (own && own->held_out) words += ", held out";
  return words;
}

void draw_strip(const Snapshot& snapshot, Requests& requests) {
  const MasksView& masks = snapshot.masks;
  const Palette& p = theme().colours;
  std::vector<StripBar> bars;
  for (const int frame : *masks.frames) {
    const bool corrected = masks.corrected.contains(frame);
    const CaptureFrame* own = capture_frame(snapshot, frame);
    bars.push_back({frame, corrected ? 1.0f : 0.4f,
                    corrected ? colour(p.accent) : colour(p.faint, own && own->held_out ? 0.3f : 0.6f)});
  }
  const auto words = [&](std::size_t i) { return frame_words(snapshot, (*masks.frames)[i]); };
  if (const auto clicked = draw_frame_strip("mask strip", bars, masks.frame, px(34), words))
    requests.masks.frame = clicked;
  ImGui::Dummy({0, px(2)});
}

void draw_unreadable(const Snapshot& snapshot, Requests& requests) {
  const MasksView& masks = snapshot.masks;
  if (masks.unreadable.empty()) return;
  const auto& [frame, error] = *masks.unreadable.begin();
  note("unreadable strokes", Tone::bad, error.what, error.fix);
  if (plain_button("Set it aside", !snapshot.situation.running)) requests.masks.set_aside = frame;
  ImGui::Dummy({0, px(6)});
}

// -- The brush.

bool can_paint(const Snapshot& snapshot) {
  const MasksView& masks = snapshot.masks;
  const MaskPicture& picture = snapshot.masks.drawn;
  if (masks.attributes.on && masks.attributes.unreadable) return false;
  return !snapshot.situation.running && masks.look != MaskLook::plate &&
         (masks.attributes.on || !masks.unreadable.contains(masks.frame)) && picture.picture.image &&
         picture.picture.frame == masks.frame;
}

// Uploads what the stroke covers, in its colour.
void refresh_ink(MaskSight& sight) {
  const auto ink = stroke_ink(sight.stroke->mark);
  Image8 coloured(sight.cover.width, sight.cover.height, 4);
  for (std::size_t i = 0; i < sight.cover.data.size(); ++i) {
    std::uint8_t* pixel = coloured.data.data() + 4 * i;
    std::copy(ink.begin(), ink.end(), pixel);
    pixel[3] = std::uint8_t(std::lround(255 * kStrokeShare * sight.cover.data[i]));
  }
  sight.ink.set(coloured);
}

// To hundredths of a pixel: finer than any mouse, and short in the file.
double rounded(double px) { return std::round(100 * px) / 100; }

void add_point(MaskSight& sight, const SquareCrop& crop, ImVec2 at) {
  Stroke& stroke = *sight.stroke;
  const Vec2d point(rounded(crop.x + double(at.x) * crop.side), rounded(crop.y + double(at.y) * crop.side));
  if (!stroke.points.empty() && (stroke.points.back() - point).norm() < 0.15 * stroke.radius) return;
  const double scale = double(kInkSide) / crop.side;
  const Vec2d corner(crop.x, crop.y), before = stroke.points.empty() ? point : stroke.points.back();
  cover_segment(sight.cover, scale * (before - corner), scale * (point - corner), scale * stroke.radius);
  stroke.points.push_back(point);
  refresh_ink(sight);
}

// Follows the mouse over the item drawn last, the picture at `place`.
void paint(const Snapshot& snapshot, MaskSight& sight, const Fitted& place, Requests& requests) {
  const MasksView& masks = snapshot.masks;
  const SquareCrop& crop = snapshot.project.contents->capture->crop;
  const ImGuiIO& io = ImGui::GetIO();
  const ImVec2 at{(io.MousePos.x - place.at.x) / std::max(1.f, place.size.x),
                  (io.MousePos.y - place.at.y) / std::max(1.f, place.size.y)};
  if (ImGui::IsItemHovered() && io.MouseWheel != 0)
    sight.radius_share =
        std::clamp(sight.radius_share * std::pow(1.15f, io.MouseWheel), kMinShare, kMaxShare);
  if (sight.frame != masks.frame || !can_paint(snapshot)) sight.stroke.reset();
  // By the mouse alone: the keyboard points nowhere.
  if (ImGui::IsItemActivated() && ImGui::IsMouseClicked(ImGuiMouseButton_Left) && can_paint(snapshot)) {
    sight.stroke = Stroke{sight.mark, rounded(double(sight.radius_share) * crop.side), {}};
    sight.frame = masks.frame;
    sight.cover = Image(kInkSide, kInkSide, 1);
    sight.until_edit = masks.edit + 1;
  }
  if (!sight.stroke) return;
  if (ImGui::IsItemActive()) add_point(sight, crop, at);
  if (ImGui::IsItemDeactivated()) {
    if (!sight.stroke->points.empty()) requests.masks.stroke = *sight.stroke;
    requests.masks.attributes.value = sight.amount;
    sight.stroke.reset();
  }
}

// The brush's rim about the mouse; dark and light, so that it is seen on any picture.
void draw_brush(const MaskSight& sight, const Fitted& place) {
  const ImVec2 at = ImGui::GetIO().MousePos;
  const float radius = std::max(px(1.5f), sight.radius_share * place.size.x);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddCircle(at, radius + px(1), IM_COL32(0, 0, 0, 160), 0, px(1));
  list.AddCircle(at, radius, ink_of(sight.mark), 0, px(1.5f));
}

void draw_mask_picture(const Snapshot& snapshot, MaskSight& sight, Requests& requests) {
  const FramePicture& picture = snapshot.masks.drawn.picture;
  sight.picture.follow(picture);
  const ImVec2 room = ImGui::GetContentRegionAvail();
  if (sight.picture.texture.empty()) {
    draw_nothing_yet(picture.missing.empty() ? "Reading\u2026" : picture.missing.c_str());
    return;
  }
  const Texture& texture = sight.picture.texture;
  const Fitted place =
      fit_into(ImGui::GetCursorScreenPos(), room, float(texture.width()), float(texture.height()));
  ImGui::SetCursorScreenPos(place.at);
  ImGui::InvisibleButton("mask picture", {std::max(1.f, place.size.x), std::max(1.f, place.size.y)});
  note_view("mask picture");
  const ImVec2 end{place.at.x + place.size.x, place.at.y + place.size.y};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddImage(texture.imgui_id(), place.at, end);
  paint(snapshot, sight, place, requests);
  // The stroke under the mouse, and the last one until it is in the picture; not one that was refused.
  const bool waits = requests.masks.stroke || (snapshot.masks.edit >= sight.until_edit &&
                                               snapshot.masks.drawn.edit < sight.until_edit);
  const bool not_yet_in_picture = sight.frame == snapshot.masks.frame && !sight.ink.empty() &&
                                  (sight.stroke || waits) && snapshot.masks.look != MaskLook::plate;
  if (not_yet_in_picture) list.AddImage(sight.ink.imgui_id(), place.at, end);
  if (ImGui::IsItemHovered() && can_paint(snapshot)) draw_brush(sight, place);
}

// -- Beside the picture.

void draw_looks(const Snapshot& snapshot, Requests& requests) {
  constexpr std::pair<const char*, MaskLook> kLooks[] = {{"Picture", MaskLook::picture},
                                                         {"Matte", MaskLook::matte},
                                                         {"Cut-out", MaskLook::cut_out},
                                                         {"Background plate", MaskLook::plate}};
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted("Show");
  ImGui::PopFont();
  bool first = true;
  for (const auto& [words, look] : kLooks) {
    if (!first) (void)same_line_if_fits(fmt::format("      {}", words).c_str());
    first = false;
    if (choice(words, snapshot.masks.look == look)) requests.masks.look = look;
  }
  constexpr const char* kWords[] = {
      "The background is tinted; the line is where the mask ends.",
      "White is the person, black the background.", "The person as the training sees them.",
      "What is behind the person, from all frames together. Hatched: no frame shows it."};
  faint_text(kWords[std::size_t(snapshot.masks.look)]);
  ImGui::Dummy({0, px(6)});
}

// Whether strokes correct the mask, or say where an attribute is.
void draw_subject(const Snapshot& snapshot, Requests& requests) {
  const bool on = snapshot.masks.attributes.on;
  if (choice("Correct the mask", !on)) requests.masks.attributes.on = false;
  ImGui::SameLine(0, px(18));
  if (choice("Paint an attribute", on)) requests.masks.attributes.on = true;
  ImGui::Dummy({0, px(4)});
}

// How much of the attribute the frame shows.
void draw_amount(const Snapshot& snapshot, MaskSight& sight, Requests& requests) {
  const AttributesView& view = snapshot.masks.attributes;
  const AttributeAnnotation* own = find_annotation(*view.all, view.name, snapshot.masks.frame);
  // While the slider is held it shows where it was moved to, not the frame's old amount.
  float amount = own && !sight.moving_amount ? float(own->value) : sight.amount;
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted("Amount here");
  ImGui::SameLine(0, px(10));
  if (slider("##amount", &amount, {-1, 1, 0, 0, 0}, "%.2f",
             std::min(px(240), ImGui::GetContentRegionAvail().x)) ||
      ImGui::IsItemActivated())
    sight.amount = std::round(100 * amount) / 100;
  sight.moving_amount = ImGui::IsItemActive();
  // Only on release, so that one move is one step of undo.
  if (own && ImGui::IsItemDeactivated() && std::abs(double(sight.amount) - own->value) > 0.005)
    requests.masks.attributes.set = sight.amount;
  if (plain_button("None of it here", !snapshot.situation.running)) requests.masks.attributes.set = 0.f;
  tooltip("This frame shows how the person mostly is: amount 0, nothing needs to be painted on it.");
}

// The attributes, one of them chosen to paint; a name for a new one.
void draw_attributes(const Snapshot& snapshot, MaskSight& sight, Requests& requests) {
  const AttributesView& view = snapshot.masks.attributes;
  if (view.unreadable) note("unreadable attributes", Tone::bad, view.unreadable->what, view.unreadable->fix);
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted("Attributes");
  ImGui::PopFont();
  bool listed = false;
  for (const PaintedAttribute& attribute : *view.all) {
    ImGui::PushID(attribute.name.c_str());
    const bool chosen = attribute.name == view.name;
    listed |= chosen;
    if (choice(attribute.name.c_str(), chosen)) requests.masks.attributes.name = attribute.name;
    std::string frames;
    for (const AttributeAnnotation& one : attribute.annotations)
      frames += fmt::format("{}frame {}: {:.2g}", frames.empty() ? "" : ", ", one.frame, one.value);
    faint_text(frames);
    if (chosen && plain_button(fmt::format("Delete {}", attribute.name).c_str(), !snapshot.situation.running))
      requests.masks.attributes.remove = attribute.name;
    ImGui::PopID();
  }
  if (!listed) faint_text(fmt::format("'{}' is not painted on any frame yet.", view.name));
  ImGui::SetNextItemWidth(std::min(px(180), 0.6f * ImGui::GetContentRegionAvail().x));
  ImGui::InputTextWithHint("##attribute name", "such as: cheek puff", sight.name.data(), sight.name.size());
  (void)for_window(sight.name.data());  // its letters are made
  note_widget("attribute name");
  ImGui::SameLine(0, px(8));
  if (plain_button("New attribute", sight.name[0] != 0)) {
    requests.masks.attributes.name = std::string(sight.name.data());
    sight.name.fill(0);
  }
  ImGui::Dummy({0, px(4)});
  draw_amount(snapshot, sight, requests);
  ImGui::Dummy({0, px(6)});
}

void draw_brushes(const Snapshot& snapshot, MaskSight& sight, Requests& requests) {
  using Marks = std::vector<std::pair<const char*, StrokeMark>>;
  static const Marks kOfMask{{"This is the person", StrokeMark::person},
                             {"This is background", StrokeMark::background},
                             {"Erase strokes", StrokeMark::erase}},
      kOfAttribute{{"It is here", StrokeMark::person}, {"Erase strokes", StrokeMark::erase}};
  const bool attribute = snapshot.masks.attributes.on;
  const Marks& marks = attribute ? kOfAttribute : kOfMask;
  if (attribute && sight.mark == StrokeMark::background) sight.mark = StrokeMark::person;
  ImGui::PushFont(theme().fonts.strong);
  ImGui::TextUnformatted("Brush");
  ImGui::PopFont();
  for (const auto& [words, mark] : marks) {
    if (choice(words, sight.mark == mark)) sight.mark = mark;
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    const ImVec2 centre{high.x + px(14), 0.5f * (low.y + high.y)};
    ImGui::GetWindowDrawList()->AddCircleFilled(centre, px(5), ink_of(mark));
    ImGui::GetWindowDrawList()->AddCircle(centre, px(5), colour(theme().colours.faint), 0, px(1));
  }
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted("Size");
  ImGui::SameLine(0, px(10));
  const float size = float(snapshot.project.contents->capture->size);
  float width_px = 2 * sight.radius_share * size;
  if (slider("##brush size", &width_px, {2 * kMinShare * size, 2 * kMaxShare * size, 0, 0, 0.06f * size},
             "%.0f px", std::min(px(240), ImGui::GetContentRegionAvail().x)))
    sight.radius_share = std::clamp(width_px / (2 * size), kMinShare, kMaxShare);
  if (command_button(Command::undo, snapshot.situation)) requests.ask(Command::undo);
  (void)same_line_if_fits(command_info(Command::redo).words.data());
  if (command_button(Command::redo, snapshot.situation)) requests.ask(Command::redo);
  (void)same_line_if_fits("Clear this frame");
  const AttributesView& view = snapshot.masks.attributes;
  const bool something = attribute ? find_annotation(*view.all, view.name, snapshot.masks.frame) != nullptr
                                   : !snapshot.masks.strokes->empty();
  if (plain_button("Clear this frame", !snapshot.situation.running && something)) requests.masks.clear = true;
  ImGui::Dummy({0, px(6)});
}

void draw_frame_choice(const Snapshot& snapshot, Requests& requests) {
  const int frame = snapshot.masks.frame;
  ImGui::PushFont(theme().fonts.strong);
  body_text(frame_words(snapshot, frame));
  ImGui::PopFont();
  if (command_button(Command::previous_picture, snapshot.situation)) requests.ask(Command::previous_picture);
  (void)same_line_if_fits(command_info(Command::next_picture).words.data());
  if (command_button(Command::next_picture, snapshot.situation)) requests.ask(Command::next_picture);
  ImGui::Dummy({0, px(6)});
}

void draw_attribute_advice(const Snapshot& snapshot, const CaptureFrame* own) {
  if (snapshot.situation.running)
    faint_text("You can paint when the work is done or stopped.");
  else if (!own || !own->used ||
           std::ranges::find(snapshot.project.contents->project.options.train.left_out, own->frame) !=
               snapshot.project.contents->project.options.train.left_out.end())
    faint_text("Nothing is learnt from this frame: paint on one that trains.");
  else
    faint_text(
        "For what no expression carries: paint where it is on a few frames that show it, say how much there "
        "is, and mark some that show none. The next training makes a slider of it.");
  if (snapshot.masks.attributes.unlearnt)
    note("unlearnt attributes", Tone::warn, "The avatar was trained before the last change.",
         "Make the avatar: it is trained again, and nothing else.");
  ImGui::Dummy({0, px(6)});
}

// What a stroke does here, or why none can be painted; after a change, what to do next.
void draw_advice(const Snapshot& snapshot) {
  const int frame = snapshot.masks.frame;
  const CaptureFrame* own = capture_frame(snapshot, frame);
  if (snapshot.masks.attributes.on) return draw_attribute_advice(snapshot, own);
  if (snapshot.situation.running) {
    faint_text("You can paint when the work is done or stopped: it is using the masks.");
  } else if (snapshot.masks.unreadable.contains(frame)) {
    faint_text("This frame's strokes cannot be read: set them aside before painting again.");
  } else if (own && own->held_out) {
    faint_text("Held out: a stroke mends a mask used for measuring; nothing is learnt from it.");
  } else if (!snapshot.masks.unmade) {
    faint_text(
        "Paint over everything that is wrong. What is under the brush is then certain; its edge is found "
        "when the avatar is made again. The wheel changes the brush's size.");
  }
  if (snapshot.masks.unmade)
    note("unmade masks", Tone::warn, "These masks were made before the last change.",
         "Make the avatar: masks and training are made again, and nothing else.");
  ImGui::Dummy({0, px(6)});
}

}  // namespace

void draw_masks(const Snapshot& snapshot, Views& views, Requests& requests) {
  if (!snapshot.project.contents->capture || snapshot.masks.frames->empty()) {
    draw_nothing_yet(
        "Here you will see what is taken for the person and what for the background, as soon as the head is "
        "found in the clip.");
    return;
  }
  const bool low = is_low();
  if (!low) draw_strip(snapshot, requests);
  const ImVec2 area = ImGui::GetContentRegionAvail();
  begin_card("mask", {std::min(area.x * 0.64f, area.y), area.y});
  draw_mask_picture(snapshot, views.masks, requests);
  end_card();
  ImGui::SameLine(0, px(16));
  begin_card("brush", {0, area.y}, true);
  draw_unreadable(snapshot, requests);
  draw_frame_choice(snapshot, requests);
  if (low) draw_strip(snapshot, requests);
  draw_subject(snapshot, requests);
  if (snapshot.masks.attributes.on) draw_attributes(snapshot, views.masks, requests);
  draw_brushes(snapshot, views.masks, requests);
  draw_advice(snapshot);
  draw_looks(snapshot, requests);
  end_card();
}

}  // namespace likeness::ui
