// What the matte stage says of its mattes and plate.
#pragma once

#include <string>
#include <vector>

#include "core/matte/matte_report.h"

namespace likeness {

struct MatteResult {
  bool has_plate = false;         // static camera: the background behind the person
  double plate_coverage = 0;      // share of the plate's pixels seen unoccluded in some training frame
  std::vector<int> plate_frames;  // frames whose background the plate shows: all of a static camera, the
                                  // longest rest of a camera that moves and then rests; ascending
  MatteReport report;             // also written as matte_report.json
  std::vector<std::string> warnings;
};

}  // namespace likeness
