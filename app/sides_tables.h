// What likeness study beyond prints of a project that was built with --split sides.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/table.h"
#include "core/lab/beyond/sides_study.h"

namespace likeness::app {

std::vector<Table> sides_tables(const SidesStudy& study);
// As the contract of the command has it, with what else is known; specks and silhouettes are shares. What a
// clip cannot tell - depths, actions beside each other - is null or empty.
nlohmann::json sides_json(const SidesStudy& study);

}  // namespace likeness::app
