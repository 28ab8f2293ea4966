// Channels to poses and back: see direct_avatar.h.
#include "core/direct/direct_avatar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/rigid.h"
#include "core/head/action_amounts.h"
#include "core/head/pose_head.h"
#include "core/render/camera_path.h"

namespace likeness {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr float kNearest = 0.2f, kFarthest = 5;   // times the typical distance
constexpr float kWidest = 0.1f, kNarrowest = 20;  // times the typical focal length

// One eye's look along one axis: by its named action, which also moves the lids, if the model has one.
void add_look(Articulation& articulation, const HeadModel& model, const std::string& action_name, bool left,
              const Vec3f& turn) {
  const float angle = turn.norm();
  if (angle == 0) return;
  const NamedAction* action = find_action(model, action_name);
  const Vec3f full = !action ? Vec3f(Vec3f::Zero()) : left ? action->left_eye : action->right_eye;
  if (full.dot(turn) > 0.99f * full.norm() * angle) {
    add_action(articulation, *action, angle / full.norm());
  } else {
    (left ? articulation.left_eye : articulation.right_eye) += turn;
  }
}

// yaw to the subject's left, pitch up; rad.
void add_gaze(Articulation& articulation, const HeadModel& model, float yaw, float pitch) {
  for (const bool left : {true, false}) {
    const std::string side = left ? "_L" : "_R";
    add_look(articulation, model, ((yaw > 0) == left ? "eyeLookOut" : "eyeLookIn") + side, left, {0, yaw, 0});
    add_look(articulation, model, (pitch > 0 ? "eyeLookUp" : "eyeLookDown") + side, left, {-pitch, 0, 0});
  }
}

// The part of a shift that the neck alone takes, m.
Vec3d within_reach(const Vec3d& shift) {
  const double reach = DriveOptions{}.reach_m, length = shift.norm();
  return length > 1e-9 ? Vec3d(shift * (reach * std::tanh(length / reach) / length)) : shift;
}

Camera directed_camera(const DirectedAvatar& directed, const ViewPoint& view) {
  const Avatar& avatar = *directed.avatar;
  Camera camera = orbit_camera(avatar, avatar.world_from_head, view.yaw, view.pitch);
  const Vec3d centre = camera.cam_from_world * (avatar.world_from_head * directed.centre);
  camera.cam_from_world.pretranslate(double(std::clamp(view.distance, kNearest, kFarthest) - 1) * centre);
  Intrinsics& k = camera.intrinsics;
  const double zoom = double(std::clamp(view.zoom, kWidest, kNarrowest));
  k.fx *= zoom, k.fy *= zoom;
  k.cx = k.width * (0.5 + double(view.shift_x)) + (k.cx - 0.5 * k.width) * zoom;
  k.cy = k.height * 0.5 + k.width * double(view.shift_y) + (k.cy - 0.5 * k.height) * zoom;
  return camera;
}

// Yaw, pitch and roll of turned_head, degrees.
std::array<float, 3> turn_degrees(const Mat3d& r) {
  const double yaw = std::atan2(r(0, 2), r(2, 2)), pitch = std::asin(std::clamp(-r(1, 2), -1.0, 1.0)),
               roll = std::atan2(r(1, 0), r(1, 1));
  return {float(yaw / kRadians), float(pitch / kRadians), float(roll / kRadians)};
}

// Values of the channels of one driven frame, followed by those of the actions in the basis's order.
std::vector<float> channel_values(const DrivenFrame& frame, const DirectedAvatar& directed,
                                  const ActionBasis& basis) {
  const Avatar& avatar = *directed.avatar;
  const Pose motion = inverse(avatar.world_from_head) * frame.pose.world_from_head;
  const Vec3d shift = motion.translation() - (directed.neck - motion.linear() * directed.neck);
  const auto turn = turn_degrees(motion.linear());
  const Articulation &face = frame.pose.articulation, &rest = avatar.neutral;
  const Vec3f look = 0.5f * (face.left_eye - rest.left_eye + face.right_eye - rest.right_eye);
  Articulation gaze = rest;
  add_gaze(gaze, *directed.model, look.y(), -look.x());
  Articulation change = neutral_articulation(*directed.model);
  change.expression = face.expression - gaze.expression;
  change.jaw = face.jaw - gaze.jaw;
  std::vector<float> values{turn[0],
                            turn[1],
                            turn[2],
                            float(shift.x()),
                            float(shift.y()),
                            float(shift.z()),
                            look.y() / float(kRadians),
                            -look.x() / float(kRadians)};
  const Eigen::VectorXf amounts = face_amounts(basis, change);
  for (Eigen::Index a = 0; a < amounts.size(); ++a) {
    const NamedAction& action = basis.actions[std::size_t(a)];
    values.push_back(action.left_eye.isZero() && action.right_eye.isZero() ? amounts[a] : 0);
  }
  return values;
}

}  // namespace

DirectedAvatar direct_avatar(const Avatar& avatar, const HeadModel& model) {
  return {&avatar, &model, shape_head(model, avatar.person).joints[kNeck].cast<double>(),
          head_centre(avatar)};
}

