// Camera paths as keys: they replace the camera's keys, and can be edited like any others.
#pragma once

#include <map>
#include <string>

#include "core/direct/performance.h"
#include "core/direct/seen_limits.h"

namespace likeness {

// Once to both sides and back, over the whole performance. low < 0 < high: degrees.
void set_orbit(Performance& performance, ValueRange yaw_deg);
// Nearer (< 1) or further (> 1) from the start to the end, times the typical distance.
void set_dolly(Performance& performance, float from, float to);

// How far an orbit goes that nobody limits: as far as the avatar was found to hold (limits_hold of "camera
// yaw"), and at most 45 degrees to each side; where only the clip's views are known, at least 10.
ValueRange orbit_range(const std::map<std::string, ValueRange>& limits, bool held);

}  // namespace likeness
