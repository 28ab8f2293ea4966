// cameras.json: one line per camera, so that a person can read it and a diff shows what changed.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/camera/camera.h"

namespace likeness {
namespace {

constexpr int kVersion = 1;

Error bad_cameras(const std::filesystem::path& path, std::string what) {
  return {ErrorCode::bad_input, std::move(what),
          "Run `likeness align` again to rewrite the file, or restore it from a copy.", path.string()};
}

std::string camera_line(const Camera& camera) {
  const Intrinsics& k = camera.intrinsics;
  std::string line = fmt::format(
      R"({{"frame":{},"width":{},"height":{},"fx":{:.17g},"fy":{:.17g},"cx":{:.17g},"cy":{:.17g},)"
      R"("k1":{:.17g},"k2":{:.17g},"p1":{:.17g},"p2":{:.17g},"cam_from_world":[)",
      camera.frame, k.width, k.height, k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      line += fmt::format("{}{:.17g}", row + column ? "," : "", camera.cam_from_world.matrix()(row, column));
  return line + "]}";
}

std::string shots_text(const std::vector<CameraShot>& shots) {
  std::string text;
  for (const CameraShot& shot : shots)
    text += fmt::format(R"({}{{"from_s":{:.17g},"to_s":{:.17g},"camera":"{}"}})", text.empty() ? "" : ",",
                        shot.from_s, shot.to_s, camera_kind_name(shot.camera));
  return text;
}

std::optional<CameraKind> kind_from_json(const nlohmann::json& name) {
  return camera_kind_named(name.get<std::string>());
}

// Reads one camera; returns what is wrong with it, or an empty string.
std::string parse_camera(const nlohmann::json& entry, Camera& camera) {
  Intrinsics& k = camera.intrinsics;
  camera.frame = whole_number_in(entry.at("frame"), -1, 100'000'000);
  k.width = whole_number_in(entry.at("width"), 1, 1 << 16);
  k.height = whole_number_in(entry.at("height"), 1, 1 << 16);
  // In sides of the picture: lenses are 0.2 to 60 of them long. Beyond these bounds angles and places lose
  // all digits.
  const double side = std::max(k.width, k.height);
  for (const auto& [name, focal] : {std::pair("fx", &k.fx), {"fy", &k.fy}})
    *focal = number_in(entry.at(name), 0.01 * side, 1e4 * side);
  for (const auto& [name, centre] : {std::pair("cx", &k.cx), {"cy", &k.cy}})
    *centre = number_in(entry.at(name), -1e3 * side, 1e3 * side);
  for (const auto& [name, bend] : {std::pair("k1", &k.k1), {"k2", &k.k2}, {"p1", &k.p1}, {"p2", &k.p2}})
    *bend = entry.contains(name) ? number_in(entry.at(name), -1e3, 1e3) : 0;
  const auto& pose = entry.at("cam_from_world");
  if (!pose.is_array() || pose.size() != 12) return "cam_from_world without 12 numbers (row-major 3x4)";
  for (int i = 0; i < 12; ++i) camera.cam_from_world.matrix()(i / 4, i % 4) = number_in(pose[i], -1e9, 1e9);
  const Mat3d rotation = camera.cam_from_world.linear();
  const double error = (rotation * rotation.transpose() - Mat3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error < 1e-4) || rotation.determinant() < 0)
    return "a cam_from_world that is not a rotation and translation";
  return {};
}

}  // namespace

Result<void> write_cameras(const std::filesystem::path& path, const CameraSet& set) {
  std::string text = fmt::format(
      "{{\n\"format\":\"likeness-cameras\",\"version\":{},\n"
      "\"units\":{{\"length\":\"{}\",\"intrinsics\":\"px\",\"axes\":\"OpenCV: x right, y down, z "
      "forward\"}},\n"
      "\"camera\":\"{}\",\"static\":{},\"scale\":\"{}\",\"reprojection_px\":{:.17g},\n\"shots\":[{}],\n"
      "\"cameras\":[\n",
      kVersion, set.scale == CameraScale::metric ? "m" : "arbitrary", camera_kind_name(set.kind), set.rests(),
      set.scale == CameraScale::metric ? "metric" : "arbitrary", set.reprojection_px, shots_text(set.shots));
  for (std::size_t i = 0; i < set.cameras.size(); ++i)
    text += camera_line(set.cameras[i]) + (i + 1 < set.cameras.size() ? ",\n" : "\n");
  return write_text(path, text + "]}\n");
}

Result<CameraSet> read_cameras(const std::filesystem::path& path) {
  auto text = read_text(path);
  if (!text) return text.error();
  CameraSet set;
  try {
    const auto json = parse_json(*text);
    const int version = json.value("version", kVersion);
    if (version > kVersion)
      return Error{
          ErrorCode::bad_input,
          fmt::format("The file has version {}; this program reads versions up to {}.", version, kVersion),
          "Install a newer Likeness, or run `likeness align` again with this one.", path.string()};
    for (const auto& entry : json.at("cameras")) {
      Camera camera;
      const std::string fault = parse_camera(entry, camera);
      if (!fault.empty())
        return bad_cameras(path, fmt::format("Camera {} has {}.", set.cameras.size() + 1, fault));
      set.cameras.push_back(camera);
    }
    // Files from before "camera" say only whether it rests.
    const bool rests = json.value("static", set.cameras.size() == 1 && set.cameras.front().frame < 0);
    set.kind = rests ? CameraKind::resting : CameraKind::walking;
    if (json.contains("camera")) {
      const auto kind = kind_from_json(json.at("camera"));
      if (!kind) return bad_cameras(path, "The file names a kind of camera that is not known.");
      set.kind = *kind;
    }
    for (const auto& entry : json.value("shots", nlohmann::json::array())) {
      const auto kind = kind_from_json(entry.at("camera"));
      if (!kind) return bad_cameras(path, "The file names a kind of camera that is not known.");
      set.shots.push_back({entry.at("from_s").get<double>(), entry.at("to_s").get<double>(), *kind});
    }
    set.scale = json.value("scale", "arbitrary") == std::string("metric") ? CameraScale::metric
                                                                          : CameraScale::arbitrary;
    set.reprojection_px = json.value("reprojection_px", 0.0);
  } catch (const nlohmann::json::exception& fault) {
    return bad_cameras(path, fmt::format("This is not a cameras.json: {}.", fault.what()));
  }
  if (set.cameras.empty()) return bad_cameras(path, "The file holds no camera.");
  if (set.rests() && set.cameras.size() != 1)
    return bad_cameras(
        path, fmt::format("A resting camera is a single camera; the file holds {}.", set.cameras.size()));
  std::sort(set.cameras.begin(), set.cameras.end(),
            [](const Camera& a, const Camera& b) { return a.frame < b.frame; });
  for (std::size_t i = 1; i < set.cameras.size(); ++i)
    if (set.cameras[i].frame == set.cameras[i - 1].frame)
      return bad_cameras(path, fmt::format("Frame {} has two cameras.", set.cameras[i].frame));
  return set;
}

}  // namespace likeness
