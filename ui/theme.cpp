// Fonts and ImGui's style: see theme.h.
#include "ui/theme.h"

#include <backends/imgui_impl_opengl3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/program_files.h"
#include "ui/letter_pictures.h"
#include "ui/letters.h"

namespace likeness::ui {

namespace {

Theme current;

// In order of preference; a path without a leading slash is in the program's own folders.
constexpr std::array kRegular{"share/likeness/fonts/Inter-Regular.otf",
                              "/usr/share/fonts/opentype/inter/Inter-Regular.otf",
                              "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"};
constexpr std::array kStrong{"share/likeness/fonts/Inter-SemiBold.otf",
                             "/usr/share/fonts/opentype/inter/Inter-SemiBold.otf",
                             "/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf"};

// The files that exist.
std::vector<std::string> present(std::span<const char* const> files) {
  std::vector<std::string> found;
  std::error_code unknown;
  for (const std::filesystem::path file : files)
    if (const auto path = file.is_absolute() ? std::optional(file) : bundled_file(file);
        path && std::filesystem::exists(*path, unknown))
      found.push_back(path->string());
  return found;
}

ImVec4 rgb(unsigned value, float alpha = 1) {
  return {float(value >> 16 & 255) / 255, float(value >> 8 & 255) / 255, float(value & 255) / 255, alpha};
}

Palette dark_palette() {
  return {rgb(0x15171c), rgb(0x1c1f26), rgb(0x262a33), rgb(0x343a46), rgb(0xe9ebf0), rgb(0x9aa2b1),
          rgb(0x4c8dff), rgb(0x6aa1ff), rgb(0x0b1222), rgb(0x46c07d), rgb(0xe9a53a), rgb(0xf0625d)};
}

Palette light_palette() {
  return {rgb(0xf6f7f9), rgb(0xffffff), rgb(0xeceff4), rgb(0xd5dae3), rgb(0x1b1f27), rgb(0x5a6373),
          rgb(0x1f66e5), rgb(0x1557cc), rgb(0xffffff), rgb(0x178549), rgb(0xa86505), rgb(0xc9302c)};
}

ImFont* load_font(const std::vector<std::string>& files, float size, const ImWchar* ranges) {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  for (const std::string& file : files)
    if (ImFont* font = atlas.AddFontFromFileTTF(file.c_str(), std::round(size), nullptr, ranges)) return font;
  ImFontConfig config;
  config.SizePixels = std::round(size);
  return atlas.AddFontDefault(&config);
}

// A letter that a font lacks, in the atlas.
struct AddedLetter {
  ImFont* font = nullptr;
  ImWchar number = 0;
  LetterPicture picture;
  int place = 0;  // in the atlas
};

// Those that names are drawn with.
std::array<ImFont*, 4> fonts_of_names(const Fonts& fonts) {
  return {fonts.body, fonts.strong, fonts.small, fonts.heading};
}

bool lacks(ImFont& font, ImWchar number) { return font.FindGlyphNoFallback(number) == nullptr; }

bool any_is_missing() {
  for (ImFont* font : fonts_of_names(current.fonts))
    for (const ImWchar number : letters_shown())
      if (lacks(*font, number)) return true;
  return false;
}

void add_pictures(ImFontAtlas& atlas, const std::vector<AddedLetter>& added) {
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  atlas.GetTexDataAsAlpha8(&pixels, &width, &height);
  for (const AddedLetter& letter : added) {
    const LetterPicture& picture = letter.picture;
    const ImFontAtlasCustomRect& rect = *atlas.GetCustomRectByIndex(letter.place);
    for (int y = 0; y < picture.height; ++y)
      std::copy_n(picture.covers.data() + std::ptrdiff_t(y) * picture.width, picture.width,
                  pixels + std::ptrdiff_t(rect.Y + y) * width + rect.X);
  }
  // They were placed from the line that letters stand on; ImGui counts from the top.
  for (const AddedLetter& letter : added)
    for (ImFontGlyph& glyph : letter.font->Glyphs)
      if (glyph.Codepoint == letter.number) {
        glyph.Y0 += std::round(letter.font->Ascent);
        glyph.Y1 += std::round(letter.font->Ascent);
      }
}

// Once the fonts' own are made.
void add_letters(ImFontAtlas& atlas, const Fonts& fonts) {
  std::vector<AddedLetter> added;
  for (ImFont* font : fonts_of_names(fonts))
    for (const ImWchar number : letters_shown()) {
      if (!lacks(*font, number)) continue;
      AddedLetter letter{font, number, draw_letter(letter_meant(number), font->FontSize)};
      const LetterPicture& picture = letter.picture;
      letter.place =
          atlas.AddCustomRectFontGlyph(font, number, std::max(1, picture.width), std::max(1, picture.height),
                                       picture.advance, {float(picture.left), float(-picture.top)});
      added.push_back(std::move(letter));
    }
  if (added.empty()) return;
  atlas.Build();
  add_pictures(atlas, added);
}

void make_fonts() {
  current.fonts = make_letters(current.scale);
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
}

void set_colours(ImGuiStyle& style) {
  const Palette& p = current.colours;
  const auto set = [&](ImGuiCol slot, const ImVec4& c) { style.Colors[slot] = c; };
  const auto faded = [](ImVec4 c, float alpha) {
    c.w = alpha;
    return c;
  };
  set(ImGuiCol_Text, p.text);
  set(ImGuiCol_TextDisabled, p.faint);
  set(ImGuiCol_WindowBg, p.ground);
  set(ImGuiCol_ChildBg, faded(p.ground, 0));
  set(ImGuiCol_PopupBg, p.panel);
  set(ImGuiCol_Border, p.line);
  set(ImGuiCol_FrameBg, p.raised);
  set(ImGuiCol_FrameBgHovered, p.line);
  set(ImGuiCol_FrameBgActive, p.line);
  set(ImGuiCol_TitleBg, p.panel);
  set(ImGuiCol_TitleBgActive, p.panel);
  set(ImGuiCol_MenuBarBg, p.panel);
  set(ImGuiCol_ScrollbarBg, faded(p.ground, 0));
  set(ImGuiCol_ScrollbarGrab, p.line);
  set(ImGuiCol_ScrollbarGrabHovered, p.faint);
  set(ImGuiCol_ScrollbarGrabActive, p.faint);
  set(ImGuiCol_CheckMark, p.accent);
  set(ImGuiCol_SliderGrab, p.accent);
  set(ImGuiCol_SliderGrabActive, p.accent_hot);
  set(ImGuiCol_Button, p.raised);
  set(ImGuiCol_ButtonHovered, p.line);
  set(ImGuiCol_ButtonActive, p.line);
  set(ImGuiCol_Header, p.raised);
  set(ImGuiCol_HeaderHovered, p.line);
  set(ImGuiCol_HeaderActive, p.line);
  set(ImGuiCol_Separator, p.line);
  set(ImGuiCol_PlotHistogram, p.accent);
  set(ImGuiCol_TextSelectedBg, faded(p.accent, 0.35f));
  set(ImGuiCol_NavHighlight, p.accent);
  set(ImGuiCol_ModalWindowDimBg, {0, 0, 0, 0.5f});
}

}  // namespace

const Theme& theme() { return current; }

Fonts make_letters(float s) {
  // kNames: with the letters of more alphabets, for file names.
  static const ImWchar kNames[] = {0x20, 0x17f, 0x370, 0x52f, 0x2010, 0x2026, 0x2190, 0x2193, 0};
  static const ImWchar kWords[] = {0x20, 0xff, 0x2010, 0x2026, 0x2190, 0x2193, 0};
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.Clear();
  const std::vector<std::string> regular = present(kRegular), strong = present(kStrong);
  Fonts fonts;
  fonts.body = load_font(regular, 16 * s, kNames);
  fonts.strong = load_font(strong, 16 * s, kNames);
  fonts.small = load_font(regular, 14 * s, kWords);
  fonts.heading = load_font(strong, 22 * s, kWords);
  fonts.title = load_font(strong, 34 * s, kWords);
  atlas.Build();
  add_letters(atlas, fonts);
  return fonts;
}

bool letters_are_missing() { return take_new_letters() && current.fonts.body && any_is_missing(); }

std::string letter_file() {
  const std::vector<std::string> files = present(kRegular);
  return files.empty() ? "" : files.front();
}

void apply_theme(bool dark, float scale) {
  const bool letters =
      !current.fonts.body || scale != current.scale || !ImGui::GetIO().Fonts->IsBuilt() || any_is_missing();
  current.dark = dark;
  current.scale = scale;
  current.colours = dark ? dark_palette() : light_palette();
  ImGuiStyle style;
  style.WindowPadding = {16, 14};
  style.FramePadding = {12, 7};
  style.ItemSpacing = {10, 9};
  style.ItemInnerSpacing = {8, 6};
  style.CellPadding = {8, 6};
  style.IndentSpacing = 18;
  style.ScrollbarSize = 12;
  style.GrabMinSize = 14;
  style.WindowRounding = 10;
  style.ChildRounding = 8;
  style.FrameRounding = 6;
  style.PopupRounding = 8;
  style.ScrollbarRounding = 6;
  style.GrabRounding = 6;
  style.WindowBorderSize = 0;
  style.ChildBorderSize = 1;
  style.PopupBorderSize = 1;
  style.ScaleAllSizes(scale);
  set_colours(style);
  ImGui::GetStyle() = style;
  if (letters) make_fonts();
}

}  // namespace likeness::ui
