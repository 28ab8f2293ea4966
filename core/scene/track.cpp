// track.json: every number is written so that it reads back to the same bits.
#include "core/scene/track.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"

namespace likeness {
namespace {

using nlohmann::json;
constexpr int kVersion = 2;
// Metres, seconds, pixels and standard deviations all stay far below; a head's numbers, far below a thousand.
constexpr double kMost = 1e9, kMostOfHead = 1e3;

const char* status_name(FrameStatus status) {
  switch (status) {
    case FrameStatus::good:
      return "good";
    case FrameStatus::weak:
      return "weak";
    case FrameStatus::lost:
      return "lost";
  }
  return "lost";
}

FrameStatus status_from(const std::string& name) {
  if (name == "good") return FrameStatus::good;
  if (name == "weak") return FrameStatus::weak;
  if (name == "lost") return FrameStatus::lost;
  throw std::runtime_error("unknown status '" + name + "'");
}

json pose_json(const Pose& pose) {
  json values = json::array();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) values.push_back(pose.matrix()(r, c));
  return values;
}

Pose pose_from(const json& values) {
  if (!values.is_array() || values.size() != 12) throw std::runtime_error("a pose needs 12 numbers");
  Pose pose = Pose::Identity();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) pose.matrix()(r, c) = number_in(values[r * 4 + c], -kMost, kMost);
  const Mat3d turn = pose.linear();
  if (!pose.matrix().allFinite() || (turn * turn.transpose() - Mat3d::Identity()).norm() > 1e-3 ||
      turn.determinant() < 0)
    throw std::runtime_error("a pose is not a rigid transform");
  return pose;
}

template <class Vector>
json vector_json(const Vector& v) {
  json values = json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) values.push_back(v[i]);
  return values;
}

float head_number(const json& value) { return float(number_in(value, -kMostOfHead, kMostOfHead)); }

Eigen::VectorXf vector_from(const json& values) {
  Eigen::VectorXf v(static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) v[static_cast<Eigen::Index>(i)] = head_number(values[i]);
  return v;
}

Vec3f vec3_from(const json& values) {
  if (!values.is_array() || values.size() != 3) throw std::runtime_error("a rotation needs 3 numbers");
  return {head_number(values[0]), head_number(values[1]), head_number(values[2])};
}

json articulation_json(const Articulation& a) {
  return {{"expression", vector_json(a.expression)},
          {"neck", vector_json(a.neck)},
          {"jaw", vector_json(a.jaw)},
          {"left_eye", vector_json(a.left_eye)},
          {"right_eye", vector_json(a.right_eye)}};
}

Articulation articulation_from(const json& j) {
  Articulation a;
  a.expression = vector_from(j.at("expression"));
  a.neck = vec3_from(j.at("neck"));
  a.jaw = vec3_from(j.at("jaw"));
  a.left_eye = vec3_from(j.at("left_eye"));
  a.right_eye = vec3_from(j.at("right_eye"));
  return a;
}

bool is_finite(const Articulation& a) {
  return a.expression.allFinite() && a.neck.allFinite() && a.jaw.allFinite() && a.left_eye.allFinite() &&
         a.right_eye.allFinite();
}

// Offsets as one flat list, (3V).
json offsets_json(const std::vector<Vec3f>& offsets) {
  json values = json::array();
  for (const Vec3f& v : offsets)
    for (int k = 0; k < 3; ++k) values.push_back(v[k]);
  return values;
}

std::vector<Vec3f> offsets_from(const json& values) {
  if (!values.is_array() || values.size() % 3 != 0)
    throw std::runtime_error("the personal shape needs 3 numbers a vertex");
  std::vector<Vec3f> offsets(values.size() / 3);
  for (std::size_t i = 0; i < values.size(); ++i)
    offsets[i / 3][Eigen::Index(i % 3)] = head_number(values[i]);
  return offsets;
}

json torso_modes_json(const TorsoModes& m) {
  if (m.empty()) return nullptr;
  return {{"origin_m", {m.grid.origin.x(), m.grid.origin.y()}},
          {"cell_m", m.grid.cell},
          {"columns", m.grid.columns},
          {"rows", m.grid.rows},
          {"mean_m", m.mean},
          {"modes_m", m.modes}};
}

