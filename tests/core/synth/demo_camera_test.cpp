// Claims about the demo's cameras: what each kind moves, how far, and that it moves nothing else.
#include "core/synth/demo_camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"
#include "core/synth/performance.h"

namespace likeness {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

// One head for all films.
struct Filmed {
  DemoOptions options;
  std::vector<Shot> shots;

  static const HeadModel& model() {
    static const HeadModel head = make_builtin_head();
    return head;
  }
  static const HeadShape& shape() {
    static const HeadShape neutral = shape_head(model(), Eigen::VectorXf::Zero(model().identity_count()));
    return neutral;
  }
  explicit Filmed(DemoOptions o) : options(o) {
    for (int i = 0; i < o.frames; ++i) shots.push_back(perform(model(), shape(), o, i));
  }
  explicit Filmed(DemoCamera camera) : Filmed(DemoOptions{.camera = camera}) {}

  Vec3d lens(std::size_t i) const { return inverse(shots[i].camera.cam_from_world).translation(); }
  Mat3d turn(std::size_t i) const { return shots[i].camera.cam_from_world.linear(); }
  const Intrinsics& k(std::size_t i) const { return shots[i].camera.intrinsics; }
};

// Range of the focal length over the film, highest over lowest.
double zoom_range(const Filmed& film) {
  const auto [low, high] =
      std::ranges::minmax_element(film.shots, {}, [](const Shot& shot) { return shot.camera.intrinsics.fx; });
  return high->camera.intrinsics.fx / low->camera.intrinsics.fx;
}

// Where the middle between the eyes is in a frame's picture.
Vec2d eyes_in(const Filmed& film, std::size_t i) {
  const HeadShape& shape = Filmed::shape();
  const Vec3d eyes = (0.5f * (shape.joints[kLeftEye] + shape.joints[kRightEye])).cast<double>();
  const Shot& shot = film.shots[i];
  return project<double>(film.k(i), Vec3d(shot.camera.cam_from_world * shot.world_from_head * eyes));
}

TEST(DemoCamera, ARestingOneNeverMovesAndTheHeadDoes) {
  const Filmed film(DemoCamera::resting);
  double turned = 0;
  for (std::size_t i = 1; i < film.shots.size(); ++i) {
    EXPECT_TRUE(film.shots[i].camera.cam_from_world.isApprox(film.shots[0].camera.cam_from_world, 1e-12));
    turned = std::max(turned, rotation_angle(film.shots[i].world_from_head.linear()));
  }
  EXPECT_DOUBLE_EQ(zoom_range(film), 1);
  EXPECT_GT(turned, 20 * kRadiansPerDegree);
}

TEST(DemoCamera, AHandTurnsItByAFewDegreesAndDisplacesItHardly) {
  const Filmed film(DemoCamera::handheld);
  double furthest = 0, most = 0;
  Eigen::AlignedBox3d places;
  for (std::size_t i = 0; i < film.shots.size(); ++i) {
    places.extend(film.lens(i));
    furthest = std::max(furthest, rotation_angle(Mat3d(film.turn(i) * film.turn(0).transpose())));
    most = std::max(most, std::abs(film.k(i).cx - 256));
  }
  EXPECT_GT(furthest, 1 * kRadiansPerDegree);
  EXPECT_LT(furthest, 2 * 3 * 1.4 * kRadiansPerDegree);
  EXPECT_LT(places.diagonal().norm(), 2 * film.options.hand_shift_m);
  EXPECT_GT(places.diagonal().norm(), 0.2 * film.options.hand_shift_m);
  EXPECT_EQ(most, 0);  // the axis stays in the middle
  EXPECT_GT(zoom_range(film), 1.008);
  EXPECT_LT(zoom_range(film), 1.03);
}

TEST(DemoCamera, WithoutShiftAHandTurnsItAboutItsLens) {
  const Filmed film(DemoOptions{.camera = DemoCamera::handheld, .hand_shift_m = 0});
  for (std::size_t i = 1; i < film.shots.size(); ++i)
    EXPECT_LT((film.lens(i) - film.lens(0)).norm(), 1e-12) << i;
}

// Share of the turn's power in a band, Hz, from half a minute of it.
double power_between(double low, double high) {
  DemoOptions options{.frames = 900, .frames_per_second = 30, .camera = DemoCamera::handheld};
  std::vector<double> pan;
  const std::vector<DemoShot> shots = demo_shots(options);
  const Camera first = demo_camera(options, Filmed::shape(), shots[0], 0);
  for (int i = 0; i < options.frames; ++i) {
    const Camera camera = demo_camera(options, Filmed::shape(), shots[0], i);
    const Mat3d turned = camera.cam_from_world.linear() * first.cam_from_world.linear().transpose();
    pan.push_back(vector_from_turn(turned).y());
  }
  double sum = 0;
  const int n = int(pan.size());
  for (int bin = 1; bin < n / 2; ++bin) {
    const double hertz = bin * options.frames_per_second / n;
    if (hertz < low || hertz > high) continue;
    std::complex<double> amplitude = 0;
    for (int i = 0; i < n; ++i) {
      // Hann's window, or the drift would leak into all of it.
      const double window = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * i / n);
      amplitude += window * pan[std::size_t(i)] * std::polar(1.0, -2 * std::numbers::pi * bin * i / n);
    }
    sum += std::norm(amplitude);
  }
  return sum;
}

