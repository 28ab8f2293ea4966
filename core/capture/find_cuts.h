// Where a film was cut: the frames that begin a shot, and those of a dissolve or fade, which belong to none.
//
// A cut stands out alone: nearly every cell of the picture moves further than it does in the frames before
// and after; or, at a jump cut in place, a good part of head and hair moves far further than it does in the
// tenths of a second around. It is no flash, after which the picture returns; no motion, however quick, which
// takes several frames; no step of the exposure, no shake of the camera (sketch_film.h), no frame that is
// shown twice. In a dissolve every picture is a mixture of the one before and the one after it, in which
// nothing moves between the two.
//
// Where the picture changes its shape there is a cut, too, whatever it shows.
//
// A jump no larger than the motions around it is not told from them.
#pragma once

#include <span>
#include <vector>

#include "core/base/frame_span.h"
#include "core/capture/sketch_film.h"

namespace likeness {

// What the sharp cuts are decided by: how far the picture or the head of frame i moves beyond what they do in
// the frames around. 0: no frame before it. From 1 on it is a cut, unless it is a flash.
double stands_out(std::span<const FrameSketch> film, std::size_t i);

// The shots in order. Frames between two of them belong to a gradual transition. Without sketches none.
std::vector<FrameSpan> find_shots(std::span<const FrameSketch> film);

}  // namespace likeness