TorsoModes torso_modes_from(const json& j) {
  TorsoModes m;
  if (j.is_null()) return m;
  m.grid.origin = {j.at("origin_m").at(0).get<float>(), j.at("origin_m").at(1).get<float>()};
  m.grid.cell = j.at("cell_m").get<float>();
  m.grid.columns = whole_number_in(j.at("columns")), m.grid.rows = whole_number_in(j.at("rows"));
  m.mean = numbers_in(j.at("mean_m"));
  if (!take_modes(j.at("modes_m").get<std::vector<std::vector<float>>>(), m) || !is_consistent(m))
    throw std::runtime_error("the torso's modes do not match their grid");
  return m;
}

json frame_json(const TrackedFrame& f) {
  json points = json::array();
  for (const Vec2d& p : f.landmarks) points.push_back({p.x(), p.y()});
  json frame = articulation_json(f.pose.articulation);
  frame.update({{"frame", f.frame},
                {"time_s", f.time_s},
                {"status", status_name(f.status)},
                {"reason", f.reason},
                {"world_from_head", pose_json(f.pose.world_from_head)},
                {"world_from_torso", pose_json(f.pose.world_from_torso)},
                {"torso_shape", f.pose.torso_shape},
                {"landmarks", std::move(points)},
                {"landmark_spread", f.landmark_spread},
                {"look", f.look},
                {"inner_error_px", f.inner_error_px}});
  return frame;
}

json rest_json(const RestChoice& rest) {
  return {{"frames", rest.frames},
          {"asked", rest.asked},
          {"trust", rest.trust},
          {"why", rest.why},
          {"warning", rest.warning}};
}

RestChoice rest_from(const json& j) {
  RestChoice rest{whole_numbers_in(j.at("frames")), j.at("asked").get<bool>(), j.at("trust").get<double>(),
                  j.at("why").get<std::string>(), j.at("warning").get<std::string>()};
  if (!std::isfinite(rest.trust)) throw std::runtime_error("the rest's trust is not a number");
  return rest;
}

json shots_json(const std::vector<FrameSpan>& shots) {
  json out = json::array();
  for (const FrameSpan& shot : shots) out.push_back({shot.first, shot.last});
  return out;
}

// Only of clips that were cut.
std::vector<FrameSpan> shots_from(const json& j) {
  std::vector<FrameSpan> shots;
  if (!j.contains("shots")) return shots;
  for (const json& shot : j.at("shots")) {
    shots.push_back({whole_number_in(shot.at(0)), whole_number_in(shot.at(1))});
    const FrameSpan& own = shots.back();
    if (own.first > own.last || (shots.size() > 1 && own.first <= shots[shots.size() - 2].last))
      throw std::runtime_error("its shots are not in ascending order");
  }
  return shots;
}

TrackedFrame frame_from(const json& j) {
  TrackedFrame f;
  f.frame = whole_number_in(j.at("frame"), 0, 100'000'000);
  f.time_s = number_in(j.at("time_s"), -kMost, kMost);
  f.status = status_from(j.at("status").get<std::string>());
  f.reason = j.at("reason").get<std::string>();
  f.pose.world_from_head = pose_from(j.at("world_from_head"));
  f.pose.world_from_torso = pose_from(j.at("world_from_torso"));
  if (j.contains("torso_shape")) {
    const auto shape = take_shape(numbers_in(j.at("torso_shape")));
    if (!shape || !std::ranges::all_of(*shape, [](float s) { return std::abs(s) <= kMostOfHead; }))
      throw std::runtime_error("a torso's shape has too many or too large numbers");
    f.pose.torso_shape = *shape;
  }
  f.pose.articulation = articulation_from(j);
  const json& points = j.at("landmarks");
  if (points.size() != kLandmarkCount) throw std::runtime_error("a frame needs 68 landmarks");
  for (int i = 0; i < kLandmarkCount; ++i)
    f.landmarks[i] =
        Vec2d(number_in(points[i].at(0), -kMost, kMost), number_in(points[i].at(1), -kMost, kMost));
  f.look = j.value("look", 1.0);
  if (j.contains("landmark_spread"))
    f.landmark_spread = j.at("landmark_spread").get<decltype(f.landmark_spread)>();
  f.inner_error_px = j.at("inner_error_px").get<double>();
  return f;
}

}  // namespace

const TrackedFrame* find_tracked(const Track& track, int frame) {
  const auto it = std::lower_bound(track.frames.begin(), track.frames.end(), frame,
                                   [](const TrackedFrame& f, int number) { return f.frame < number; });
  return it != track.frames.end() && it->frame == frame ? &*it : nullptr;
}

