// Claims about letters of the window: whatever a name is written in, two that differ look different.
#include "ui/letters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "ui/letter_pictures.h"
#include "ui/platform/letter_files.h"
#include "ui/theme.h"

namespace likeness::ui {
namespace {

const std::string kFamily = "\U0001f468\u200d\U0001f469\u200d\U0001f467";

TEST(Letters, OfAnyNameComeBackAndMayBeShownAgain) {
  for (const std::string& name :
       {std::string("clip.mp4"), std::string("m\u00fcller \u5c71\u7530"), "\U0001f600 " + kFamily,
        std::string("m\xfcller"), std::string("cut \xe5\xb1"), std::string("\xed\xa0\x80\xf8\xff"),
        std::string("\uf123"), std::string("tab\tand\nline")}) {
    const std::string once = for_window(name);
    EXPECT_EQ(from_window(once), name);
    EXPECT_EQ(for_window(once), once);
    for (std::size_t i = 0; i < once.size(); ++i)  // nothing beyond 16 bits
      EXPECT_LT(static_cast<unsigned char>(once[i]), 0xf0) << name;
  }
  EXPECT_NE(for_window("\U0001f600"), for_window("\U0001f601"));
  EXPECT_NE(for_window("m\xfcller"), for_window("m\xe4ller"));
}

TEST(Letters, WithoutAnyFontAreTheirNumbers) {
  std::map<std::vector<std::uint8_t>, std::uint32_t> seen;
  for (const std::uint32_t letter :
       {0x5c71u, 0x7530u, 0x5c72u, 0x1f600u, 0x1f601u, kByte + 0xfc, kByte + 0xe4})
    for (const float size : {14.f, 16.f, 33.f}) {
      const LetterPicture picture = draw_letter_number(letter, size);
      ASSERT_EQ(picture.covers.size(), std::size_t(picture.width * picture.height));
      EXPECT_GT(picture.advance, float(picture.width));
      if (size == 16) {
        EXPECT_LE(picture.height, 16);
        EXPECT_TRUE(seen.emplace(picture.covers, letter).second) << std::hex << letter;
      }
    }
}

// An atlas without a window.
class LetterPictures : public testing::Test {
 protected:
  void SetUp() override { ImGui::CreateContext(); }
  void TearDown() override { ImGui::DestroyContext(); }

  // What stands on the screen for it.
  static std::vector<int> drawn(const std::string& name, ImFont& font) {
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    ImGui::GetIO().Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
    std::vector<int> picture;
    const std::string text = for_window(name);
    for (const char* at = text.c_str(); *at != 0;) {
      unsigned c = static_cast<unsigned char>(*at++);
      if (c >= 0xe0) {
        c = (c & 15) << 12 | (at[0] & 63) << 6 | (at[1] & 63), at += 2;
      } else if (c >= 0xc0) {
        c = (c & 31) << 6 | (at[0] & 63), at += 1;
      }
      const ImFontGlyph& glyph = *font.FindGlyph(ImWchar(c));
      const auto px = [](float share, int of) { return int(std::lround(share * float(of))); };
      picture.push_back(int(std::lround(glyph.AdvanceX * 4)));
      for (int y = px(glyph.V0, height); y < px(glyph.V1, height); ++y)
        for (int x = px(glyph.U0, width); x < px(glyph.U1, width); ++x)
          picture.push_back(pixels[y * width + x]);
    }
    return picture;
  }
};

struct Script {
  const char* what;
  char32_t letter;  // one of it
  std::string one, other;
};

const std::vector<Script>& scripts() {
  static const std::vector<Script> all{
      {"Chinese", U'\u738b', "\u738b\u5c0f\u660e", "\u738b\u5c0f\u7ea2"},
      {"Japanese", U'\u3042', "\u3042\u3044\u3046", "\u3042\u3044\u3048"},
      {"Korean", U'\uae40', "\uae40\ubbfc\uc218", "\uae40\ubbfc\uc9c0"},
      {"Arabic", U'\u0645', "\u0645\u062d\u0645\u062f", "\u0645\u062d\u0645\u0648"},
      {"Hebrew", U'\u05d3', "\u05d3\u05d5\u05d3", "\u05d3\u05d5\u05e8"},
      {"Thai", U'\u0e2a', "\u0e2a\u0e21\u0e0a\u0e32\u0e22", "\u0e2a\u0e21\u0e0a\u0e31\u0e22"},
      {"emoji", U'\U0001f600', "\U0001f600", "\U0001f923"},
      {"no UTF-8", 0, "m\xfcller", "m\xe4ller"}};
  return all;
}

TEST_F(LetterPictures, TwoNamesThatDifferLookDifferent) {
  for (const Script& script : scripts()) (void)for_window(script.one), (void)for_window(script.other);
  const Fonts fonts = make_letters(1);
  for (ImFont* font : {fonts.body, fonts.strong, fonts.small, fonts.heading}) {
    std::map<std::vector<int>, std::string> seen;
    const std::vector<int> unknown = drawn("?", *font);
    for (const Script& script : scripts())
      for (const std::string& name : {script.one, script.other}) {
        const std::vector<int> picture = drawn(name, *font);
        EXPECT_NE(picture, unknown) << script.what;
        EXPECT_GT(*std::ranges::max_element(picture), 100) << script.what << ": nothing is seen";
        EXPECT_TRUE(seen.emplace(picture, name).second) << script.what << ": as " << seen[picture];
      }
  }
}

// And what the font has itself is the same when letters are added.
TEST_F(LetterPictures, StandOnTheLineOfTheOthers) {
  (void)for_window("\u5c71\U0001f600\u0e2a\u05d3");
  const Fonts fonts = make_letters(2);
  const ImFontGlyph& own = *fonts.body->FindGlyph('H');
  for (const ImWchar number : letters_shown()) {
    const ImFontGlyph* glyph = fonts.body->FindGlyphNoFallback(number);
    ASSERT_NE(glyph, nullptr);
    if (glyph->X1 - glyph->X0 < 2) continue;  // joiners
    EXPECT_GT(glyph->Y1, own.Y0) << std::hex << number;
    EXPECT_LT(glyph->Y0, own.Y1) << std::hex << number;
    EXPECT_LE(glyph->Y1 - glyph->Y0, 2.2f * fonts.body->FontSize) << std::hex << number;
  }
  const std::vector<int> before = drawn("Head", *fonts.body);
  EXPECT_EQ(drawn("Head", *make_letters(2).body), before);
}

// By whatever fonts there are; without one for a script its numbers stand for it, as above.
TEST_F(LetterPictures, AreOfTheSystemsFontsWhereThoseHaveThem) {
  std::string missing;
  for (const Script& script : scripts()) {
    if (script.letter == 0) continue;
    if (!file_of_letter(script.letter)) {
      missing += std::string(missing.empty() ? "" : ", ") + script.what;
      continue;
    }
    EXPECT_NE(draw_letter(script.letter, 16).covers, draw_letter_number(script.letter, 16).covers)
        << script.what;
  }
  EXPECT_FALSE(file_of_letter(U'\U0010fffd'));
  if (!missing.empty()) GTEST_SKIP() << "no font of this system has letters of: " << missing;
}

}  // namespace
}  // namespace likeness::ui
