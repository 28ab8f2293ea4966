// How far an avatar holds beyond its clip: as its training found it, or found now.
#pragma once

#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/render/avatar.h"
#include "core/render/backend.h"

namespace likeness {

// Of an avatar from before a training looked for it, it is found now, in seconds; nothing is written. Errors:
// as check_holds (core/holds/check_holds.h).
Result<HoldingRange> what_holds(const Avatar& avatar, const HeadModel& model, const RenderPlace& place,
                                const Progress& progress, std::stop_token stop);

}  // namespace likeness
