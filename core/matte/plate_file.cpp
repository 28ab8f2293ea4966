// See plate_file.h.
#include "core/matte/plate_file.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"

namespace likeness {
namespace {

std::string camera_text(const Camera& camera) {
  const Intrinsics& k = camera.intrinsics;
  std::string text = fmt::format(
      R"({{"width":{},"height":{},"fx":{:.17g},"fy":{:.17g},"cx":{:.17g},"cy":{:.17g},"rotation":[)", k.width,
      k.height, k.fx, k.fy, k.cx, k.cy);
  for (int i = 0; i < 9; ++i)
    text += fmt::format("{}{:.17g}", i ? "," : "", camera.cam_from_world.linear()(i / 3, i % 3));
  return text + "]}";
}

std::optional<Camera> camera_from_json(const nlohmann::json& entry) {
  Camera camera;
  camera.frame = -1;
  Intrinsics& k = camera.intrinsics;
  k.width = whole_number_in(entry.at("width")), k.height = whole_number_in(entry.at("height"));
  k.fx = entry.at("fx").get<double>(), k.fy = entry.at("fy").get<double>();
  k.cx = entry.at("cx").get<double>(), k.cy = entry.at("cy").get<double>();
  const auto rotation = entry.at("rotation").get<std::vector<double>>();
  if (k.width <= 0 || k.height <= 0 || !(k.fx > 0) || !(k.fy > 0) || rotation.size() != 9)
    return std::nullopt;
  Mat3d turn;
  for (int i = 0; i < 9; ++i) turn(i / 3, i % 3) = rotation[std::size_t(i)];
  if (!((turn * turn.transpose() - Mat3d::Identity()).cwiseAbs().maxCoeff() < 1e-4)) return std::nullopt;
  camera.cam_from_world.linear() = turn;
  return camera;
}

}  // namespace

Result<void> write_plate_info(const std::filesystem::path& path, const PlateInfo& info) {
  std::string text = fmt::format(
      "{{\n\"format\":\"likeness-plate\",\"version\":1,\n\"coverage\":{:.17g},\n\"frames\":[", info.coverage);
  for (std::size_t i = 0; i < info.frames.size(); ++i)
    text += fmt::format("{}{}", i ? "," : "", info.frames[i]);
  text += "]";
  if (info.camera) text += ",\n\"camera\":" + camera_text(*info.camera);
  return write_text(path, text + "\n}\n");
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
    PlateInfo info{json.at("coverage").get<double>(), whole_numbers_in(json.at("frames"))};
    if (json.contains("camera")) {
      info.camera = camera_from_json(json.at("camera"));
      if (!info.camera) return bad;
    }
    return info;
  } catch (const nlohmann::json::exception&) {
    return bad;
  }
}

}  // namespace likeness
