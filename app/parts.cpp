// See parts.h.
#include "app/parts.h"

#include <fmt/format.h>

#include "core/train/choose_parts.h"

namespace likeness::app {

void print_parts(std::FILE* out, const std::vector<AvatarPart>& parts) {
  for (const AvatarPart& part : parts)
    fmt::print(out, "  {}: {}{}\n    {}\n", part_title(part.name), part.value,
               part.asked ? " (your choice)" : "", part.reason);
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
