// What cameras_truth.json says of a demo beside its cameras: which kind of camera filmed it, and its shots.
//
//   "demo_camera": "handheld",
//   "demo_shots": [{"first": 0, "last": 61, "cut": "opening", "place": 0, "camera": 0}, ...]
//
// Shots of one place show the same background; those of one camera also from the same place through the same
// lens, apart from what a hand, a zoom or a sliding crop makes of it. Absent of a guided film, and of one
// without cuts.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/synth/demo_options.h"
#include "core/synth/demo_shots.h"

namespace likeness {

// Adds it to a cameras_truth.json that has been written (core/camera/camera.h). A guided film without cuts
// stays as it is.
Result<void> add_demo_truth(const std::filesystem::path& cameras_truth, const DemoOptions& options,
                            const std::vector<DemoShot>& shots);

struct TrueShot {
  int first = 0, last = 0;  // frames
  std::string cut = "opening";
  int place = 0, camera = 0;
};
struct DemoTruth {
  DemoCamera camera = DemoCamera::guided;
  std::vector<TrueShot> shots;  // empty: no cuts
};
Result<DemoTruth> read_demo_truth(const std::filesystem::path& cameras_truth);

}  // namespace likeness