TEST(DemoCamera, AHandDriftsSlowlyAndTrembles) {
  const double drift = power_between(0, 0.9), tremor = power_between(0.9, 3.5),
               above = power_between(3.5, 4.4);
  EXPECT_GT(drift, 20 * tremor);
  EXPECT_GT(tremor, 1e-4 * drift);
  EXPECT_GT(tremor, 100 * above);
}

TEST(DemoCamera, AZoomGoesInAndOutAndBack) {
  const Filmed film(DemoCamera::zoom);
  EXPECT_GT(zoom_range(film), 1.35);
  EXPECT_LT(zoom_range(film), 1.45);
  for (std::size_t i = 1; i < film.shots.size(); ++i)
    EXPECT_LT(std::abs(film.k(i).fx / film.k(i - 1).fx - 1), 0.03) << i;
  EXPECT_LT(std::abs(film.k(0).fx / film.k(film.shots.size() - 1).fx - 1), 0.04);
}

TEST(DemoCamera, ASlidingCropMovesThePrincipalPointAloneAndFollowsTheFace) {
  const Filmed slide(DemoCamera::slide), rest(DemoCamera::resting);
  double slid = 0, with = 0, without = 0;
  for (std::size_t i = 0; i < slide.shots.size(); ++i) {
    EXPECT_TRUE(slide.shots[i].camera.cam_from_world.isApprox(rest.shots[i].camera.cam_from_world, 1e-12));
    EXPECT_EQ(slide.k(i).fx, rest.k(i).fx);
    slid = std::max(slid, std::abs(slide.k(i).cx - rest.k(i).cx));
    with = std::max(with, std::abs(eyes_in(slide, i).x() - 256));
    without = std::max(without, std::abs(eyes_in(rest, i).x() - 256));
  }
  EXPECT_GT(slid, 20);
  EXPECT_LT(with, 0.75 * without);
}

TEST(DemoCamera, AWalkingOneMovesInEveryFrameToBothSides) {
  const Filmed film(DemoCamera::walking);
  double low = 0, high = 0;
  for (std::size_t i = 1; i < film.shots.size(); ++i) {
    EXPECT_GT((film.lens(i) - film.lens(i - 1)).norm(), 1e-5) << i;
    EXPECT_LT((film.lens(i) - film.lens(i - 1)).norm(), 0.04) << i;
    low = std::min(low, std::atan2(film.lens(i).x(), film.lens(i).z()));
    high = std::max(high, std::atan2(film.lens(i).x(), film.lens(i).z()));
  }
  EXPECT_LT(low, -27 * kRadiansPerDegree);
  EXPECT_GT(high, 27 * kRadiansPerDegree);
}

TEST(DemoCamera, TheFaceStaysInThePictureOfEveryKind) {
  for (const DemoCamera camera : {DemoCamera::resting, DemoCamera::handheld, DemoCamera::walking,
                                  DemoCamera::zoom, DemoCamera::slide}) {
    const Filmed film(DemoOptions{.camera = camera, .cuts = 5});
    for (std::size_t i = 0; i < film.shots.size(); i += 5) {
      const Shot& shot = film.shots[i];
      for (const Vec3f& p : landmark_positions(
               Filmed::model(), pose_head(Filmed::model(), Filmed::shape(), shot.articulation))) {
        const Vec2d at = project<double>(
            film.k(i), Vec3d(shot.camera.cam_from_world * shot.world_from_head * p.cast<double>()));
        EXPECT_TRUE(at.x() > 0 && at.y() > 0 && at.x() < 512 && at.y() < 512)
            << demo_camera_names()[std::size_t(camera)] << ' ' << i << ": " << at.transpose();
      }
    }
  }
}

TEST(DemoCamera, SeedsShakeDifferentlyAndTheSameSeedTheSame) {
  const DemoOptions options{.frames = 24, .camera = DemoCamera::handheld};
  DemoOptions other = options;
  other.seed = 3;
  const Filmed a(options), b(options), c(other);
  EXPECT_TRUE(a.shots[20].camera.cam_from_world.matrix() == b.shots[20].camera.cam_from_world.matrix());
  EXPECT_FALSE(a.shots[20].camera.cam_from_world.isApprox(c.shots[20].camera.cam_from_world, 1e-4));
}

TEST(DemoCamera, AStillTorsoDoesNotMoveWhileTheHeadDoes) {
  const Filmed film(DemoOptions{.camera = DemoCamera::handheld, .still_torso = true});
  double turned = 0;
  for (const Shot& shot : film.shots) {
    EXPECT_TRUE(shot.world_from_torso.isApprox(Pose::Identity(), 1e-12));
    turned = std::max(turned, rotation_angle(shot.world_from_head.linear()));
  }
  EXPECT_GT(turned, 20 * kRadiansPerDegree);
}

TEST(DemoCamera, FocalLengthOnFilmIsByTheLongerSide) {
  DemoOptions upright;
  upright.width = 540, upright.height = 960;
  EXPECT_EQ(focal_35mm(upright), 27);  // 36 mm * 1.35 * 540 / 960
  std::swap(upright.width, upright.height);
  EXPECT_EQ(focal_35mm(upright), 27);
}

}  // namespace
}  // namespace likeness
