// The parts of an avatar, and why it has them, as the command line tells them.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/render/avatar.h"

namespace likeness::app {

// Two indented lines a part: what it is, and the reason.
std::string parts_text(const std::vector<AvatarPart>& parts);

// [{"part", "on", "by": "capture" | "user", "value", "reason"}]
nlohmann::json parts_json(const std::vector<AvatarPart>& parts);

}  // namespace likeness::app
