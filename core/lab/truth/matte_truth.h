// A project's mattes measured against the true ones of the demo it was made from.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/image/image.h"
#include "core/project/project.h"

namespace likeness {

// Alpha, one channel; both of one size.
struct MatteErrors {
  double iou = 0;     // of the halves that are more person than not
  double border = 0;  // mean difference of alpha, 0..1, along the true border: pixels that are mixed, and two
                      // more to either side
  double hair = 0;    // the same of the border above `hair_above`; 0 where there is none
};
// hair_above: px, the height of the ears; the border above it is hair.
MatteErrors compare_mattes(const Image8& found, const Image8& truth, double hair_above);

struct MatteRow {
  std::string network;  // what they were made with: "as it is" (the project's own), "person", "none"
  std::string part;     // "camera moves", "camera rests", "held out"
  int frames = 0;
  double iou_mean = 0, iou_worst = 1;
  int worst_frame = -1;
  double border = 0, hair = 0;  // means
};
// demo: the folder that `likeness demo` wrote and whose clip the project imported.
Result<std::vector<MatteRow>> study_mattes(const Project& project, const std::filesystem::path& demo,
                                           const Progress& progress, std::stop_token stop);

// The same of mattes that are made again in `folder` from the project's track, without a matting network:
// with the person network that the project chose ("person"; missing_dependency where there is none) or
// without
// ("none"). Takes as long as the matte stage.
Result<std::vector<MatteRow>> study_mattes_again(const Project& project, const std::filesystem::path& demo,
                                                 const std::string& network,
                                                 const std::filesystem::path& folder,
                                                 const Progress& progress, std::stop_token stop);

}  // namespace likeness
