// Where head and torso may be before anything is learnt: each field's cube, and the cells that the head mesh,
// a body shape and the mattes leave possible. Tight volumes avoid floaters and keep samples few.
#pragma once

#include "core/head/pose_head.h"
#include "core/render/avatar.h"
#include "core/train/train.h"

namespace likeness {

// Cells a field may ever occupy, cells that are never culled, and cells that end a ray.
struct Volume {
  FieldCube cube;
  OccupancyGrid allowed;
  OccupancyGrid kept;   // subset of allowed: around the mouth's inside
  OccupancyGrid core;   // deep inside the head; resolution 0 for none
  OccupancyGrid still;  // where no expression moves anything (still_cells.h); resolution 0 for none
};

struct Volumes {
  Volume head;
  std::optional<Volume> torso;
  NeckZone neck;  // between the two; empty without a torso
};

struct VolumeOptions {
  int head_resolution = 96, torso_resolution = 96;  // cells an axis
  float hair_margin = 0.065f;                       // m beyond the scalp
  float skin_margin = 0.020f;                       // m beyond face and neck
  float core_depth = 0.020f;                        // m below the skin where nothing can be seen
  bool carve = true;                                // with the views' mattes
};

// Height (head frame y, m) of the base of the neck: below it the head's field follows the torso, if there is
// one, so that turning the head moves no shoulder; without a torso it is empty there.
float neck_base(const HeadModel& model, const HeadShape& shape);

Volumes make_volumes(const TrainingSet& set, const HeadShape& shape, const VolumeOptions& options = {});

}  // namespace likeness
