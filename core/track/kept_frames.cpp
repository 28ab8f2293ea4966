// Pictures in one file, what was found in them in another: see kept_frames.h.
#include "core/track/kept_frames.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/json_text.h"
#include "core/face/landmarks.h"
#include "core/video/decode.h"
#include "core/video/grey_pictures.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

using nlohmann::json;

// Raised when faces or landmarks are found otherwise.
constexpr int kFoundVersion = 1;

fs::path pictures_path(const fs::path& folder) { return folder / "track.greys"; }
fs::path found_path(const fs::path& folder) { return folder / "landmarks.json"; }

json box_json(const FaceBox& b) { return {b.x, b.y, b.width, b.height, b.score}; }

FaceBox box_from(const json& j) {
  return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>(), j.at(3).get<double>(),
          j.at(4).get<double>()};
}

// x, y and spread of each point.
json landmarks_json(const Landmarks& landmarks) {
  json points = json::array();
  for (int k = 0; k < kLandmarkCount; ++k) {
    points.push_back(landmarks.points[k].x());
    points.push_back(landmarks.points[k].y());
    points.push_back(landmarks.spread[k]);
  }
  return {{"points", points}, {"share", landmarks.cluster_share}, {"runs", landmarks.runs}};
}

Landmarks landmarks_from(const json& j) {
  Landmarks landmarks;
  const json& points = j.at("points");
  for (int k = 0; k < kLandmarkCount; ++k) {
    const auto at = std::size_t(3 * k);
    landmarks.points[k] = {points.at(at).get<double>(), points.at(at + 1).get<double>()};
    landmarks.spread[k] = points.at(at + 2).get<double>();
  }
  landmarks.cluster_share = j.at("share").get<double>();
  landmarks.runs = whole_number_in(j.at("runs"));
  return landmarks;
}

json frame_json(const ClipFrame& f) {
  json j = {{"frame", f.frame},     {"time_s", f.time_s}, {"held_out", f.held_out}, {"detected", f.detected},
            {"scanned", f.scanned}, {"rival", f.rival},   {"box", box_json(f.box)}};
  if (f.shot != 0) j["shot"] = f.shot;
  if (f.landmarks) j["landmarks"] = landmarks_json(*f.landmarks);
  return j;
}

ClipFrame frame_from(const json& j) {
  ClipFrame f;
  f.frame = whole_number_in(j.at("frame"));
  f.time_s = j.at("time_s").get<double>();
  f.held_out = j.at("held_out").get<bool>();
  f.shot = j.value("shot", 0);
  f.detected = j.at("detected").get<bool>();
  f.scanned = j.at("scanned").get<bool>();
  f.rival = j.at("rival").get<bool>();
  f.box = box_from(j.at("box"));
  if (j.contains("landmarks")) f.landmarks = landmarks_from(j.at("landmarks"));
  return f;
}

}  // namespace

Result<std::string> clip_frames_inputs(const std::string& video_hash, const TrackRegion& region,
                                       const std::set<int>& held_out, const TrackOptions& options) {
  std::string predictor = landmark_source_hash(options.predictor);
  if (predictor == "absent") return hash_file(options.predictor).error();
  if (predictor.empty()) predictor = "the system's";
  std::string inputs = fmt::format("landmarks {} {} {},{} {}x{} {} {} held out {}", kFoundVersion, video_hash,
                                   region.x, region.y, region.width, region.height, options.working_size,
                                   predictor, fmt::join(held_out, ","));
  if (options.part) inputs += fmt::format(" part {}-{}", options.part->first, options.part->last);
  if (!options.shots.empty()) inputs += " shots";
  for (const FrameSpan& shot : options.shots) inputs += fmt::format(" {}-{}", shot.first, shot.last);
  return inputs;
}

struct ClipFrameKeeper::State {
  fs::path folder;
  std::string inputs;
  std::vector<int> frames;
  ClipFollower follower;
  std::optional<GreyPictureWriter> pictures;  // from the first frame on, which has their size
};

ClipFrameKeeper::ClipFrameKeeper(std::unique_ptr<State> state) : state_(std::move(state)) {}
ClipFrameKeeper::~ClipFrameKeeper() = default;
ClipFrameKeeper::ClipFrameKeeper(ClipFrameKeeper&&) noexcept = default;
ClipFrameKeeper& ClipFrameKeeper::operator=(ClipFrameKeeper&&) noexcept = default;

Result<ClipFrameKeeper> ClipFrameKeeper::create(const fs::path& folder, const std::string& inputs,
                                                ClipFollower follower, const std::vector<int>& frames) {
  return ClipFrameKeeper(
      std::unique_ptr<State>(new State{folder, inputs, frames, std::move(follower), std::nullopt}));
}

Result<void> ClipFrameKeeper::add(const VideoFrame& frame, const std::stop_token& stop) {
  State& s = *state_;
  s.follower.add(frame, stop);
  const Image8 grey = s.follower.take_grey();
  if (!s.pictures) {
    auto created =
        GreyPictureWriter::create(pictures_path(s.folder), {s.inputs, grey.width, grey.height, s.frames});
    if (!created) return created.error();
    s.pictures = std::move(*created);
  }
  return s.pictures->add(grey);
}

Result<void> ClipFrameKeeper::finish(const std::stop_token& stop) {
  State& s = *state_;
  const auto clip = s.follower.finish(stop);
  if (!clip) return clip.error();
  if (clip->frames.size() != s.frames.size())
    return Error{ErrorCode::failed, "The video changed while it was being read.",
                 "Run it again once nothing else writes to it.", s.folder.string()};
  if (auto whole = s.pictures->finish(); !whole) return whole;
  json frames = json::array();
  for (const ClipFrame& frame : clip->frames) frames.push_back(frame_json(frame));
  const TrackRegion& region = clip->region;
  const json document = {{"inputs", s.inputs},
                         {"region", {region.x, region.y, region.width, region.height}},
                         {"scale", clip->scale},
                         {"frames", frames}};
  return write_text(found_path(s.folder), json_text(document) + "\n");
}

std::uint64_t kept_clip_bytes(std::size_t frames, const TrackOptions& options) {
  return std::uint64_t(frames) * std::uint64_t(options.working_size) * std::uint64_t(options.working_size);
}

std::optional<ClipFrames> kept_clip_frames(const fs::path& folder, const std::string& inputs) {
  const auto text = read_text(found_path(folder));
  if (!text) return std::nullopt;
  auto pictures = GreyPictureReader::open(pictures_path(folder));
  if (!pictures || pictures->about().inputs != inputs) return std::nullopt;
  try {
    const json document = parse_json(*text);
    if (document.at("inputs") != inputs) return std::nullopt;
    ClipFrames clip;
    const json& region = document.at("region");
    clip.region = {whole_number_in(region.at(0)), whole_number_in(region.at(1)),
                   whole_number_in(region.at(2)), whole_number_in(region.at(3))};
    clip.scale = document.at("scale").get<double>();
    for (const json& frame : document.at("frames")) clip.frames.push_back(frame_from(frame));
    const std::vector<int>& numbers = pictures->about().frames;
    if (clip.frames.empty() || clip.frames.size() != numbers.size()) return std::nullopt;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      auto grey = pictures->next();
      if (!grey || clip.frames[i].frame != numbers[i]) return std::nullopt;
      clip.frames[i].grey = std::move(*grey);
    }
    return clip;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

void drop_clip_frames(const fs::path& folder) {
  std::error_code ignored;
  fs::remove(found_path(folder), ignored);
  fs::remove(pictures_path(folder), ignored);
}

}  // namespace likeness
