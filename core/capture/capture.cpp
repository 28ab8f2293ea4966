// capture.json: see capture.h.
#include "core/capture/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/base/path_text.h"
#include "core/capture/split.h"

namespace likeness {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "likeness capture";
constexpr int kVersion = 1;
constexpr int kMostOfFrames = 100'000'000, kMostPixelsAlong = 1 << 16;  // along a side
constexpr double kMostOther = 1e9;                                      // of any other number

Error unreadable(const std::filesystem::path& path, std::string_view why) {
  return {ErrorCode::bad_input, fmt::format("{} is not a capture that can be read: {}.", path.string(), why),
          "Import the video again, which rewrites the file.", path.string()};
}

json to_json(const CaptureFrame& f) {
  json j = {{"frame", f.frame},       {"time_s", f.time_s}, {"sharpness", f.sharpness},
            {"held_out", f.held_out}, {"used", f.used},     {"refused", f.refused}};
  // Of one split alone: the files of others stay as they were.
  if (f.apart) j["apart"] = true;
  if (f.view) j["view"] = {{"yaw_deg", f.view->yaw_deg}, {"pitch_deg", f.view->pitch_deg}};
  return j;
}

CaptureFrame frame_from_json(const json& j) {
  CaptureFrame f;
  f.frame = whole_number_in(j.at("frame"), 0, kMostOfFrames);
  f.time_s = number_in(j.at("time_s"), -kMostOther, kMostOther);
  f.sharpness = j.at("sharpness").get<double>();
  f.held_out = j.at("held_out").get<bool>();
  f.used = j.at("used").get<bool>();
  f.refused = j.at("refused").get<std::string>();
  f.apart = j.value("apart", false);
  if (const auto view = j.find("view"); view != j.end())
    f.view = {view->at("yaw_deg").get<double>(), view->at("pitch_deg").get<double>()};
  return f;
}

json to_json(const ClipShot& s) {
  return {{"first", s.first}, {"last", s.last}, {"from_s", s.from_s},
          {"to_s", s.to_s},   {"used", s.used}, {"reason", s.reason}};
}

ClipShot shot_from_json(const json& j) {
  return {whole_number_in(j.at("first"), 0, kMostOfFrames),
          whole_number_in(j.at("last"), 0, kMostOfFrames),
          number_in(j.at("from_s"), -kMostOther, kMostOther),
          number_in(j.at("to_s"), -kMostOther, kMostOther),
          j.at("used").get<bool>(),
          j.at("reason").get<std::string>()};
}

// Files from before cuts were found say nothing of shots: they are read as one.
std::vector<ClipShot> shots_from_json(const json& j, const std::vector<CaptureFrame>& frames) {
  std::vector<ClipShot> shots;
  if (const auto own = j.find("shots"); own != j.end())
    for (const json& shot : *own) shots.push_back(shot_from_json(shot));
  if (shots.empty() && !frames.empty())
    shots.push_back({frames.front().frame, frames.back().frame, frames.front().time_s, frames.back().time_s});
  return shots;
}

json to_json(const PixelRect& r) {
  return {{"x_px", r.x}, {"y_px", r.y}, {"width_px", r.width}, {"height_px", r.height}};
}

// An absent one is empty.
PixelRect rect_from_json(const json& j, const char* key) {
  const auto at = j.find(key);
  if (at == j.end()) return {};
  // Whether it lies within its picture is asked of the whole capture.
  constexpr int kLeast = std::numeric_limits<int>::min(), kGreatest = std::numeric_limits<int>::max();
  const auto px = [&](const char* name) { return whole_number_in(at->at(name), kLeast, kGreatest); };
  return {px("x_px"), px("y_px"), px("width_px"), px("height_px")};
}

ClipSeconds seconds_from_json(const json& j) {
  const auto at = j.find("seconds");
  if (at == j.end()) return {};
  return {number_in(at->at("from_s"), 0, kMostOther), number_in(at->at("to_s"), 0, kMostOther)};
}

Capture capture_from_json(const json& j) {
  Capture c;
  c.video = path_of_text(j.at("video").get<std::string>());
  c.video_hash = j.at("video_hash").get<std::string>();
  c.width = whole_number_in(j.at("width_px"), 1, kMostPixelsAlong);
  c.height = whole_number_in(j.at("height_px"), 1, kMostPixelsAlong);
  c.frames_per_second = number_in(j.at("frames_per_second"), 0, kMostOther);
  const json& crop = j.at("crop");
  c.crop = {whole_number_in(crop.at("x_px"), -kMostPixelsAlong, kMostPixelsAlong),
            whole_number_in(crop.at("y_px"), -kMostPixelsAlong, kMostPixelsAlong),
            whole_number_in(crop.at("side_px"), -kMostPixelsAlong, kMostPixelsAlong)};
  c.size = whole_number_in(j.at("size_px"), 1, kMostPixelsAlong);
  c.film = rect_from_json(j, "film");
  c.inside = rect_from_json(j, "inside");
  const auto split = split_named(j.at("split").get<std::string>());
  if (!split) throw json::other_error::create(501, "there is no such split", &j.at("split"));
  c.split = *split;
  if (const auto sides = j.find("sides"); sides != j.end())
    c.sides = {sides->at("inside_deg").get<double>(), sides->at("beyond_deg").get<double>()};
  c.seconds = seconds_from_json(j);
  c.warnings = j.at("warnings").get<std::vector<std::string>>();
  for (const json& frame : j.at("frames")) c.frames.push_back(frame_from_json(frame));
  c.shots = shots_from_json(j, c.frames);
  return c;
}

// Or is absent.
bool lies_within(const PixelRect& part, int width, int height) {
  return part == PixelRect{} || (!part.empty() && part.x >= 0 && part.y >= 0 &&
                                 part.width <= width - part.x && part.height <= height - part.y);
}

// What later stages rely on without checking again; empty when all is well.
std::string contradiction(const Capture& c) {
  if (c.crop.side <= 0) return "a size in it is not positive";
  if (common_part({c.crop.x, c.crop.y, c.crop.side, c.crop.side}, {0, 0, c.width, c.height}).empty() ||
      c.crop.side > 4 * std::max(c.width, c.height))
    return "what was cut out does not lie in its picture";
  if (!lies_within(c.film, c.width, c.height)) return "the film does not lie in its picture";
  if (!lies_within(c.inside, c.size, c.size)) return "the filmed part of its pictures does not lie in them";
  if (c.seconds.from_s < 0 || c.seconds.to_s < 0 ||
      (c.seconds.to_s > 0 && c.seconds.to_s <= c.seconds.from_s))
    return "its seconds end before they begin";
  for (std::size_t i = 0; i < c.frames.size(); ++i) {
    if (c.frames[i].frame < 0 || (i > 0 && c.frames[i].frame <= c.frames[i - 1].frame)) {
      return "its frames are not in ascending order";
    }
    if (c.frames[i].held_out && c.frames[i].used) return "a frame is both held out and used";
    if (c.frames[i].apart && (c.frames[i].held_out || c.frames[i].used))
      return "a frame that is kept apart is held out or used";
  }
  for (std::size_t i = 0; i < c.shots.size(); ++i)
    if (c.shots[i].first > c.shots[i].last || (i > 0 && c.shots[i].first <= c.shots[i - 1].last))
      return "its shots are not in ascending order";
  return {};
}

}  // namespace

