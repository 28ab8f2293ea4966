// Space carving with mattes: a cell that most views see outside the person is empty.
#pragma once

#include <span>

#include "core/head/pose_head.h"
#include "core/render/avatar.h"
#include "core/scene/torso_warp.h"
#include "core/train/train.h"

namespace likeness {

struct CarveView {
  Intrinsics intrinsics;
  Pose cam_from_field;
  // Where the view shows a place of a torso's field: displaced by this, posed minus canonical at the grid's
  // nodes, (rows, columns, 2), m; no nodes = unmoved.
  TorsoGrid grid;
  std::vector<float> displacement;
  Image8 person;       // one channel, > 0 where the dilated matte is person
  Image8 head;         // one channel, > 0 where the dilated head mesh is; empty = not known
  PixelRect inside{};  // what was filmed of them; empty: all. The view does not vote beyond it
};

// Condition under which the cells of a class are kept.
struct CarveRule {
  float needed = 0;  // share of the views that must see the cell inside the person, 0..1
  // Views in which the head covers the cell do not vote: there the matte says person in any case.
  bool beside_head_only = false;
};

// At most `count` evenly chosen views of the head's frame that have a matte. Mattes are dilated by 1/64 of
// the picture, so that wisps of hair and errors of the track survive.
std::vector<CarveView> head_carve_views(const TrainingSet& set, int count);
// The same for the torso's frame, with the head mesh above the height `bottom` (m, of the neutral head) in
// `head`.
std::vector<CarveView> torso_carve_views(const TrainingSet& set, const HeadShape& shape, float bottom,
                                         int count);

// Clears the cells whose centre does not satisfy the rule of their class, and those on which no view votes.
// Without views nothing is cleared. class_of: one byte per cell, index into `rules`.
void carve(OccupancyGrid& grid, const FieldCube& cube, std::span<const CarveView> views,
           std::span<const std::uint8_t> class_of, std::span<const CarveRule> rules);

}  // namespace likeness
