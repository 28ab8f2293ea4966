// The 68 iBUG landmarks of the built-in head. Internal to core/head.
#pragma once

#include "core/head/builtin_fields.h"

namespace likeness::builtin {

// Where the landmarks are on the neutral head, mm.
std::array<Vec3d, kLandmarkCount> landmark_targets(const WholeHead& head);

// Fills landmark_triangle and landmark_barycentric with the nearest points of the face's triangles.
void embed_landmarks(const WholeHead& head, HeadModel& model);

}  // namespace likeness::builtin
