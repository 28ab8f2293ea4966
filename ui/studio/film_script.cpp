// See film_script.h.
#include "ui/studio/film_script.h"

#include <numeric>

namespace likeness::ui {

namespace {

// A clip's last tenth is held out, so the script ends with a bit of everything.
constexpr FilmCue kScript[] = {
    {4, "Look into the camera, relaxed.", FilmDrawing::look_ahead},
    {6, "Turn the head slowly to the left, and back.", FilmDrawing::turn_left},
    {6, "Turn it slowly to the right, and back.", FilmDrawing::turn_right},
    {5, "Raise the chin slowly, and back.", FilmDrawing::raise_chin},
    {5, "Lower the chin slowly, and back.", FilmDrawing::lower_chin},
    {5, "Smile, with and without teeth.", FilmDrawing::smile},
    {4, "Open the mouth wide.", FilmDrawing::open_mouth},
    {4, "Purse the lips.", FilmDrawing::purse_lips},
    {4, "Raise the brows, then frown.", FilmDrawing::raise_brows},
    {4, "Close the eyes, then blink.", FilmDrawing::close_eyes},
    {13, "Speak: talk about your day, and move the head as you do.", FilmDrawing::speak},
};

}  // namespace

std::span<const FilmCue> film_script() { return kScript; }

double film_script_s() {
  return std::accumulate(std::begin(kScript), std::end(kScript), 0.0,
                         [](double sum, const FilmCue& cue) { return sum + cue.seconds; });
}

ScriptPlace script_place(double filmed_s) {
  ScriptPlace place;
  double end_s = 0;
  for (const FilmCue& cue : kScript) {
    end_s += cue.seconds;
    if (filmed_s < end_s) return {place.cue, end_s - filmed_s};
    ++place.cue;
  }
  return place;
}

}  // namespace likeness::ui
