// Where the person is, coarsely, before the cameras are known.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/camera/align_options.h"

namespace likeness {

// Landmark-free person mask for the cameras: head ellipse and the shoulders below it, dilated, and what a
// person network sees of the same person: hands, arms, wide hair. Detects per frame, 15 ms a face with the
// network. in_sequence: called for the pictures of a clip in order; an uncertain detection counts if a face
// was there a moment ago, and a missed face is taken to be still there. person_network: as
// chosen_person_network takes it (core/matte/person_network.h). A picture in which the network fails is
// masked without it.
enum class Pictures { in_sequence, single };
Result<PersonMask> coarse_person_mask(const std::filesystem::path& predictor = {},
                                      Pictures pictures = Pictures::in_sequence,
                                      const std::filesystem::path& person_network = {});

}  // namespace likeness
