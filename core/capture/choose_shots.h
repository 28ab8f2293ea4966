// Which shots of a film serve: those of the place from which the person is seen longest - between jump cuts
// in place, and on both sides of what was put between them, the background is the same picture. They share
// camera, plate and everything; the others would have to be clips of their own.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/base/frame_span.h"
#include "core/capture/capture.h"
#include "core/capture/scan_clip.h"
#include "core/capture/sketch_film.h"

namespace likeness {

// Each shot with its verdict, in order; samples: of the faces, source px of a picture of width x height.
// Where no shot shows a face for long enough, all serve: what is wrong then is no cut.
std::vector<ClipShot> choose_shots(std::span<const FrameSketch> film, const std::vector<FaceSample>& samples,
                                   const std::vector<FrameSpan>& shots, int width, int height);

// find_shots and choose_shots of a scanned clip; photographs, each taken by itself, are one shot. film: what
// was looked at, source px; empty: the whole picture.
std::vector<ClipShot> shots_of(const ClipScan& scan, const PixelRect& film, bool photographs);

// Every shot of a scanned clip, whoever and whatever it shows, for a track that follows each by itself; empty
// where it was not cut.
std::vector<FrameSpan> every_shot(const ClipScan& scan);

// "0:00-0:12 and 0:15-0:40"
std::string serving_words(const std::vector<ClipShot>& shots);
// One sentence on what of the film counts; empty where all of it does.
std::string counted_words(const std::vector<ClipShot>& shots);
// "0:12-0:15"
std::string span_words(double from_s, double to_s);

}  // namespace likeness
