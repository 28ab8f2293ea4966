// The metric scale of a camera solve of unknown scale: that at which the metric head is steadiest in the
// world.
#pragma once

#include <optional>
#include <vector>

#include "core/base/linalg.h"

namespace likeness {

struct HeadSighting {
  Pose cam_from_world = Pose::Identity();  // translation in the solve's units
  Pose cam_from_head = Pose::Identity();   // m
};

// Robust least squares on differences between frames a few to a few dozen apart: where the head itself moves,
// those differences are outliers. nullopt if the cameras hardly move, so that no scale is better than
// another.
std::optional<double> steady_metres_per_unit(const std::vector<HeadSighting>& sightings);

// cam_from_world with its translation in metres.
Pose metric_camera(const Pose& cam_from_world, double metres_per_unit);

}  // namespace likeness
