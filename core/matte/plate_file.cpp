// See plate_file.h.
#include "core/matte/plate_file.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"

namespace likeness {

Result<void> write_plate_info(const std::filesystem::path& path, const PlateInfo& info) {
  std::string text = fmt::format(
      "{{\n\"format\":\"likeness-plate\",\"version\":1,\n\"coverage\":{:.17g},\n\"frames\":[", info.coverage);
  for (std::size_t i = 0; i < info.frames.size(); ++i)
    text += fmt::format("{}{}", i ? "," : "", info.frames[i]);
  return write_text(path, text + "]\n}\n");
}

Result<PlateInfo> read_plate_info(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return PlateInfo{};
  const auto text = read_text(path);
  if (!text) return text.error();
  const Error bad{ErrorCode::bad_input, "This is not a plate.json of a version that Likeness reads.",
                  "Delete it and run the matte stage again (`likeness fit`).", path.string()};
  try {
    const auto json = parse_json(*text);
    if (json.value("version", 0) != 1) return bad;
    return PlateInfo{json.at("coverage").get<double>(), json.at("frames").get<std::vector<int>>()};
  } catch (const nlohmann::json::exception&) {
    return bad;
  }
}

}  // namespace likeness
