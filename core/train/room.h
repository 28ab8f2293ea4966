// The room behind a person who was filmed by a moving camera: a static field in the world's frame, learnt
// from what the mattes leave of its pictures. Closed: what lies beyond its cube is painted
// on the cube's sides.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/render/avatar.h"
#include "core/train/train.h"

namespace likeness {

struct RoomOptions {
  std::uint64_t steps = 500;
  int rays_per_step = 4096;
  std::uint64_t seed = 0;
};

// Fewer views say too little.
inline constexpr std::size_t kMinRoomViews = 8;

// The cube that holds what the cameras see. points: of the room, world frame, m; outliers may be among them.
// Too few of them: as far about the head of the first view as rooms usually reach. At most 30 m, with that
// head in it.
FieldCube room_cube(std::span<const TrainingView> views, std::span<const Vec3f> points);

// Of the views, camera, head, picture and matte are read. Deterministic for one seed and exact steps,
// whatever the threads. not_found where the mattes leave no background.
Result<FieldPart> train_room(std::span<const TrainingView> views, const FieldCube& cube,
                             const RoomOptions& options, const Progress& progress, std::stop_token stop);

}  // namespace likeness
