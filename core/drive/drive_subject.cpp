// From a track or an avatar: see drive_subject.h.
#include "core/drive/drive_subject.h"

#include <algorithm>
#include <limits>

#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/render/avatar.h"
#include "core/track/fit/neutral.h"

namespace likeness {
namespace {

constexpr double kMetresPerRadian = 0.17;  // a turn of ten degrees counts as 3 cm

}  // namespace

Result<DriveSubject> subject_from_track(const Track& track, const HeadModel& model) {
  DriveSubject subject;
  subject.model = &model;
  subject.person = track.person;
  std::vector<const TrackedFrame*> frames;
  for (const TrackedFrame& frame : track.frames)
    if (frame.status != FrameStatus::lost &&
        frame.pose.articulation.expression.size() == model.expression_count())
      frames.push_back(&frame);
  if (frames.empty()) {
    return Error{ErrorCode::no_face, "The face is lost in every frame of the driving track.",
                 "Use a driving clip in which the face is close and well lit.", "drive"};
  }
  subject.neutral = track.neutral.expression.size() == model.expression_count()
                        ? track.neutral
                        : calibrate_neutral(model, track.frames, {});
  const ActionBasis basis = action_basis(model);
  std::vector<std::vector<float>> amounts(basis.actions.size());
  for (const TrackedFrame* frame : frames) {
    const Eigen::VectorXf own = action_amounts(basis, frame->pose.articulation);
    for (std::size_t a = 0; a < amounts.size(); ++a) amounts[a].push_back(own[Eigen::Index(a)]);
  }
  for (std::size_t a = 0; a < amounts.size(); ++a)
    subject.seen.push_back({basis.actions[a].name, quantile(amounts[a], 0.02), quantile(amounts[a], 0.98)});
  // Medoid of the poses, among up to 200 frames.
  const std::size_t stride = std::max<std::size_t>(1, frames.size() / 200);
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < frames.size(); i += stride) {
    double sum = 0;
    for (std::size_t j = 0; j < frames.size(); j += stride) {
      const Pose difference = inverse(frames[i]->pose.world_from_head) * frames[j]->pose.world_from_head;
      sum +=
          difference.translation().norm() + kMetresPerRadian * vector_from_turn(difference.linear()).norm();
    }
    if (sum < best) best = sum, subject.world_from_head = frames[i]->pose.world_from_head;
  }
  return subject;
}

DriveSubject avatar_subject(const Avatar& avatar, const HeadModel& model) {
  DriveSubject subject;
  subject.model = &model;
  subject.person = avatar.person;
  subject.neutral = avatar.neutral;
  for (const ActionRange& range : avatar.seen) subject.seen.push_back({range.name, range.low, range.high});
  subject.world_from_head = avatar.world_from_head;
  subject.world_from_torso = avatar.world_from_torso;
  return subject;
}

const SeenAction* find_seen(const std::vector<SeenAction>& seen, const std::string& name) {
  const auto found = std::ranges::find_if(seen, [&](const SeenAction& s) { return s.name == name; });
  return found == seen.end() ? nullptr : &*found;
}

}  // namespace likeness
