// Small drawings of how to film, in the theme's colours: no picture files.
#pragma once

#include <imgui.h>

#include "ui/studio/film_script.h"

namespace likeness::ui {

// Inside the square of this side. Left and right as in a mirror: the person's left is on the left.
void draw_film_drawing(ImDrawList& list, ImVec2 at, float side, FilmDrawing drawing);

// Where a head and shoulders belong in a picture: drawn over it.
void draw_framing(ImDrawList& list, ImVec2 at, ImVec2 size);

}  // namespace likeness::ui
