// Where the torso is and how it deforms: direct alignment of the picture below the chin to a template that
// the training frames agree on. Nine numbers a frame: turn and shift in the plane, and six coefficients of
// deformation modes learnt from training frames (core/scene/torso_warp.h); with a camera held in a hand a
// tenth, the distance.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/scene/torso_warp.h"
#include "core/track/torso/torso_frame.h"

namespace likeness {

struct TorsoOptions {
  int learning_frames =
      120;             // training frames from which template and modes are learnt; cost grows with them
  bool deform = true;  // false: a rigid torso
  // The torso's distance is found, too. Before a camera at rest a torso hardly comes nearer, and its modes
  // say the little better; a hand that holds the camera moves by decimetres.
  bool approaches = false;
};

struct TorsoTrack {
  bool has_torso = false;
  int reference = -1;                  // index of the frame whose head frame is the torso frame
  std::vector<Pose> world_from_torso;  // one a frame
  TorsoModes modes;                    // from training frames; empty: rigid
  std::vector<TorsoShape> shapes;      // one per frame; zero if there are no modes
  double residual_before = 0,          // mean difference of relief to the template, grey levels: unmoved,
      residual_rigid = 0,              // best rigid motion,
      residual_after = 0;  // with its deformation; each frame by itself, over all that were tracked
};

// chin: of the person, head frame, m. Template, weights and modes come only from training frames; a held-out
// frame's numbers are found from its own picture. Where the camera walks round a person who holds still,
// all frames share the numbers of the training frames whose view is most like the template's.
Result<TorsoTrack> track_torso(const std::vector<TorsoFrame>& frames, const Vec3d& chin,
                               const Progress& progress, std::stop_token stop,
                               const TorsoOptions& options = {});

}  // namespace likeness
