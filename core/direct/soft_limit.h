// Limits that resist: what is dragged from inside stops where the avatar stops to hold; whoever wants more
// says so, by dragging on from there or by holding a key.
#pragma once

#include "core/direct/seen_limits.h"

namespace likeness {

// began: the value with which the drag began; wanted: what the mouse asks for now. insists: the user asks for
// more. The value to set: within the limits on the side on which the drag began inside them; a drag that
// begins at a limit, or beyond it, goes on freely there.
float softly_limited(float began, float wanted, const ValueRange& limits, bool insists);

}  // namespace likeness
