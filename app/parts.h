// The parts of an avatar, and why it has them, as the command line tells them.
#pragma once

#include <cstdio>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/render/avatar.h"

namespace likeness::app {

// Two indented lines a part: what it is, and the reason.
void print_parts(std::FILE* out, const std::vector<AvatarPart>& parts);

// [{"part", "on", "by": "capture" | "user", "value", "reason"}]
nlohmann::json parts_json(const std::vector<AvatarPart>& parts);

}  // namespace likeness::app
