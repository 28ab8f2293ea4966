// A body as far as its outline tells: what the mattes show below the chin, blown up to the thickness of a
// chest and closed behind, at the sides and where the pictures end.
#pragma once

#include <cstddef>
#include <optional>

#include "core/head/pose_head.h"
#include "core/train/proxy_picture.h"

namespace likeness {

struct ProxyBust {
  ProxyPart part;  // vertices in the torso frame
  std::vector<std::uint8_t>
      says;                   // (F) 0: behind head and neck, and where pictures cut it off above and below
  float top = 0, axis_z = 0;  // m, torso frame: its upper end, the depth of its middle
  // Shares of the mattes' pixels: below its upper end that neither it nor the head explains - arms, other
  // people - and beside the neck that the head does not: hair, collars, raised shoulders.
  double unexplained = 1, neck_unexplained = 1;
};

// head: hides what is behind chin and neck. From own views; they need mattes. Refers to the set. nullopt
// where they hardly show a torso.
std::optional<ProxyBust> make_proxy_bust(const TrainingSet& set, const HeadShape& shape,
                                         const ProxyPart& head);

}  // namespace likeness
