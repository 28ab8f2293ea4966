// Where the timeline lies and what its rows are; shared by its drawing and its mouse.
#pragma once

#include <algorithm>

#include "ui/studio/snapshot.h"
#include "ui/theme.h"
#include "ui/views.h"

namespace likeness::ui {

inline constexpr float kRuler = 20, kRow = 19;  // heights, units

// Where things lie: rows are the channels under one of all of them.
struct TimelinePlace {
  ImVec2 at, size;  // of the ruler and the rows
  float left = 0;   // of the times
  double from_s = 0, span_s = 1;
  float scroll = 0;

  float x_of(double time_s) const {
    return left + float((time_s - from_s) / span_s) * (at.x + size.x - left);
  }
  double time_at(float x) const {
    return from_s + double((x - left) / std::max(1.f, at.x + size.x - left)) * span_s;
  }
  float row_top(int row) const {  // row 0: all keys, which does not scroll
    return at.y + px(kRuler) + float(row) * px(kRow) - (row > 0 ? scroll : 0);
  }
};

// Puts a performance's rows and what is chosen of them into the sight, where they are not there yet: a long
// take has 100,000 keys, too many to be gone through for every picture of the window.
void find_rows(const DirectingView& directing, TimelineSight& sight);

// The mouse over the item drawn last, which covers the ruler and the rows: scrubs, chooses, drags, zooms.
void use_timeline_mouse(const TimelinePlace& place, const DirectingView& directing, TimelineSight& sight,
                        Requests& requests);

}  // namespace likeness::ui