Result<void> write_track(const std::filesystem::path& path, const Track& track) {
  json head = {{"format", "likeness-track"},
               {"version", kVersion},
               {"units",
                "metres, radians, seconds; landmarks in pixels of the uncropped source picture; poses "
                "are row-major 3x4; rotations are rotation vectors"},
               {"head_model_name", track.head_model_name},
               {"head_model_hash", track.head_model_hash},
               {"head_model_file", track.head_model_file},
               {"identity", vector_json(track.person.identity)},
               {"neutral", articulation_json(track.neutral)},
               {"rest", rest_json(track.rest)},
               {"has_torso", track.has_torso},
               {"torso_modes", torso_modes_json(track.torso_modes)},
               {"metres_per_unit", track.metres_per_unit},
               {"metre_known", track.metre_known}};
  if (!track.shots.empty()) head["shots"] = shots_json(track.shots);
  for (const TrackedFrame& f : track.frames) {
    bool finite = f.pose.world_from_head.matrix().allFinite() &&
                  f.pose.world_from_torso.matrix().allFinite() && is_finite(f.pose.articulation) &&
                  std::isfinite(f.inner_error_px) && std::isfinite(f.look) && std::isfinite(f.time_s);
    for (float s : f.pose.torso_shape) finite = finite && std::isfinite(s);
    for (double d : f.landmark_spread) finite = finite && std::isfinite(d);
    for (const Vec2d& p : f.landmarks) finite = finite && p.allFinite();
    if (!finite)
      return Error{ErrorCode::failed,
                   "Frame " + std::to_string(f.frame) + " of the track holds a number that is not finite.",
                   "Run the fit again; if it fails again, leave this frame out.", path.string()};
  }
  // One line a frame: readable, and a difference between two tracks shows the frames that differ.
  std::string text;
  try {
    text = json_text(head, 1);
    text.erase(text.find_last_of('}'));
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    text += ",\n \"offsets\": " + json_text(offsets_json(track.person.offsets));
    text += ",\n \"frames\": [";
    for (std::size_t i = 0; i < track.frames.size(); ++i)
      text += (i ? ",\n  " : "\n  ") + json_text(frame_json(track.frames[i]));
    text += "\n ]\n}\n";
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return Error{ErrorCode::failed, "The track could not be written as text: " + std::string(e.what()),
                 "Run the fit again.", path.string()};
  }
  return write_text(path, text);
}

Result<Track> read_track(const std::filesystem::path& path) {
  auto text = read_text(path);
  if (!text) return text.error();
  try {
    const json j = parse_json(*text);
    if (j.value("format", "") != "likeness-track")
      return Error{ErrorCode::bad_input, "This file is not a track.", "Run the fit again to rewrite it.",
                   path.string()};
    if (whole_number_in(j.at("version")) != kVersion)
      return Error{ErrorCode::bad_input,
                   "The track has version " + std::to_string(whole_number_in(j.at("version"))) +
                       "; version " + std::to_string(kVersion) + " is understood.",
                   "Run the fit again with this version of Likeness.", path.string()};
    Track track;
    track.head_model_name = j.at("head_model_name").get<std::string>();
    track.head_model_hash = j.at("head_model_hash").get<std::string>();
    track.head_model_file = j.at("head_model_file").get<std::string>();
    track.person.identity = vector_from(j.at("identity"));
    track.person.offsets = offsets_from(j.at("offsets"));
    track.neutral = articulation_from(j.at("neutral"));
    if (j.contains("rest")) track.rest = rest_from(j.at("rest"));
    track.has_torso = j.at("has_torso").get<bool>();
    if (j.contains("torso_modes")) track.torso_modes = torso_modes_from(j.at("torso_modes"));
    track.metres_per_unit = number_in(j.at("metres_per_unit"), -kMost, kMost);
    track.metre_known = j.value("metre_known", true);
    track.shots = shots_from(j);
    for (const json& f : j.at("frames")) {
      track.frames.push_back(frame_from(f));
      if (track.frames.size() > 1 && track.frames[track.frames.size() - 2].frame >= track.frames.back().frame)
        throw std::runtime_error("the frames are not in ascending order");
    }
    return track;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return Error{ErrorCode::bad_input, "The track could not be read: " + std::string(e.what()),
                 "Run the fit again to rewrite it.", path.string()};
  }
}

}  // namespace likeness
