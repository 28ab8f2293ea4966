// See live_drive.h.
#include "ui/studio/live_drive.h"

#include <algorithm>
#include <utility>

#include "core/direct/beyond_seen.h"
#include "core/drive/drive.h"

namespace likeness::ui {

namespace {

constexpr double kRate_s = 2;  // over which pictures on the screen are counted

void pose(PictureRequest& request, const DrivenFrame& frame) {
  std::vector<float> attributes = std::move(request.pose.attributes);  // stay as the sliders have them
  request.pose = frame.pose;
  request.pose.attributes = std::move(attributes);
  const ViewAngle view = view_angle(request.camera.cam_from_world * frame.pose.world_from_head);
  request.origin.doubt = view_doubt(view_beyond(request.avatar->avatar, request.avatar->views, view));
}

}  // namespace

void LiveDrive::start(std::shared_ptr<const ProjectAvatar> avatar, LiveDriver::Open open,
                      LiveOptions options) {
  stop();
  avatar_ = std::move(avatar);
  sight_ = std::make_shared<Sight>();
  shown_.clear();
  latency_s_ = 0;
  options.drive.gains = gains_;
  driver_ = std::make_unique<LiveDriver>(std::move(open), avatar_subject(avatar_->avatar, *avatar_->model),
                                         std::move(options),
                                         [sight = sight_, avatar = avatar_, &renderer = renderer_](
                                             const DrivenFrame& frame, Clock::time_point captured) {
                                           const std::lock_guard lock(sight->mutex);
                                           if (!sight->on || !sight->request.avatar) return;
                                           pose(sight->request, frame);
                                           sight->posed = true;
                                           PictureRequest request = sight->request;
                                           request.moving = true;
                                           request.origin.captured = captured;
                                           renderer.request(std::move(request));
                                         });
}

std::unique_ptr<LiveDriver> LiveDrive::stop() {
  if (sight_) {
    const std::lock_guard lock(sight_->mutex);
    sight_->on = false;
  }
  if (driver_) driver_->stop();
  return std::move(driver_);
}

bool LiveDrive::has_ended() const {
  if (!driver_) return false;
  const LiveState state = driver_->status().state;
  return state == LiveState::ended || state == LiveState::failed;
}

void LiveDrive::look(PictureRequest request) {
  if (!sight_) return;
  const std::lock_guard lock(sight_->mutex);
  if (sight_->posed) {
    request.pose = sight_->request.pose;
    request.origin.doubt = sight_->request.origin.doubt;
  }
  sight_->request = request;
  request.moving = true;
  renderer_.request(std::move(request));
}

void LiveDrive::rest_now() {
  if (driver_) driver_->rest_now();
}

bool LiveDrive::toggle_recording() {
  if (!driver_) return false;
  const bool on = !driver_->status().recording;
  driver_->record(on);
  return on;
}

std::vector<DrivenFrame> LiveDrive::take_recording() {
  return driver_ ? driver_->take_recording() : std::vector<DrivenFrame>();
}

void LiveDrive::set_gains(std::map<std::string, float> gains) {
  gains_ = std::move(gains);
  if (driver_) driver_->set_gains(gains_);
}

void LiveDrive::shown(const std::shared_ptr<const AvatarPicture>& picture) {
  if (!driver_ || !picture || picture == last_shown_.lock() || !picture->origin.captured) return;
  last_shown_ = picture;
  const auto now = Clock::now();
  const auto since = [&](Clock::time_point t) { return std::chrono::duration<double>(now - t).count(); };
  latency_s_ = since(*picture->origin.captured);
  shown_.push_back(now);
  while (since(shown_.front()) > kRate_s) shown_.pop_front();
}

LiveView LiveDrive::view() const {
  LiveView view;
  view.on = on();
  view.gains = gains_;
  if (!driver_) return view;
  view.status = driver_->status();
  // Only recent pictures count: once none come any more, there are no figures.
  const auto oldest = std::ranges::lower_bound(
      shown_,
      Clock::now() - std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kRate_s)));
  if (oldest == shown_.end()) return view;
  view.latency_s = latency_s_;
  const double span = std::chrono::duration<double>(shown_.back() - *oldest).count();
  if (span > 0.2) view.shown_per_second = double(shown_.end() - oldest - 1) / span;
  return view;
}

}  // namespace likeness::ui
