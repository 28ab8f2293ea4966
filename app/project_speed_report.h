// What an avatar costs, as a table and as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/table.h"
#include "core/lab/bench/project_speed.h"

namespace likeness::app {

nlohmann::json project_speed_json(const ProjectSpeed& speed);
Table project_speed_table(const ProjectSpeed& speed);

}  // namespace likeness::app
