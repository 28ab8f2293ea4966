// See parts.h.
#include "app/parts.h"

#include <fmt/format.h>

#include "core/train/choose_parts.h"

namespace likeness::app {

std::string parts_text(const std::vector<AvatarPart>& parts) {
  std::string text;
  for (const AvatarPart& part : parts)
    text += fmt::format("  {}: {}{}\n    {}\n", part_title(part.name), part.value,
                        part.asked ? " (your choice)" : "", part.reason);
  return text;
}

nlohmann::json parts_json(const std::vector<AvatarPart>& parts) {
  nlohmann::json list = nlohmann::json::array();
  for (const AvatarPart& part : parts)
    list.push_back({{"part", part.name},
                    {"on", part.on},
                    {"by", part.asked ? "user" : "capture"},
                    {"value", part.value},
                    {"reason", part.reason}});
  return list;
}

}  // namespace likeness::app
