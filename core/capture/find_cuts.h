// Where a film was cut: the frames that begin a shot, and those of a dissolve or fade, which belong to none.
//
// A cut stands out alone: nearly every cell of the picture, or of head and hair, moves further than it does
// in the frames before and after - a jump cut in place shows in the head only. It is no flash, after which
// the picture returns; no motion, however quick, which takes several frames; no step of the exposure, no
// shake of the camera (sketch_film.h). In a dissolve every picture is a mixture of the one before and the one
// after it, in which nothing moves between the two.
//
// A jump in the midst of motions as large is not told from them.
#pragma once

#include <span>
#include <vector>

#include "core/capture/sketch_film.h"
#include "core/video/frame_span.h"

namespace likeness {

// What the sharp cuts are decided by: how far the cells of frame i moved, as a share of what they move in the
// frames around, on the (geometric) mean; or how much of the head moved clearly further, where the wall
// beside it rests. 0: no frame before it. From 1 on it stands out.
double stands_out(std::span<const FrameSketch> film, std::size_t i);

// The shots in order. Frames between two of them belong to a gradual transition. Without sketches none.
std::vector<FrameSpan> find_shots(std::span<const FrameSketch> film);

}  // namespace likeness
