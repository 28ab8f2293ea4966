// What a person before the camera does, one thing after the other: said while a clip is recorded, drawn in
// the film guide. It asks for what the capture check looks for.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace likeness::ui {

// What a small drawing shows (film_drawings.h).
enum class FilmDrawing {
  light,
  framing,
  camera_rests,
  camera_walks,
  look_ahead,
  turn_left,
  turn_right,
  raise_chin,
  lower_chin,
  smile,
  open_mouth,
  purse_lips,
  raise_brows,
  close_eyes,
  speak
};

// Left and right are the filmed person's own.
struct FilmCue {
  double seconds = 0;      // that it takes
  std::string_view words;  // as said
  FilmDrawing drawing{};
};
std::span<const FilmCue> film_script();
double film_script_s();  // of all cues together: about a minute

// Where in the script somebody is who has been filmed for so long.
struct ScriptPlace {
  std::size_t cue = 0;  // the number of cues: all are done
  double left_s = 0;    // of this cue
};
ScriptPlace script_place(double filmed_s);

}  // namespace likeness::ui
