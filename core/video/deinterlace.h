// Interlaced frames: two pictures of different moments, one in the even lines and one in the odd. Internal to
// core/video, as frame_to_rgb.h.
#pragma once

#include <cstddef>

struct AVFrame;

namespace likeness {

bool is_flagged(const AVFrame& frame);  // as interlaced, by the decoder

// How much what moves since `before` differs from the next line, over how much it differs from the line after
// that. A progressive picture's lines are more like their neighbours (0.5 to 0.85 in films, near 1 in noise);
// where two moments are interlaced, lines are like those of their own moment, and it rises above 1 as soon as
// something moves by a pixel from one to the other. 0 where too little moves to tell.
double combing(const AVFrame& before, const AVFrame& now);

// From the largest of several frames, 0: nothing moved. flagged: the file says that it is interlaced, which
// many say that are not: it is believed unless its frames show otherwise.
bool is_interlaced(double largest_combing, bool flagged);

// Leaves the even lines as they are. The odd ones stay where nothing moves since `before`, the frame as it
// was decoded (or null), and are interpolated along edges elsewhere. false: not of this pixel format, or no
// memory.
bool deinterlace(const AVFrame* before, AVFrame& now);

}  // namespace likeness
