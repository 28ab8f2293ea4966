// Pictures that nobody filmed, for a training to learn from where its clip is silent: the proxy head and the
// proxy bust at moments of the clip, as cameras well beside every filmed view would see them, and the head
// with expressions that the clip never shows, as cameras near its own would; with the pixels of the moment's
// own picture wherever that shows the place.
//
// They say where the surface is - opaque there, nothing beside it - and how it looks to about the
// detail that can be carried over. Without them a training explains a front view by layers of any depth, and
// by colours that depend on the direction of view, both of which fall apart from the side.
#pragma once

#include <vector>

#include "core/train/train.h"

namespace likeness {

struct ProxyViewOptions {
  double share = 0.1, torso_share = 0.1;  // number of proxies of heads and of torsos, of own views'
  int least = 20, torso_least = 20;       // of them
  // At least, from every filmed view of the head, or of the torso, which no clip sees from many sides.
  double beside_deg = 12, torso_beside_deg = 6;
  double yaw_deg = 55, pitch_deg = 35;  // at most, from a moment's own view
  // The same of heads with expressions that the clip never shows.
  double face_share = 0.05;
  int face_least = 20;
  double face_yaw_deg = 30, face_pitch_deg = 15;
};

// Those of heads first. Of the size of the moments' pictures, before no plate, each of one part alone;
// `teaches` leaves out what the proxy does not know: the neck's lower end, the outline, what is below the
// chin beside a head and above the shoulders beside a bust and, where the proxy does not explain the clip's
// own mattes, what is below the brows, or everything, beside it. Fewer than asked for, or none, where the
// clip shows the head from everywhere around or has no mattes. Deterministic.
std::vector<TrainingView> make_proxy_views(const TrainingSet& set, const ProxyViewOptions& options = {});

// At most so many for this many own views: what they may take of memory. None for a handful of views.
std::size_t most_proxies(std::size_t own_views, const ProxyViewOptions& options = {});

}  // namespace likeness
