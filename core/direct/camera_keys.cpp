// Few keys, smooth between them: see camera_keys.h.
#include "core/direct/camera_keys.h"

#include <algorithm>

#include "core/direct/edit_keys.h"

namespace likeness {

void set_orbit(Performance& performance, ValueRange yaw_deg) {
  performance.channels.erase("camera yaw");
  const double end = performance.duration_s;
  // Time is divided in proportion to the angles, so that the camera keeps its pace.
  const double high = double(yaw_deg.high), low = double(-yaw_deg.low), whole = 2 * (high + low);
  set_key(performance, "camera yaw", {0, 0});
  if (whole <= 0) return;
  set_key(performance, "camera yaw", {end * high / whole, yaw_deg.high});
  set_key(performance, "camera yaw", {end * (2 * high + low) / whole, yaw_deg.low});
  set_key(performance, "camera yaw", {end, 0});
}

void set_dolly(Performance& performance, float from, float to) {
  performance.channels.erase("camera distance");
  set_key(performance, "camera distance", {0, from});
  set_key(performance, "camera distance", {performance.duration_s, to});
}

ValueRange orbit_range(const std::map<std::string, ValueRange>& limits, bool held) {
  const auto seen = limits.find("camera yaw");
  if (seen == limits.end()) return {-25, 25};
  const float least = held ? 0 : 10;
  return {std::clamp(seen->second.low, -45.0f, -least), std::clamp(seen->second.high, least, 45.0f)};
}

}  // namespace likeness
