// See what_holds.h.
#include "core/project/what_holds.h"

#include <utility>

#include "core/holds/check_holds.h"

namespace likeness {

Result<HoldingRange> what_holds(const Avatar& avatar, const HeadModel& model, const RenderPlace& place,
                                const Progress& progress, std::stop_token stop) {
  if (avatar.holds) return *avatar.holds;
  auto check = check_holds(avatar, model, place, {}, progress, stop);
  if (!check) return check.error();
  return std::move(check->range);
}

}  // namespace likeness
