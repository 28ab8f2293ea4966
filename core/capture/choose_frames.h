// Which frames train, and why the others do not.
#pragma once

#include <vector>

#include "core/capture/capture.h"
#include "core/capture/scan_clip.h"

namespace likeness {

// Refuses training frames that repeat the one before them and those without a face in a sample near them,
// then those much blurrier than their neighbours, then thins the rest down to max_frames; marks what remains
// as used. Held-out frames and those kept apart are left alone, and decide nothing. change: of the face since
// the previous frame, one per frame; empty if not known. Thinning uses it: a face that turns or speaks keeps
// more of its frames than one at rest, whose frames are nearly the same, and among interchangeable frames the
// sharpest stays. repeats: repeated_frames.h, one per frame; empty: none does.
void choose_training_frames(std::vector<CaptureFrame>& frames, const std::vector<FaceSample>& samples,
                            const std::vector<float>& change, const std::vector<char>& repeats,
                            const ImportOptions& options);

}  // namespace likeness
