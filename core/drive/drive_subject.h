// The two sides of driving: who performs, and whose avatar it is carried over to.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/head/action_amounts.h"
#include "core/head/head_model.h"
#include "core/scene/track.h"

namespace likeness {

struct Avatar;  // core/render/avatar.h

// One side of the transfer.
struct DriveSubject {
  const HeadModel* model = nullptr;
  PersonShape person;
  Articulation neutral;
  std::vector<SeenAction> seen;
  Pose world_from_head = Pose::Identity();   // typical
  Pose world_from_torso = Pose::Identity();  // typical; the driver's is not used
};

// The driver as a subject: typical pose (medoid of the good frames) and seen ranges (2nd to 98th percentile)
// of the track.
Result<DriveSubject> subject_from_track(const Track& track, const HeadModel& model);

// The avatar as the driven side. model: the one the avatar was made with; must outlive the subject.
DriveSubject avatar_subject(const Avatar& avatar, const HeadModel& model);

// The range of an action by its name; null where it was not seen.
const SeenAction* find_seen(const std::vector<SeenAction>& seen, const std::string& name);

}  // namespace likeness
