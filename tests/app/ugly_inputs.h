// Odd films and folders of photographs, each a line of shell that makes it of one good film, with what
// importing it has to come to.
#pragma once

#include <span>
#include <string_view>

namespace likeness::test {

struct UglyInput {
  std::string_view file;    // its name in the folder where the recipe runs; unique
  std::string_view recipe;  // a shell script; $CLIP: the good film, see kGoodFrames; `ff` is ffmpeg, silent;
                            // `turn DEGREES FROM TO` says in the file how the phone was held
  // What comes of it: so many frames, the last of them at this time of the file in seconds (below zero:
  // whatever time), and, where something has to be said, these words of it. No frames: it is refused in these
  // words.
  int frames = 0;
  double last_s = -1;
  std::string_view says = "";
  bool by_default = false;  // tried each time; the others only with all tests
};

// The good film: 160 px, 25 frames a second, H.264, a sine as AAC.
inline constexpr int kGoodFrames = 40;

std::span<const UglyInput> ugly_inputs();

}  // namespace likeness::test
