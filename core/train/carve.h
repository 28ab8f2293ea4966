// Space carving with mattes: a cell that most views see outside the person is empty.
#pragma once

#include <functional>
#include <span>

#include "core/render/avatar.h"
#include "core/train/train.h"

namespace likeness {

struct CarveView {
  Intrinsics intrinsics;
  Pose cam_from_field;
  Image8 person;  // one channel, > 0 where the dilated matte is person
};

// At most `count` evenly chosen views that have a matte; torso chooses the frame. Mattes are dilated by 1/64
// of the picture, so that wisps of hair and errors of the track survive.
std::vector<CarveView> carve_views(const TrainingSet& set, bool torso, int count);

// Clears the cells whose centre lies in the person in less than needed(cell) of the views that see it (0..1),
// and those that no view sees. Without views nothing is cleared. class_of: one byte a cell, index into
// `needed`.
void carve(OccupancyGrid& grid, const FieldCube& cube, std::span<const CarveView> views,
           std::span<const std::uint8_t> class_of, std::span<const float> needed);

}  // namespace likeness
