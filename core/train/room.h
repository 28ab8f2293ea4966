// The room behind a person who was filmed by a moving camera: a static field in the world's frame, learnt
// from the pictures outside the mattes. Closed: what lies beyond its cube is painted on the cube's sides.
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

// Fewer views are not enough.
inline constexpr std::size_t kMinRoomViews = 8;

// The cube that holds what the cameras see. points: of the room, world frame, m; may include outliers. With
// too few of them: the usual size of rooms around the head of the first view. At most 30 m, with that head in
// it.
FieldCube room_cube(std::span<const TrainingView> views, std::span<const Vec3f> points);

// Reads the views' camera, head, picture and matte. Deterministic for one seed and exact steps, whatever the
// threads. not_found if the mattes leave no background.
Result<FieldPart> train_room(std::span<const TrainingView> views, const FieldCube& cube,
                             const RoomOptions& options, const Progress& progress, std::stop_token stop);

}  // namespace likeness
