// A clip carried over: see drive.h.
#include "core/drive/drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/drive/drive_map.h"

namespace likeness {
namespace {

void bridge_gaps(std::vector<DriverMotion>& motions, const Track& track) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < motions.size(); ++i)
    if (!motions[i].bridged) known.push_back(i);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (!motions[i].bridged) continue;
    const auto after = std::ranges::lower_bound(known, i);
    const std::size_t b = after == known.end() ? known.back() : *after;
    const std::size_t a = after == known.begin() ? known.front() : *(after - 1);
    const double span = track.frames[b].time_s - track.frames[a].time_s;
    const double t = b > a && span > 0 ? (track.frames[i].time_s - track.frames[a].time_s) / span : 0;
    motions[i] = between(motions[a], motions[b], std::clamp(t, 0.0, 1.0));
  }
}

// Each curve filtered by a binomial window of five frames (weights 1 4 6 4 1), which has no lag; the ends are
// held.
std::vector<Eigen::VectorXf> without_tremor(const std::vector<Eigen::VectorXf>& courses) {
  constexpr std::array kWeights{1.0f, 4.0f, 6.0f, 4.0f, 1.0f};
  const int n = int(courses.size());
  std::vector<Eigen::VectorXf> steady(courses.size());
  for (int i = 0; i < n; ++i) {
    Eigen::VectorXf sum = Eigen::VectorXf::Zero(courses[std::size_t(i)].size());
    for (int k = 0; k < 5; ++k)
      sum += kWeights[std::size_t(k)] * courses[std::size_t(std::clamp(i + k - 2, 0, n - 1))];
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

}  // namespace

Result<std::vector<DrivenFrame>> drive(const Track& track, const DriveSubject& driver,
                                       const DriveSubject& avatar, const DriveOptions& options) {
  if (const auto checked = check(track, driver, avatar, options); !checked) return checked.error();
  const Vec3d driver_neck = neck_of(driver);
  std::vector<DriverMotion> motions;
  std::vector<double> steps_s;
  for (std::size_t i = 0; i < track.frames.size(); ++i) {
    motions.push_back(motion_of(track.frames[i], driver, driver_neck));
    const double step = i > 0 ? track.frames[i].time_s - track.frames[i - 1].time_s : 0.04;
    steps_s.push_back(step > 1e-4 && step < 1 ? step : 0.04);
  }
  bridge_gaps(motions, track);
  if (options.smooth) {
    MotionFilter filter;
    for (std::size_t i = 0; i < motions.size(); ++i)
      motions[i] = filter.next(std::move(motions[i]), steps_s[i]);
  }

  const FaceMap face(driver, avatar, options);
  std::vector<Eigen::VectorXf> amounts;
  for (const DriverMotion& motion : motions) amounts.push_back(face.amounts(motion));
  const std::vector<Eigen::VectorXf> steady = without_tremor(amounts);
  HeadMap head(driver, avatar, options);
  std::vector<DrivenFrame> driven;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    DrivenFrame frame;
    frame.frame = track.frames[i].frame, frame.time_s = track.frames[i].time_s;
    frame.bridged = motions[i].bridged;
    frame.pose.articulation = face.articulation(motions[i], amounts[i], steady[i]);
    head.place(motions[i], steps_s[i], frame);
    driven.push_back(std::move(frame));
  }
  return driven;
}

}  // namespace likeness
