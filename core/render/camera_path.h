// Views and poses: orbits about the head, head turns, and articulations from named actions.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/render/render.h"

namespace likeness {

// The fixed point of an orbit: the middle of the head's occupied cells, in the head frame, m.
Vec3d head_centre(const Avatar& avatar);

// The typical camera moved round the head by yaw (about the head's vertical axis, positive towards the
// subject's left) and pitch (positive above), rad; the head's centre keeps its distance and its place in the
// picture.
Camera orbit_camera(const Avatar& avatar, const Pose& world_from_head, double yaw, double pitch = 0);

// Head turned about its centre of rotation (the neck's top) by yaw, pitch, roll about its own y, x, z axes,
// rad.
Pose turned_head(const Pose& world_from_head, const Vec3d& pivot_in_head, double yaw, double pitch,
                 double roll);

// Of so many frames at a steady rate, the first one's 0; a rate of 0 counts as 25 a second.
std::vector<double> steady_times(int frames, double frames_per_second);

// One sine period of yaw from the first time to the last, starting and ending straight ahead, as far as
// `high` and then `low`; one a time. low <= 0 <= high.
std::vector<double> orbit_yaws(std::span<const double> times_s, double low, double high);

// `neutral` plus the named actions at the given values (0 none, 1 full). Unknown names are an Error that
// lists the known ones.
Result<Articulation> articulate(const HeadModel& model, const Articulation& neutral,
                                const std::vector<std::pair<std::string, float>>& actions);

}  // namespace likeness
