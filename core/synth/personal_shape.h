// What a person of the demo has beyond any head model: the true surface of the face beyond the identity
// directions, and a way of smiling and frowning beyond the expressions. Without it, fitting the demo with the
// head model that made it would be an inverse crime.
#pragma once

#include <vector>

#include "core/head/head_model.h"
#include "core/head/pose_head.h"
#include "core/synth/cast.h"

namespace likeness {

// Identity and offsets of a person. The offsets are smooth random shape (asymmetric nose, jaw, brow, cheeks)
// and folds, scaled so that the best fit of identity, place and size leaves kOffSpanRms of them over the
// vertices of the part `face`. Eyeballs with their lids, and teeth with the lips, move in one piece.
inline constexpr float kOffSpanRms = 0.0023f;  // m
PersonShape make_personal_shape(const HeadModel& model, const DemoPerson& person, int number, int seed);

// RMS over the face's vertices of the part that no identity, place and size of the model explains, m.
double off_span_rms(const HeadModel& model, const std::vector<Vec3f>& vertices);

// A displacement that comes with named actions but lies outside the expressions' span.
struct PersonalAction {
  const char* name;
  std::vector<Vec3f> field;  // (V) m at strength 1, in the unposed head
};

// The person's own expressions: a crooked smile, deepening folds beside the nose, one raised brow with a
// furrowed forehead, a skewed lower lip, a dimpled chin.
class PersonalPlay {
 public:
  PersonalPlay(const HeadModel& model, const HeadShape& shape, const DemoPerson& person);

  const std::vector<PersonalAction>& actions() const { return actions_; }
  // A change that accompanies no action: the right cheek puffed, beyond the expressions' span. (V) m at
  // strength 1.
  const std::vector<Vec3f>& habit() const { return habit_; }
  // Strength of each action, 0 .. about 1, that accompanies the face's performance.
  std::vector<float> strengths(const Articulation& articulation) const;
  // The true posed head: (V) vertices in the head frame, m.
  std::vector<Vec3f> pose(const Articulation& articulation, float habit = 0) const;

 private:
  const HeadModel& model_;
  const HeadShape& shape_;
  std::vector<PersonalAction> actions_;
  std::vector<Vec3f> habit_;
};

}  // namespace likeness
