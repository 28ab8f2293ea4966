// Any text in the window's letters. Dear ImGui has the letters that were made before a frame, and counts them
// by 16 bits: others, as emoji, and bytes of names that are no UTF-8 have a number of their own in the range
// for private use. What a frame wanted and did not have is made before the next (theme.h).
#pragma once

#include <imgui.h>

#include <cstdint>
#include <set>
#include <string>
#include <string_view>

namespace likeness::ui {

// The same text with such numbers, for ImGui; again the same where it has them already. Notes the letters.
std::string for_window(std::string_view text);
// The text of which that was made, for fields that are typed into.
std::string from_window(std::string_view text);

// What was shown so far, beyond ASCII.
const std::set<ImWchar>& letters_shown();
// Whether there were new ones since the last call.
bool take_new_letters();

// The letter of such a number: a code point, or kByte + a byte that is none; others are themselves.
inline constexpr std::uint32_t kByte = 0x110000;
std::uint32_t letter_meant(ImWchar shown);

}  // namespace likeness::ui
