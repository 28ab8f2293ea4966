// Steps between views.
#include "core/camera/handheld_view.h"

#include <cmath>

#include "core/base/rigid.h"

namespace likeness {

Intrinsics view_intrinsics(const Intrinsics& reference, const HandheldView& view) {
  Intrinsics k = reference;
  const double zoom = std::exp(view.log_zoom);
  k.fx *= zoom, k.fy *= zoom;
  k.cx += view.shift.x(), k.cy += view.shift.y();
  return k;
}

HandheldView stepped(const HandheldView& view, const ViewStep& step) {
  return {turn_from_vector(step.head<3>()) * view.turn, view.log_zoom + step[3],
          view.shift + Vec2d(step[4], step[5])};
}

ViewStep view_step(const HandheldView& from, const HandheldView& to) {
  ViewStep step;
  step.head<3>() = vector_from_turn(to.turn * from.turn.transpose());
  step[3] = to.log_zoom - from.log_zoom;
  step.tail<2>() = to.shift - from.shift;
  return step;
}

}  // namespace likeness
