// See drive_stream.h.
#include "core/drive/drive_stream.h"

#include <optional>
#include <utility>

#include "core/drive/drive_map.h"

namespace likeness {

struct DriveStream::Impl {
  Impl(DriveSubject the_driver, DriveSubject the_avatar, DriveOptions the_options)
      : driver(std::move(the_driver)),
        avatar(std::move(the_avatar)),
        options(std::move(the_options)),
        neck(neck_of(driver)),
        calibrated(drive_gains(driver, avatar, without_gains(options))),
        face(driver, avatar, options),
        head(driver, avatar, options) {}

  static DriveOptions without_gains(DriveOptions options) {
    options.gains.clear();
    return options;
  }

  DriveSubject driver, avatar;
  DriveOptions options;
  Vec3d neck;
  std::vector<float> calibrated;  // of the avatar's actions
  FaceMap face;                   // refers to the subjects above
  HeadMap head;
  MotionFilter filter;
  std::optional<DrivenFrame> last;
};

DriveStream::DriveStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DriveStream::~DriveStream() = default;

Result<std::unique_ptr<DriveStream>> DriveStream::create(DriveSubject driver, DriveSubject avatar,
                                                         const DriveOptions& options) {
  if (const auto fine = check_drive(driver, avatar, options); !fine) return fine.error();
  auto impl = std::make_unique<Impl>(std::move(driver), std::move(avatar), options);
  return std::unique_ptr<DriveStream>(new DriveStream(std::move(impl)));
}

DrivenFrame DriveStream::next(const TrackedFrame& frame) {
  Impl& my = *impl_;
  constexpr double kUsual_s = 0.04;
  const double since = my.last ? frame.time_s - my.last->time_s : kUsual_s;
  if (frame.status == FrameStatus::lost) {
    DrivenFrame held = my.last.value_or(DrivenFrame{});
    if (!my.last) {
      held.pose.world_from_head = my.avatar.world_from_head,
      held.pose.world_from_torso = my.avatar.world_from_torso;
      held.pose.articulation = my.avatar.neutral;
    }
    held.frame = frame.frame, held.time_s = frame.time_s;
    held.bridged = true;
    return held;
  }
  const double dt = since > 1e-4 && since < 1 ? since : kUsual_s;
  const DriverMotion motion = my.filter.next(motion_of(frame, my.driver, my.neck), dt);
  const Eigen::VectorXf amounts = my.face.amounts(motion);
  DrivenFrame driven;
  driven.frame = frame.frame, driven.time_s = frame.time_s;
  driven.pose.articulation = my.face.articulation(motion, amounts, amounts);
  my.head.place(motion, dt, driven);
  my.last = driven;
  return driven;
}

Result<void> DriveStream::set_gains(const std::map<std::string, float>& gains) {
  DriveOptions options = impl_->options;
  options.gains = gains;
  if (const auto fine = check_drive(impl_->driver, impl_->avatar, options); !fine) return fine.error();
  impl_->options = options;
  std::vector<float> applied = impl_->calibrated;
  const std::vector<NamedAction>& actions = impl_->avatar.model->actions;
  for (std::size_t a = 0; a < applied.size(); ++a)
    if (const auto gain = gains.find(actions[a].name); gain != gains.end()) applied[a] *= gain->second;
  impl_->face.set_gains(std::move(applied));
  return {};
}

}  // namespace likeness
