// Marks of mouth and eyes: see face_marks.h.
#include "core/lab/truth/face_marks.h"

#include <array>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

constexpr int kVersion = 1;

// Pairs of landmarks, the upper one first: of the lips, of the lids of the subject's right and left eye.
constexpr std::array<std::array<int, 2>, 3> kLips{{{61, 67}, {62, 66}, {63, 65}}};
constexpr std::array<std::array<int, 2>, 4> kLids{{{37, 41}, {38, 40}, {43, 47}, {44, 46}}};

struct Openings {
  bool known = false;
  double lips_m = 0, lids_m = 0;  // mean heights
};

template <std::size_t N>
double mean_height(const std::array<Vec3f, kLandmarkCount>& points,
                   const std::array<std::array<int, 2>, N>& pairs) {
  double sum = 0;
  for (const auto& [upper, lower] : pairs)
    sum += points[std::size_t(upper)].y() - points[std::size_t(lower)].y();
  return sum / double(N);
}

std::vector<Openings> openings(const Track& track, const HeadModel& model) {
  const HeadShape shape = shape_head(model, track.person);
  std::vector<Openings> all(track.frames.size());
  parallel_for(all.size(), [&](std::size_t i) {
    const TrackedFrame& frame = track.frames[i];
    if (frame.status == FrameStatus::lost) return;
    const auto points = landmark_positions(model, pose_head(model, shape, frame.pose.articulation));
    all[i] = {true, mean_height(points, kLips), mean_height(points, kLids)};
  });
  return all;
}

Result<std::vector<Marked>> read_letters(const nlohmann::json& letters, std::size_t count, char no,
                                         char yes) {
  const std::string text = letters.get<std::string>();
  if (text.size() != count)
    return Error{ErrorCode::bad_input, fmt::format("{} marks for {} frames.", text.size(), count),
                 "Write one letter for each frame.", ""};
  std::vector<Marked> marks;
  for (const char letter : text) {
    if (letter != no && letter != yes && letter != '?')
      return Error{ErrorCode::bad_input, fmt::format("A mark is \"{}\".", letter),
                   fmt::format("Use {}, {} or ?.", no, yes), ""};
    marks.push_back(letter == '?' ? Marked::unsure : letter == yes ? Marked::yes : Marked::no);
  }
  return marks;
}

}  // namespace

Result<std::vector<FaceMark>> read_face_marks(const std::filesystem::path& path) {
  const auto text = read_text(path);
  if (!text) return text.error();
  try {
    const nlohmann::json file = parse_json(*text);
    if (whole_number_in(file.at("version")) != kVersion)
      return Error{ErrorCode::bad_input, "The marks have another version.", "Use marks of version 1.",
                   path.string()};
    const auto frames = whole_numbers_in(file.at("frames"));
    const auto mouth = read_letters(file.at("mouth"), frames.size(), 'c', 'o');
    if (!mouth) return mouth.error();
    const auto eyes = read_letters(file.at("eyes"), frames.size(), 'o', 's');
    if (!eyes) return eyes.error();
    const auto placed =
        read_letters(file.value("placed", std::string(frames.size(), '?')), frames.size(), 'r', 'w');
    if (!placed) return placed.error();
    std::vector<FaceMark> marks;
    for (std::size_t i = 0; i < frames.size(); ++i)
      marks.push_back({frames[i], (*mouth)[i], (*eyes)[i], (*placed)[i]});
    return marks;
  } catch (const nlohmann::json::exception& e) {
    return Error{ErrorCode::bad_input, "The marks cannot be read.",
                 "Check that the file has version, frames, mouth and eyes.", path.string() + ": " + e.what()};
  }
}

MarkScore score_marks(const Track& track, const HeadModel& model, const std::vector<FaceMark>& marks) {
  const std::vector<Openings> all = openings(track, model);
  std::vector<double> lids;
  for (const Openings& o : all)
    if (o.known) lids.push_back(o.lids_m);
  const double usual = lids.empty() ? 0 : median(lids);
  MarkScore score;
  for (const FaceMark& mark : marks) {
    const TrackedFrame* frame = find_tracked(track, mark.frame);
    if (!frame) continue;
    const Openings& o = all[std::size_t(frame - track.frames.data())];
    if (mark.mouth_open != Marked::unsure) {
      ++score.mouths;
      if (!o.known || (o.lips_m > kOpenLips_m) != (mark.mouth_open == Marked::yes))
        score.wrong_mouths.push_back(mark.frame);
    }
    if (mark.eyes_shut != Marked::unsure) {
      ++score.eyes;
      if (!o.known || (o.lids_m < kShutLids * usual) != (mark.eyes_shut == Marked::yes))
        score.wrong_eyes.push_back(mark.frame);
    }
    if (mark.misplaced != Marked::unsure && frame->status == FrameStatus::good) {
      ++score.placed;
      if (mark.misplaced == Marked::yes) score.misplaced.push_back(mark.frame);
    }
  }
  return score;
}

}  // namespace likeness