Result<void> check_performance(const Performance& performance, const HeadModel& model,
                               std::span<const AttributeRegion> attributes) {
  std::vector<std::pair<std::string, float>> actions;
  for (const auto& [channel, keys] : performance.channels) {
    if (!channel.starts_with(kActionChannel)) continue;
    const std::string name = channel.substr(kActionChannel.size());
    if (attribute_index(attributes, name) < 0) actions.emplace_back(name, 0.0f);
  }
  const auto known = articulate(model, neutral_articulation(model), actions);
  if (known) return {};
  Error error = known.error();
  error.fix +=
      " If it is a painted attribute that was removed, delete its keys, or paint it again and train.";
  return error;
}

DirectedMoment direct_moment(const DirectedAvatar& directed, const Performance& performance, double time_s) {
  const Avatar& avatar = *directed.avatar;
  const auto at = [&](const char* channel) { return value_at(performance, channel, time_s); };
  const auto rad = [&](const char* channel) { return double(at(channel)) * kRadians; };
  DirectedMoment moment;
  moment.view = {rad("camera yaw"), rad("camera pitch"),  at("camera distance"),
                 at("camera zoom"), at("camera shift x"), at("camera shift y")};
  moment.camera = directed_camera(directed, moment.view);
  AvatarPose& pose = moment.pose;
  const Vec3d shift(at("head x"), at("head y"), at("head z"));
  Pose shifted = avatar.world_from_head;
  shifted.translate(shift);
  pose.world_from_head =
      turned_head(shifted, directed.neck, rad("head yaw"), rad("head pitch"), rad("head roll"));
  pose.world_from_torso = avatar.world_from_torso;
  pose.world_from_torso.pretranslate(avatar.world_from_head.linear() * (shift - within_reach(shift)));
  pose.articulation = avatar.neutral;
  pose.attributes.assign(avatar.attributes.size(), 0.f);
  for (const auto& [channel, keys] : performance.channels) {
    if (!channel.starts_with(kActionChannel)) continue;
    const std::string_view name = std::string_view(channel).substr(kActionChannel.size());
    const float amount = value_at(keys, time_s, 0);
    if (const NamedAction* action = find_action(*directed.model, name))
      add_action(pose.articulation, *action, amount);
    else if (const int a = attribute_index(avatar.attributes, name); a >= 0)
      pose.attributes[std::size_t(a)] = amount;
  }
  add_gaze(pose.articulation, *directed.model, float(rad("gaze yaw")), float(rad("gaze pitch")));
  return moment;
}

Result<Film> direct_film(const OpenedAvatar& opened, const Performance& performance) {
  if (const auto known = check_performance(performance, opened.model, opened.avatar.attributes); !known)
    return known.error();
  return Film{std::size_t(frame_count(performance)),
              [directed = direct_avatar(opened.avatar, opened.model), performance](std::size_t frame) {
                DirectedMoment moment =
                    direct_moment(directed, performance, double(frame) / performance.frames_per_second);
                return FilmFrame{std::move(moment.camera), std::move(moment.pose)};
              }};
}

Performance performance_of(const DrivenClip& clip, const DirectedAvatar& directed) {
  Performance performance = performance_of(clip.frames, clip.frames_per_second, directed);
  for (std::size_t a = 0; a < clip.attributes.size(); ++a)
    if (clip.attributes[a] != 0)
      performance.channels[action_channel(directed.avatar->attributes[a].name)] = {
          {0, clip.attributes[a], Easing::linear}};
  return performance;
}

Performance performance_of(std::span<const DrivenFrame> frames, double frames_per_second,
                           const DirectedAvatar& directed) {
  constexpr float kAtRest = 1e-3f;
  constexpr int kHeadChannels = 8;  // of kPoseChannels; a clip does not determine the camera's
  const ActionBasis basis = action_basis(*directed.model);
  std::vector<std::string> channels(kPoseChannels, kPoseChannels + kHeadChannels);
  for (const NamedAction& action : basis.actions) channels.push_back(action_channel(action.name));
  std::vector<std::vector<float>> values;
  std::vector<double> times;
  for (const DrivenFrame& frame : frames) {
    const double time_s = frame.time_s - frames.front().time_s;
    if (!times.empty() && time_s <= times.back() + 2 * kSameTime_s) continue;
    values.push_back(channel_values(frame, directed, basis));
    times.push_back(time_s);
  }
  Performance performance;
  performance.frames_per_second = frames_per_second;
  performance.duration_s = (times.empty() ? 0 : times.back()) + 1 / frames_per_second;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (std::ranges::all_of(values, [&](const auto& of) { return std::abs(of[c]) < kAtRest; })) continue;
    std::vector<Key>& keys = performance.channels[channels[c]];
    for (std::size_t i = 0; i < values.size(); ++i) keys.push_back({times[i], values[i][c], Easing::linear});
  }
  return performance;
}

}  // namespace likeness
