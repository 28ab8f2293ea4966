// check.json: see checked_clip.h.
#include "core/check/checked_clip.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"

namespace likeness {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// Raised when the check judges otherwise, so that clips are looked at again.
constexpr int kCheckVersion = 1;
constexpr double kMostSeconds = 1e9;
constexpr int kMost = std::numeric_limits<int>::max();

// The value of an enumeration whose name this is.
template <class Value, class Name>
Value named(const json& text, Value last, Name name) {
  for (int i = 0; i <= int(last); ++i)
    if (text.get<std::string>() == name(Value(i))) return Value(i);
  throw json::other_error::create(501, "there is no such name", &text);
}

double seconds_in(const json& j, const char* key) {
  return number_in(j.at(key), -kMostSeconds, kMostSeconds);
}
int count_in(const json& j, const char* key) { return whole_number_in(j.at(key), 0, kMost); }

json verdict_json(const CaptureVerdict& verdict) {
  return {{"verdict", verdict_name(verdict.verdict)},
          {"faceless", verdict.faceless},
          {"remarks", remarks_json(verdict.remarks)}};
}

CaptureVerdict verdict_in(const json& j) {
  CaptureVerdict verdict{.verdict = named(j.at("verdict"), Verdict::refilm, verdict_name),
                         .faceless = j.at("faceless").get<bool>()};
  for (const json& r : j.at("remarks"))
    verdict.remarks.push_back({named(r.at("fault"), Fault::plain_background, fault_name),
                               r.at("grave").get<bool>(), seconds_in(r, "from_s"), seconds_in(r, "to_s"),
                               r.at("what").get<std::string>(), r.at("remedy").get<std::string>()});
  return verdict;
}

json camera_json(const CameraFacts& camera) {
  return {{"kind", camera.kind ? json(camera_kind_name(*camera.kind)) : json()},
          {"sure", camera.sure},
          {"stated", camera.stated},
          {"evidence", camera.evidence}};
}

CameraFacts camera_in(const json& j) {
  CameraFacts camera{.sure = j.at("sure").get<bool>(),
                     .stated = j.at("stated").get<bool>(),
                     .evidence = j.at("evidence").get<std::string>()};
  if (!j.at("kind").is_null()) camera.kind = camera_kind_named(j.at("kind").get<std::string>());
  return camera;
}

json parts_json(const PartsFacts& parts) {
  json shots = json::array();
  for (const ClipShot& s : parts.shots)
    shots.push_back({{"first", s.first},
                     {"last", s.last},
                     {"from_s", s.from_s},
                     {"to_s", s.to_s},
                     {"used", s.used},
                     {"reason", s.reason}});
  const PixelRect& f = parts.film;
  return {{"seconds", parts.seconds},
          {"faceless_s", parts.faceless_s},
          {"blurred_s", parts.blurred_s},
          {"frames", parts.frames},
          {"repeated", parts.repeated},
          {"width_px", parts.width},
          {"height_px", parts.height},
          {"film_px", {f.x, f.y, f.width, f.height}},
          {"shots", shots}};
}

PartsFacts parts_in(const json& j) {
  PartsFacts parts{.seconds = seconds_in(j, "seconds"),
                   .faceless_s = seconds_in(j, "faceless_s"),
                   .blurred_s = seconds_in(j, "blurred_s"),
                   .frames = count_in(j, "frames"),
                   .repeated = count_in(j, "repeated"),
                   .width = count_in(j, "width_px"),
                   .height = count_in(j, "height_px")};
  const json& film = j.at("film_px");
  const auto px = [&](std::size_t i) { return whole_number_in(film.at(i), 0, kMost); };
  parts.film = {px(0), px(1), px(2), px(3)};
  for (const json& s : j.at("shots"))
    parts.shots.push_back({count_in(s, "first"), count_in(s, "last"), seconds_in(s, "from_s"),
                           seconds_in(s, "to_s"), s.at("used").get<bool>(),
                           s.at("reason").get<std::string>()});
  return parts;
}

}  // namespace

json remarks_json(std::span<const Remark> remarks) {
  json list = json::array();
  for (const Remark& r : remarks)
    list.push_back({{"fault", fault_name(r.fault)},
                    {"grave", r.grave},
                    {"from_s", r.from_s},
                    {"to_s", r.to_s},
                    {"what", r.what},
                    {"remedy", r.remedy}});
  return list;
}

fs::path checked_clip_path(const fs::path& project) { return project / "check.json"; }

Result<void> write_checked_clip(const fs::path& path, const CheckedClip& checked) {
  const MaskFacts& mask = checked.facts.mask;
  const json file{
      {"version", kCheckVersion},
      {"clip_hash", checked.clip_hash},
      {"judged", verdict_json(checked.verdict)},
      {"camera", camera_json(checked.facts.camera)},
      {"mask", {{"prior", mask_prior_name(mask.prior)}, {"frames", mask.frames}, {"used", mask.used}}},
      {"parts", parts_json(checked.facts.parts)}};
  return write_text(path, json_text(file, 1) + "\n");
}

Result<CheckedClip> read_checked_clip(const fs::path& path) {
  const auto text = read_text(path);
  if (!text) return text.error();
  const auto unusable = [&](const std::string& why) {
    return Error{ErrorCode::bad_input, fmt::format("{} cannot be read: {}.", path.string(), why),
                 "Check the clip again.", path.string()};
  };
  try {
    const json j = parse_json(*text);
    if (j.at("version").get<int>() != kCheckVersion) return unusable("another version of Likeness made it");
    const json& mask = j.at("mask");
    return CheckedClip{.clip_hash = j.at("clip_hash").get<std::string>(),
                       .verdict = verdict_in(j.at("judged")),
                       .facts = {.camera = camera_in(j.at("camera")),
                                 .mask = {named(mask.at("prior"), MaskPrior::clip, mask_prior_name),
                                          count_in(mask, "frames"), count_in(mask, "used")},
                                 .parts = parts_in(j.at("parts"))}};
  } catch (const json::exception& e) {
    return unusable(e.what());
  }
}

}  // namespace likeness
