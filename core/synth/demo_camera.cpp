// Paths of the demo's cameras: see demo_camera.h.
#include "core/synth/demo_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/rigid.h"
#include "core/synth/body_pose.h"
#include "core/synth/easing.h"
#include "core/synth/noise.h"
#include "core/video/lens_tag.h"

namespace likeness {
namespace {

constexpr double kRadians = std::numbers::pi / 180, kRound = 2 * std::numbers::pi;
constexpr double kFocal = 1.35;  // over the picture's shorter side
constexpr double kDistance_m = 0.62;
constexpr double kCloser = 1.35;         // a punch-in crops 1 / this of the picture
constexpr double kMostZoom = 1.4;        // over the widest
constexpr double kZoomSeconds = 7;       // in, out, and a while at each end
constexpr double kWalkSeconds = 10;      // to one side, to the other and back
constexpr double kBreathing = 0.012;     // of the focal length
constexpr double kFollowSeconds = 0.35;  // by which a sliding crop is late
constexpr double kFurthestSlide = 0.25;  // of the picture's width

// Where a camera stands to film a place, about the person's usual one, and how far the person turns to it.
struct Place {
  double yaw, pitch, distance_m, person_yaw;
};
constexpr Place kPlaces[] = {{0, 0, 0, 0},
                             {38 * kRadians, 4 * kRadians, 0.08, 33 * kRadians},
                             {-30 * kRadians, -3 * kRadians, 0.04, -26 * kRadians}};

const Place& place_of(int place) { return kPlaces[std::size_t(place) % std::size(kPlaces)]; }

Pose look_at(const Vec3d& eye, const Vec3d& target, double roll) {
  const Vec3d forward = (target - eye).normalized();
  const Vec3d right = forward.cross(Vec3d::UnitY()).normalized();
  Mat3d cam_from_world;
  cam_from_world.row(0) = right;
  cam_from_world.row(1) = forward.cross(right);
  cam_from_world.row(2) = forward;
  cam_from_world = rotation_about(Vec3d::UnitZ(), roll) * cam_from_world;
  Pose pose = Pose::Identity();
  pose.linear() = cam_from_world;
  pose.translation() = -cam_from_world * eye;
  return pose;
}

Intrinsics usual_lens(const DemoOptions& options) {
  Intrinsics k;
  k.width = options.width;
  k.height = options.height;
  k.fx = k.fy = kFocal * std::min(options.width, options.height);
  k.cx = 0.5 * options.width;
  k.cy = 0.5 * options.height;
  return k;
}

// How the camera that moves as people are asked to leaves its place: from the subject's right round to the
// left and back to the front, rising and sinking, nearer and farther; the last tenth settles onto the
// position of the second part.
struct Detour {
  double yaw = 0, pitch = 0, nearer_m = 0, roll = 0;
  Vec3d aim = Vec3d::Zero();
};
Detour guided_path(double u) {
  const double settle = 1 - ease((u - 0.86) / 0.14);
  const double sweep =
      u < 0.62 ? -std::cos(std::numbers::pi * u / 0.62) : std::cos(std::numbers::pi * (u - 0.62) / 0.76);
  Detour path;
  path.yaw = 31 * kRadians * sweep * settle;
  path.pitch = 11 * kRadians * std::sin(kRound * (1.6 * u + 0.08)) * settle;
  path.nearer_m = (0.06 * std::sin(kRound * 1.15 * u + 0.5)) * settle;
  path.roll = 2.0 * kRadians * std::sin(kRound * 1.3 * u) * settle;
  path.aim = Vec3d(0.012 * std::sin(kRound * 1.7 * u), 0.01 * std::sin(kRound * 2.1 * u + 1), 0) * settle;
  return path;
}

// The same, without end: every round a little different, none of them resting.
Detour walking_path(double rounds) {
  const double a = kRound * rounds;
  Detour path;
  path.yaw = -31 * kRadians * std::cos(a);
  path.pitch = 11 * kRadians * std::sin(1.62 * a + 0.5);
  path.nearer_m = 0.06 * std::sin(1.17 * a + 0.5);
  path.roll = 2.0 * kRadians * std::sin(1.3 * a);
  path.aim = Vec3d(0.012 * std::sin(1.7 * a), 0.01 * std::sin(2.1 * a + 1), 0);
  return path;
}

Detour detour_of(const DemoOptions& options, double frame) {
  if (options.camera == DemoCamera::walking) {
    const double seconds = options.frames / options.frames_per_second;
    return walking_path(std::max(1.0, std::round(seconds / kWalkSeconds)) * frame / options.frames);
  }
  const Moment moment = moment_of(options, frame);
  return options.camera == DemoCamera::guided && moment.walking ? guided_path(moment.share) : Detour();
}

Pose view_of(const Place& place, const Detour& path, const Vec3d& face) {
  Vec3d aim = face + Vec3d(0, -0.035, -0.03);
  aim += path.aim;
  const double yaw = place.yaw + path.yaw, pitch = place.pitch + path.pitch;
  const double distance = kDistance_m + place.distance_m + path.nearer_m;
  const Vec3d offset(std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch));
  return look_at(aim + distance * offset + Vec3d(0, 0.02, 0), aim, path.roll);
}

struct Wave {
  double hertz, amplitude;
};
constexpr std::array<Wave, 10> kHand = {{{0.07, 1},
                                         {0.12, 0.70},
                                         {0.21, 0.45},
                                         {0.37, 0.25},
                                         {0.62, 0.12},
                                         {1.1, 0.055},
                                         {1.5, 0.050},
                                         {2.1, 0.050},
                                         {2.9, 0.035},
                                         {5.3, 0.006}}};
constexpr std::array<Wave, 3> kSlow = {{{0.11, 1}, {0.19, 0.6}, {0.33, 0.35}}};

// A curve of these waves with phases of its own, in [-1, 1].
template <std::size_t N>
double waves(const std::array<Wave, N>& list, double time_s, std::uint32_t seed) {
  double sum = 0, most = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const double off = 0.85 + 0.3 * double(hash_unit(seed * 64 + 2 * std::uint32_t(i)));
    const double phase = double(hash_unit(seed * 64 + 2 * std::uint32_t(i) + 1));
    sum += list[i].amplitude * std::sin(kRound * (list[i].hertz * off * time_s + phase));
    most += list[i].amplitude;
  }
  return sum / most;
}

