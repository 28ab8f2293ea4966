// What of an avatar holds beyond its clip, as the command line tells it.
#pragma once

#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/table.h"
#include "core/direct/beyond_holds.h"
#include "core/holds/check_holds.h"
#include "core/lab/beyond/beyond_study.h"
#include "core/render/holding_range.h"

namespace likeness::app {

// {"yaw": [low, high], "pitch": [low, high], "actions": {NAME: amount}}, degrees of the camera as seen from
// the head; 1 = all of an action.
nlohmann::json holds_json(const HoldingRange& range);

// {"frames", "view_deg", "sides": ["left", ...], "actions": {NAME: amount}, "film_again": [...]}: what of a
// film goes beyond what holds; null where no check of the avatar is known.
nlohmann::json beyond_holds_json(const std::optional<HoldingRange>& range, const BeyondHolds& beyond);
// The same as a warning, on the error stream; nothing where nothing goes beyond.
void warn_beyond_holds(const std::optional<HoldingRange>& range, const BeyondHolds& beyond);

// What the avatar's own check found of each view and action: alone, in the form in which studies with a truth
// tell theirs, and as a table.
nlohmann::json check_json(const HoldCheck& check);
Table check_table(const HoldCheck& check);
// The table, and whether the truth says the same.
std::vector<Table> holds_tables(const BeyondStudy& study);

}  // namespace likeness::app
