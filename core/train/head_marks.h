// Heights and depths of the neutral head by which its parts are told apart: where hair grows, where the neck
// ends.
#pragma once

#include "core/head/pose_head.h"

namespace likeness {

// m, head frame.
struct HeadMarks {
  float base = 0;  // height of the neck's base, see neck_base
  float chin = 0, nose = 0, brow = 0;
  float ear_z = 0;  // depth of the jaw's upper ends, before the ears
};
HeadMarks head_marks(const HeadModel& model, const HeadShape& shape);

// Depth of the neck's axis at its base, m, head frame: the middle of a body, as far as a head knows.
float neck_axis(const HeadModel& model, const HeadShape& shape);

// The middle of the head, m: half a face's width behind the middle of the landmarks, which lie on its front.
// posed: the model's vertices.
Vec3f head_middle(const HeadModel& model, const std::vector<Vec3f>& posed);

// Outer surface: neither mouth, teeth, eyeballs nor their sockets.
bool is_skin(const HeadModel& model, std::size_t vertex);

// 0 on face and neck, 1 on the scalp and behind the ears, fading out from the nose's height down to the chin.
float hairiness(const HeadMarks& marks, const Vec3f& p);

}  // namespace likeness