// Turns and displaces the camera as a hand does, and lets its focal length breathe as a lens that focuses.
void hold_by_hand(const DemoOptions& options, double time_s, Camera& camera) {
  const std::uint32_t seed = hash_u32(std::uint32_t(options.seed) + 4400);
  const auto hand = [&](std::uint32_t axis) { return waves(kHand, time_s, seed + axis); };
  const double most = options.hand_turn_deg * kRadians;
  const Mat3d turned = rotation_about(Vec3d::UnitZ(), 0.5 * most * hand(2)) *
                       rotation_about(Vec3d::UnitX(), 0.8 * most * hand(1)) *
                       rotation_about(Vec3d::UnitY(), most * hand(0));
  const Vec3d lens = inverse(camera.cam_from_world).translation();
  const Vec3d aside = options.hand_shift_m / std::sqrt(3.0) * Vec3d(hand(3), hand(4), hand(5));
  camera.cam_from_world.linear() = turned * camera.cam_from_world.linear();
  camera.cam_from_world.translation() = -(camera.cam_from_world.linear() * lens) - aside;
  const double breathing = 1 + kBreathing * waves(kSlow, time_s, seed + 6);
  camera.intrinsics.fx *= breathing, camera.intrinsics.fy *= breathing;
}

double zoom_of(const DemoOptions& options, double frame) {
  const double seconds = options.frames / options.frames_per_second;
  const double position = std::max(1.0, std::round(seconds / kZoomSeconds)) * frame / options.frames;
  const double phase = position - std::floor(position);
  return std::exp(std::log(kMostZoom) * ease((phase - 0.12) / 0.25) * ease((0.92 - phase) / 0.25));
}

