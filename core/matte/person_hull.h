// Hulls of head and torso from the mattes so far, and their evidence for one picture.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/matte/hull.h"
#include "core/matte/person_prior.h"

namespace likeness {

// One matte and where the person is in it.
struct MattedView {
  PersonPlace place;
  Intrinsics picture;
  cv::Mat person;  // 8U, 255 = person
};

struct PersonHull {
  Hull head, torso;  // in the head's and the torso's frame
  bool empty() const { return head.empty(); }
};

PersonHull carve_person(const PersonModel& person, const std::vector<MattedView>& views);

// Adds the hull's evidence to the prior: what most directions of view see past is hardly the person.
void sharpen_prior(PersonPrior& prior, const PersonHull& hull, const PersonPlace& place,
                   const Intrinsics& picture);

}  // namespace likeness
