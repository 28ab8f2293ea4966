// What an avatar costs, as text and as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "core/lab/bench/project_speed.h"

namespace likeness::app {

nlohmann::json project_speed_json(const ProjectSpeed& speed);
void print_project_speed(const ProjectSpeed& speed);

}  // namespace likeness::app