double angle_deg(const HeadView& view) {
  constexpr double kDegree = std::numbers::pi / 180;
  return std::acos(std::cos(kDegree * view.yaw_deg) * std::cos(kDegree * view.pitch_deg)) / kDegree;
}

double time_of_frame(const Capture& capture, int frame) {
  const auto at = std::ranges::lower_bound(capture.frames, frame, {}, &CaptureFrame::frame);
  if (at != capture.frames.end() && at->frame == frame) return at->time_s;
  return frame / std::max(1.0, capture.frames_per_second);
}

std::set<int> held_out_frames(const Capture& capture) {
  std::set<int> numbers;
  for (const CaptureFrame& frame : capture.frames) {
    if (frame.held_out) numbers.insert(frame.frame);
  }
  return numbers;
}

std::set<int> silent_frames(const Capture& capture) {
  std::set<int> numbers = held_out_frames(capture);
  for (const CaptureFrame& frame : capture.frames) {
    if (frame.apart) numbers.insert(frame.frame);
  }
  return numbers;
}

namespace {

// Those of the used shots; empty where they are the whole clip.
std::vector<FrameSpan> used_spans(const Capture& capture, bool joined) {
  std::vector<FrameSpan> spans;
  std::size_t after = 0;  // index of the frame behind the last span
  for (const ClipShot& shot : capture.shots) {
    if (!shot.used) continue;
    const auto first = std::ranges::lower_bound(capture.frames, shot.first, {}, &CaptureFrame::frame);
    const bool follows = !spans.empty() && after == std::size_t(first - capture.frames.begin());
    if (joined && follows)
      spans.back().last = shot.last;
    else
      spans.push_back({shot.first, shot.last});
    after = std::size_t(std::ranges::upper_bound(capture.frames, shot.last, {}, &CaptureFrame::frame) -
                        capture.frames.begin());
  }
  if (capture.seconds.whole() && spans.size() == 1 && !capture.frames.empty() &&
      spans[0].first <= capture.frames.front().frame && spans[0].last >= capture.frames.back().frame)
    spans.clear();
  return spans;
}

}  // namespace

