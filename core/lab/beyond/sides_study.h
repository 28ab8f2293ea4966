// How an avatar looks from sides that it was not trained on, beside the clip itself: a project that was built
// with Split::sides, whose held-out frames see the head from near its typical side and from far off it.
#pragma once

#include <filesystem>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/capture/split.h"
#include "core/lab/beyond/beyond_study.h"
#include "core/project/project.h"
#include "core/render/backend.h"

namespace likeness {

// Means over frames; NaN where there is none.
struct SidesScore {
  int frames = 0;
  BeyondScore score;  // of PSNR alone
  double drift = 0;   // of the face's mean colour off the truth, less that inside: largest channel, levels
  double iou = 0;     // of the avatar's silhouette with the person's
  double specks = 0;  // share of the head's pixels, see speck_share
};

// Frames that see the head from one range of angles, degrees off its typical side.
enum class SidesAngle { off, yaw, pitch };  // off: in whatever direction
struct SidesRow {
  SidesAngle angle = SidesAngle::off;
  double from_deg = 0, to_deg = 0;
  double yaw_deg = 0, pitch_deg = 0;  // means of the frames'
  SidesScore score;
};

struct SidesStudy {
  SideRange sides;
  int frames = 0, trained = 0, apart = 0;  // of the clip; apart: neither trained nor scored
  int inside = 0, beyond = 0, lost = 0;    // held out; lost: of them, those without a track
  SidesScore within;                       // inside, in the sense of the split
  std::vector<SidesRow> off, views;        // beyond, each ascending; views: by yaw, then by pitch
  std::uint64_t steps = 0;
  double train_seconds = 0;
};

// The ranges of 10 degrees in which held-out frames lie: of those beyond by the angle off the typical side,
// and by yaw, or by pitch of those that are turned farther up or down than aside.
std::vector<SidesRow> sides_rows(std::span<const CaptureFrame> frames, const SideRange& sides,
                                 bool by_direction);
bool is_in_row(const SidesRow& row, const CaptureFrame& frame, const SideRange& sides);

// folder: gets the contact sheet sides.png (truth above the avatar; some frames inside, then some of each
// range of yaw and pitch). An Error of a project with another split, and where nothing was trained.
Result<SidesStudy> study_sides(const Project& project, const std::filesystem::path& folder,
                               const RenderPlace& place, const Progress& progress, std::stop_token stop);

}  // namespace likeness
