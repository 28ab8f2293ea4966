// A project's mattes measured against the person as drawn by hand in frames of its clip.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/image/image.h"
#include "core/lab/truth/person_marks.h"
#include "core/project/project.h"

namespace likeness {

// Intersection over union of what is more person than not, in source pixels inside crop and picture, without
// those the drawing is unsure of. Head and torso: of the pixels nearer to that part, so that what hangs on
// beside the head counts there, and a line between head and neck does not.
struct MarkedMatte {
  int frame = 0;
  double person_iou = 0, head_iou = 0, torso_iou = 0;
};
// found: one channel, the crop's square at any size.
MarkedMatte compare_with_marks(const Image8& found, const SquareCrop& crop, const DrawnPerson& drawn);

struct MarkedMattes {
  std::vector<MarkedMatte> frames;
  std::vector<int> without_matte;  // marked, but refused at import or lost
};
// Refused where the marks are of another clip.
Result<MarkedMattes> study_marked_mattes(const Project& project, const PersonMarks& marks,
                                         const Progress& progress, std::stop_token stop);

}  // namespace likeness
