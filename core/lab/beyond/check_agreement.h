// Whether an avatar's own check, which knows no truth, says of views and actions what the truth says.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/lab/beyond/beyond_study.h"

namespace likeness {

// A view or an action. Scores are the figure that is farthest beyond its limit, in that limit: up to 1 it
// holds.
struct CheckedCase {
  std::string name;  // "yaw -15", "jawOpen 0.5"
  bool action = false;
  double truth = 0, check = 0;
  std::string truth_fault, check_fault;  // the figures that are
  bool truth_holds = false, check_holds = false;
};

// The truth's limits: the head's PSNR within 2 dB of its figure inside the filmed range for each 15 degrees,
// a drift of 3, up to 30 degrees a silhouette's IoU of 0.95, 0.02 % of specks beyond those inside; of actions
// the face within 3 dB, a change of the forehead of 1, the same specks. All views but the front, all actions.
std::vector<CheckedCase> checked_cases(const BeyondStudy& study);

struct CheckAgreement {
  int cases = 0, wrong = 0;            // wrong: the check's verdict is not the truth's
  int held = 0, held_found = 0;        // those that hold by the truth, and of them those that the check finds
  int claimed = 0, claimed_wrong = 0;  // those that hold by the check, and of them those that do not
  // Of both scores (Spearman's), over views and over actions; nullopt where either is the same everywhere.
  std::optional<double> rank_views, rank_actions;
};
CheckAgreement check_agreement(const std::vector<CheckedCase>& cases);

}  // namespace likeness
