// Colours, letters and distances. One accent colour; light and dark; everything scales with the letters.
#pragma once

#include <imgui.h>

#include <string>

namespace likeness::ui {

struct Palette {
  ImVec4 ground, panel, raised, line;    // window, side and bars, cards and fields, separators
  ImVec4 text, faint;                    // words, and words that matter less
  ImVec4 accent, accent_hot, on_accent;  // the one next thing to do
  ImVec4 good, warn, bad;
};

struct Fonts {
  ImFont *body = nullptr, *strong = nullptr, *small = nullptr, *heading = nullptr, *title = nullptr;
};

struct Theme {
  bool dark = true;
  float scale = 1;  // of everything, px per unit
  Palette colours;
  Fonts fonts;
};

// The one in use.
const Theme& theme();

// Makes letters and style for this scale. Between frames only. Inter, beside the program or installed, DejaVu
// Sans, or ImGui's own letters; what was shown beyond those (letters.h) from the system's fonts.
void apply_theme(bool dark, float scale);
// Whether letters were shown that the fonts lack: the theme is to be applied again.
bool letters_are_missing();
// The fonts' letters without OpenGL, into the current context's atlas. Returns them.
Fonts make_letters(float scale);

// The file of the letters in use, for those who draw them without ImGui; empty: none.
std::string letter_file();

inline float px(float units) { return units * theme().scale; }
inline ImU32 colour(const ImVec4& c, float alpha = 1) {
  return ImGui::ColorConvertFloat4ToU32({c.x, c.y, c.z, c.w * alpha});
}

}  // namespace likeness::ui
