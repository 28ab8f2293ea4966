// A clip carried over: see drive.h.
#include "core/drive/drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "core/drive/drive_map.h"

namespace likeness {
namespace {

// frames: of the motions.
void bridge_gaps(std::vector<DriverMotion>& motions, std::span<const TrackedFrame> frames) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < motions.size(); ++i)
    if (!motions[i].bridged) known.push_back(i);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (!motions[i].bridged) continue;
    const auto after = std::ranges::lower_bound(known, i);
    const std::size_t b = after == known.end() ? known.back() : *after;
    const std::size_t a = after == known.begin() ? known.front() : *(after - 1);
    const double span = frames[b].time_s - frames[a].time_s;
    const double t = b > a && span > 0 ? (frames[i].time_s - frames[a].time_s) / span : 0;
    motions[i] = between(motions[a], motions[b], std::clamp(t, 0.0, 1.0));
  }
}

// The frames by shots, with those of a dissolve at the end of the shot before it. Nothing is bridged or
// smoothed from one to another; a shot in which the face is lost throughout goes with its neighbour.
std::vector<std::span<const TrackedFrame>> driven_shots(const Track& track) {
  std::vector<std::span<const TrackedFrame>> shots;
  const std::span<const TrackedFrame> all = track.frames;
  const auto seen = [](const TrackedFrame& frame) { return frame.status != FrameStatus::lost; };
  std::size_t begin = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const int before = span_of(track.shots, all[i - 1].frame), now = span_of(track.shots, all[i].frame);
    if (now < 0 || now == before) continue;
    if (std::ranges::none_of(all.subspan(begin, i - begin), seen)) continue;
    if (std::ranges::none_of(all.subspan(i), seen)) break;
    shots.push_back(all.subspan(begin, i - begin));
    begin = i;
  }
  shots.push_back(all.subspan(begin));
  return shots;
}

// Each curve filtered by a binomial window of five frames (weights 1 4 6 4 1), which has no lag; the ends are
// held, and so are those of a pause: a phone may drop the frames of seconds.
std::vector<Eigen::VectorXf> without_tremor(const std::vector<Eigen::VectorXf>& courses,
                                            std::span<const TrackedFrame> frames) {
  constexpr double kPause_s = 0.25;
  const auto at = [&](std::size_t i) { return frames[i].time_s; };
  constexpr std::array kWeights{1.0f, 4.0f, 6.0f, 4.0f, 1.0f};
  const int n = int(courses.size());
  std::vector<Eigen::VectorXf> steady(courses.size());
  for (int i = 0; i < n; ++i) {
    Eigen::VectorXf sum = Eigen::VectorXf::Zero(courses[std::size_t(i)].size());
    const auto neighbour = [&](int side, int away) {
      int j = i;
      for (; away > 0 && j + side >= 0 && j + side < n; --away, j += side)
        if (std::abs(at(std::size_t(j + side)) - at(std::size_t(j))) > kPause_s) break;
      return std::size_t(j);
    };
    for (int k = 0; k < 5; ++k)
      sum += kWeights[std::size_t(k)] * courses[neighbour(k < 2 ? -1 : 1, std::abs(k - 2))];
    steady[std::size_t(i)] = sum / 16;
  }
  return steady;
}

Result<void> check(const Track& track, const DriveSubject& driver, const DriveSubject& avatar,
                   const DriveOptions& options) {
  if (track.head_model_hash != driver.model->hash) {
    return Error{ErrorCode::bad_input,
                 fmt::format("The driving track was made with the {} head model, not with the {} one.",
                             track.head_model_name, driver.model->name),
                 "Name the track's own head model, or track the clip again.", "drive"};
  }
  if (!std::ranges::all_of(track.frames, [&](const TrackedFrame& frame) {
        return frame.pose.articulation.expression.size() == driver.model->expression_count();
      })) {
    return Error{ErrorCode::bad_input, "Track, avatar and head models differ in their number of expressions.",
                 "Track the clip again, and train the avatar again if that does not help.", "drive"};
  }
  if (std::ranges::all_of(track.frames,
                          [](const TrackedFrame& f) { return f.status == FrameStatus::lost; })) {
    return Error{ErrorCode::no_face, "The face is lost in every frame of the driving track.",
                 "Use a driving clip in which the face is close and well lit.", "drive"};
  }
  return check_drive(driver, avatar, options);
}

// Adds the frames of one shot.
void drive_shot(std::span<const TrackedFrame> frames, const DriveSubject& driver, const DriveSubject& avatar,
                const DriveOptions& options, const FaceMap& face, std::vector<DrivenFrame>& driven) {
  const Vec3d driver_neck = neck_of(driver);
  std::vector<DriverMotion> motions;
  std::vector<double> steps_s;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    motions.push_back(motion_of(frames[i], driver, driver_neck));
    const double step = i > 0 ? frames[i].time_s - frames[i - 1].time_s : 0.04;
    steps_s.push_back(step > 1e-4 && step < 1 ? step : 0.04);
  }
  bridge_gaps(motions, frames);
  if (options.smooth) {
    MotionFilter filter;
    for (std::size_t i = 0; i < motions.size(); ++i)
      motions[i] = filter.next(std::move(motions[i]), steps_s[i]);
  }
  std::vector<Eigen::VectorXf> amounts;
  for (const DriverMotion& motion : motions) amounts.push_back(face.amounts(motion));
  const std::vector<Eigen::VectorXf> steady = without_tremor(amounts, frames);
  HeadMap head(driver, avatar, options);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    DrivenFrame& frame = driven.emplace_back();
    frame.frame = frames[i].frame, frame.time_s = frames[i].time_s;
    frame.bridged = motions[i].bridged;
    frame.pose.articulation = face.articulation(motions[i], amounts[i], steady[i]);
    head.place(motions[i], steps_s[i], frame);
  }
}

}  // namespace

Result<std::vector<DrivenFrame>> drive(const Track& track, const DriveSubject& driver,
                                       const DriveSubject& avatar, const DriveOptions& options) {
  if (const auto checked = check(track, driver, avatar, options); !checked) return checked.error();
  const FaceMap face(driver, avatar, options);
  std::vector<DrivenFrame> driven;
  for (const std::span<const TrackedFrame> shot : driven_shots(track))
    drive_shot(shot, driver, avatar, options, face, driven);
  return driven;
}

}  // namespace likeness