std::optional<FrameSpan> frames_of_seconds(const Capture& capture) {
  if (capture.seconds.whole() || capture.frames.empty()) return std::nullopt;
  return FrameSpan{capture.frames.front().frame, capture.frames.back().frame};
}

std::vector<FrameSpan> spans_where_cut(const Capture& capture) { return used_spans(capture, false); }
std::vector<FrameSpan> stretches_that_serve(const Capture& capture) { return used_spans(capture, true); }
PixelRect tracked_part(const Capture& capture) {
  const PixelRect square{capture.crop.x, capture.crop.y, capture.crop.side, capture.crop.side};
  return capture.film.empty() ? square : common_part(square, capture.film);
}

PixelRect filmed_part(const SquareCrop& crop, const PixelRect& film, int size) {
  const PixelRect whole{crop.x, crop.y, crop.side, crop.side}, part = common_part(whole, film);
  if (part == whole) return {};
  return resampled({part.x - crop.x, part.y - crop.y, part.width, part.height}, crop.side, size);
}

std::filesystem::path frame_name(int frame) {
  return std::filesystem::path("frames") / fmt::format("{:06}.png", frame);
}

std::filesystem::path alpha_name(int frame) {
  return std::filesystem::path("frames") / fmt::format("{:06}.alpha.png", frame);
}

Result<void> write_capture(const std::filesystem::path& path, const Capture& capture) {
  json frames = json::array();
  for (const CaptureFrame& frame : capture.frames) frames.push_back(to_json(frame));
  json shots = json::array();
  for (const ClipShot& shot : capture.shots) shots.push_back(to_json(shot));
  json document = {
      {"format", kFormat},
      {"version", kVersion},
      {"video", text_of_path(capture.video)},
      {"video_hash", capture.video_hash},
      {"width_px", capture.width},
      {"height_px", capture.height},
      {"frames_per_second", capture.frames_per_second},
      {"crop", {{"x_px", capture.crop.x}, {"y_px", capture.crop.y}, {"side_px", capture.crop.side}}},
      {"size_px", capture.size},
      {"split", split_name(capture.split)},
      {"warnings", capture.warnings},
      {"shots", shots},
      {"frames", frames}};
  if (capture.split == Split::sides)
    document["sides"] = {{"inside_deg", capture.sides.inside_deg}, {"beyond_deg", capture.sides.beyond_deg}};
  if (!capture.seconds.whole())
    document["seconds"] = {{"from_s", capture.seconds.from_s}, {"to_s", capture.seconds.to_s}};
  if (!capture.film.empty()) document["film"] = to_json(capture.film);
  if (!capture.inside.empty()) document["inside"] = to_json(capture.inside);
  return write_text(path, json_text(document, 1) + "\n");
}

Result<Capture> read_capture(const std::filesystem::path& path) {
  const auto text = read_text(path);
  if (!text) return text.error();
  try {
    const json document = parse_json(*text);
    if (document.value("format", "") != kFormat) return unreadable(path, "it is some other kind of file");
    if (const int version = whole_number_in(document.at("version")); version != kVersion) {
      return unreadable(path, fmt::format("it has version {}, and this program knows {}", version, kVersion));
    }
    Capture capture = capture_from_json(document);
    if (const std::string fault = contradiction(capture); !fault.empty()) return unreadable(path, fault);
    return capture;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return unreadable(path, e.what());
  }
}

}  // namespace likeness