// The crop follows where the face was lately, a little behind it.
Vec2d slide_of(const DemoOptions& options, const HeadShape& shape, const Camera& camera, const Pose& placed,
               double frame) {
  const Vec3d eyes = (0.5f * (shape.joints[kLeftEye] + shape.joints[kRightEye])).cast<double>();
  const auto seen = [&](const Pose& world_from_head) {
    return project<double>(camera.intrinsics,
                           Vec3d(camera.cam_from_world * (placed * world_from_head * eyes)));
  };
  const Vec2d middle = seen(Pose::Identity());
  constexpr int kSteps = 24;
  Vec2d sum = Vec2d::Zero();
  double weights = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double ago_s = 3 * kFollowSeconds * i / kSteps, weight = std::exp(-ago_s / kFollowSeconds);
    const BodyPose body = body_pose(options, shape, frame - ago_s * options.frames_per_second);
    sum += weight * (seen(body.world_from_head) - middle);
    weights += weight;
  }
  const double most = kFurthestSlide * options.width;
  return (sum / weights).cwiseMax(-most).cwiseMin(most);
}

// Crops the middle, a little above it, as editors do to a face; less where the camera itself comes close.
void crop_closer(const DemoOptions& options, Intrinsics& k) {
  const double closer = options.camera == DemoCamera::zoom ? std::sqrt(kCloser) : kCloser;
  const double above = 0.03 * k.height;
  k.fx *= closer, k.fy *= closer;
  k.cx = 0.5 * k.width + closer * (k.cx - 0.5 * k.width);
  k.cy = 0.5 * k.height + closer * (k.cy - 0.5 * k.height + above);
}

}  // namespace

const std::vector<std::string>& demo_camera_names() {
  static const std::vector<std::string> names = {"guided", "resting", "handheld", "walking", "zoom", "slide"};
  return names;
}

Pose placed_person(int place) {
  Pose pose = Pose::Identity();
  const double yaw = place_of(place).person_yaw;
  if (yaw != 0) pose.linear() = rotation_about(Vec3d::UnitY(), yaw);
  return pose;
}

Camera demo_camera(const DemoOptions& options, const HeadShape& shape, const DemoShot& shot, double frame) {
  Camera camera;
  camera.intrinsics = usual_lens(options);
  Vec3d eyes = (0.5f * (shape.joints[kLeftEye] + shape.joints[kRightEye])).cast<double>();
  const Pose placed = placed_person(shot.place);
  if (shot.place != 0) eyes = placed * eyes;
  camera.cam_from_world = view_of(place_of(shot.place), detour_of(options, frame), eyes);
  if (options.camera == DemoCamera::handheld || options.camera == DemoCamera::zoom)
    hold_by_hand(options, frame / options.frames_per_second, camera);
  if (options.camera == DemoCamera::zoom) {
    const double zoom = zoom_of(options, frame);
    camera.intrinsics.fx *= zoom, camera.intrinsics.fy *= zoom;
  }
  if (options.camera == DemoCamera::slide) {
    const Vec2d slid = slide_of(options, shape, camera, placed, frame);
    camera.intrinsics.cx -= slid.x(), camera.intrinsics.cy -= slid.y();
  }
  if (shot.close) crop_closer(options, camera.intrinsics);
  return camera;
}

bool camera_rests(const DemoOptions& options, double frame) {
  if (options.camera == DemoCamera::resting) return true;
  return options.camera == DemoCamera::guided && frame >= moving_frames(options);
}

int focal_35mm(const DemoOptions& options) {
  const Intrinsics k = usual_lens(options);
  return int(std::lround(kFilmWidth_mm * k.fx / std::max(k.width, k.height)));
}

}  // namespace likeness
