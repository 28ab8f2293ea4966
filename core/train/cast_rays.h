// A training's rays cast on the device that its learner computes on: pictures, poses and grids are kept
// there, and a step takes no ray from the host. What the kernels do: device_rays.h.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/render/backend.h"
#include "core/train/ray_batch.h"
#include "core/train/step_options.h"
#include "core/train/training_state.h"

namespace likeness {

class RayCaster : public DeviceRaySource {
 public:
  ~RayCaster() override;

  // The source's poses or colours changed.
  virtual Result<void> place_views(const RaySource& source) = 0;
  // The state's cells changed; and the other way round, if the device looked them up.
  virtual Result<void> place_cells(const TrainingState& state) = 0;
  virtual Result<void> fetch_cells(TrainingState& state) = 0;
  // Before a step.
  virtual Result<void> set_step(std::uint64_t step) = 0;
  // Samples every cell (occupancy_refresh.h). Queues work; waits for nothing.
  virtual Result<void> refresh(std::uint64_t step) = 0;
};

struct CasterChoice {
  std::unique_ptr<RayCaster> caster;  // null: the processor casts the rays
  std::string why_not;                // empty if the learner does not compute on a device
};
// Device memory for the pictures of a set, bytes.
std::size_t picture_bytes(const TrainingSet& set);

// Null with patches (their pixels are chosen by the processor), if the pictures would take more than half of
// the device's free memory, and if the device fails meanwhile. The learner must stay where it is, and so must
// the state and the set.
CasterChoice make_ray_caster(FieldLearner& learner, const TrainingState& state, const RaySource& source,
                             const StepOptions& options);

}  // namespace likeness
