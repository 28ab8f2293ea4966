// Small drawn things that every panel shares. Each widget a test may want to click is noted by name.
#pragma once

#include <map>
#include <optional>
#include <string>

#include <imgui.h>

#include "core/base/result.h"
#include "ui/studio/commands.h"

namespace likeness::ui {

// Where the widgets of the last frame are, px of the window, by name.
struct Rectangle {
  ImVec2 low, high;
};
const std::map<std::string, Rectangle>& noted_widgets();
void forget_widgets();                      // at the start of a frame
void note_widget(const std::string& name);  // the item drawn last; Tab stops at it
void note_view(const std::string& name);    // the same of one that only the mouse can use
void note_place(const std::string& name, ImVec2 low, ImVec2 high);

enum class StepMark { number, running, done, attention, failed };
// A disc of this diameter with a number, a tick, a turning arc or an exclamation mark.
void draw_mark(ImDrawList& list, ImVec2 centre, float diameter, StepMark mark, int number);

void heading(const char* words);
void faint_text(const std::string& words);  // wrapped
void body_text(const std::string& words);   // wrapped
// A button in the accent colour: the one next thing to do.
bool primary_button(const char* words, bool enabled = true, float width = 0);
bool plain_button(const char* words, bool enabled = true, float width = 0);
// A button of the command table; its shortcut is its tooltip. True where it was pressed.
bool command_button(Command command, const Situation& situation, bool primary = false, float width = 0);

// Goes on in the same line if a button of these words still fits there; otherwise false.
bool same_line_if_fits(const char* words);
// A row of radio buttons, hardly higher than their words, after its label; width: of the label.
void choice_label(const char* words, float width);
bool choice(const char* words, bool chosen);
bool tick_box(const char* words, bool* on);  // as slim

// A slim slider with its value beside it, `width` together. seen: the range the clip showed, marked under it;
// equal: none. Double click: `rest`.
struct SliderRange {
  float low = 0, high = 1, seen_low = 0, seen_high = 0, rest = 0;
};
bool slider(const char* id, float* value, const SliderRange& range, const char* format, float width);

// A thin bar; fraction < 0: no end is known.
void progress_bar(float fraction, float height = 6);
// "about 4 min left"; empty where nothing is known (negative).
std::string time_left(double seconds);
std::string duration(double seconds);  // "1 min 05 s"

// A rounded card; end with end_card().
bool begin_card(const char* id, ImVec2 size = {0, 0}, bool scrolls = false);
void end_card();

// A note in a coloured band: what happened, and what to do.
enum class Tone { plain, good, warn, bad };
void note(const char* id, Tone tone, const std::string& what, const std::string& fix = {});

// Cut to a width with an ellipsis, in the letters of the moment, for ImGui (letters.h).
std::string shortened(const std::string& words, float width);
// The same drawn; the whole is its tooltip.
void clipped_text(const std::string& words, float width);
void tooltip(const std::string& words);  // of the item drawn last

// A line in the strong letters of headings.
void strong_text(const char* words);

}  // namespace likeness::ui
