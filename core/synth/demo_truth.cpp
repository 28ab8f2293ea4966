// Two more keys in the cameras' file.
#include "core/synth/demo_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/synth/demo_camera.h"

namespace likeness {
namespace {

std::string shot_line(const DemoShot& shot) {
  return fmt::format(R"({{"first":{},"last":{},"cut":"{}","place":{},"camera":{}}})", shot.first, shot.last,
                     cut_name(shot.kind), shot.place, shot.camera);
}

Error bad_truth(const std::filesystem::path& path, const std::string& what) {
  return {ErrorCode::bad_input, fmt::format("This is not the truth of a demo: {}.", what),
          "Make the demo again with `likeness demo`.", path.string()};
}

}  // namespace

Result<void> add_demo_truth(const std::filesystem::path& cameras_truth, const DemoOptions& options,
                            const std::vector<DemoShot>& shots) {
  if (options.camera == DemoCamera::guided && shots.size() < 2) return {};
  auto text = read_text(cameras_truth);
  if (!text) return text.error();
  std::string more;
  if (options.camera != DemoCamera::guided)
    more += fmt::format("\n\"demo_camera\":\"{}\",", demo_camera_names()[std::size_t(options.camera)]);
  if (shots.size() > 1) {
    more += "\n\"demo_shots\":[";
    for (const DemoShot& shot : shots) more += (shot.first == 0 ? "\n" : ",\n") + shot_line(shot);
    more += "],";
  }
  const std::size_t at = text->find("\n\"cameras\":[");
  LIKENESS_CHECK(at != std::string::npos, "no cameras in what write_cameras wrote");
  return write_text(cameras_truth, text->insert(at, more));
}

Result<DemoTruth> read_demo_truth(const std::filesystem::path& cameras_truth) {
  const auto text = read_text(cameras_truth);
  if (!text) return text.error();
  DemoTruth truth;
  try {
    const auto json = parse_json(*text);
    const std::string camera = json.value("demo_camera", "guided");
    const auto& names = demo_camera_names();
    const auto kind = std::ranges::find(names, camera);
    if (kind == names.end()) return bad_truth(cameras_truth, fmt::format("it has a camera \"{}\"", camera));
    truth.camera = DemoCamera(kind - names.begin());
    if (!json.contains("demo_shots")) return truth;
    for (const auto& entry : json.at("demo_shots")) {
      const TrueShot shot{whole_number_in(entry.at("first")), whole_number_in(entry.at("last")),
                          entry.at("cut").get<std::string>(), whole_number_in(entry.at("place")),
                          whole_number_in(entry.at("camera"))};
      const int next = truth.shots.empty() ? 0 : truth.shots.back().last + 1;
      if (shot.first != next || shot.last < shot.first)
        return bad_truth(cameras_truth, fmt::format("shot {} has a gap before it", truth.shots.size() + 1));
      truth.shots.push_back(shot);
    }
  } catch (const nlohmann::json::exception& fault) {
    return bad_truth(cameras_truth, fault.what());
  }
  return truth;
}

}  // namespace likeness
