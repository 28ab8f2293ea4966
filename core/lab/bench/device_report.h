// A device's measurements as JSON, with their units in the names.
#pragma once

#include <nlohmann/json.hpp>

#include "core/lab/bench/device_speed.h"

namespace likeness {

const char* precision_name(NetworkPrecision precision);
nlohmann::json to_json(const DeviceBenchReport& report);

}  // namespace likeness
