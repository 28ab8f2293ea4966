// How far from what was filmed an avatar goes before its own pictures show that it fails, without any truth:
// it is rendered small from steps outwards, and with each action, and the pictures are compared with the
// posed head and with the same avatar where it was filmed.
//
// What is compared, and its limits: hold_rules.h. About forty pictures; seconds on two cores.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/holds/asked.h"
#include "core/holds/hold_rules.h"
#include "core/render/avatar.h"
#include "core/render/backend.h"

namespace likeness {

struct HoldOptions {
  int side_px = 192;  // of the pictures, at most; finer ones cost by their pixels and see finer specks
};

struct HoldView {
  double yaw_deg = 0, pitch_deg = 0;  // of the camera as seen from the head
  HoldFigures figures;
};
struct TriedAction {
  AskedAction asked;
  HoldFigures figures;
};

struct HoldCheck {
  HoldingRange range;
  double typical_yaw_deg = 0, typical_pitch_deg = 0;  // from where it is compared
  std::vector<HoldView> views;       // at least those of asked_views() beside the typical one
  std::vector<TriedAction> actions;  // asked_actions() that the model knows
  double seconds = 0;
};

// model: the one the avatar was made with. Errors: a stop, a device that fails.
Result<HoldCheck> check_holds(const Avatar& avatar, const HeadModel& model, const RenderPlace& place,
                              const HoldOptions& options, const Progress& progress, std::stop_token stop);

}  // namespace likeness
