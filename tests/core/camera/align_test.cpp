// Claims about the whole camera solve, with the real `colmap` program on a small rendered clip: first the
// camera moves, then it rests.
#include "core/camera/align.h"
#include "core/base/align_points.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>

#include "core/base/rigid.h"
#include "core/camera/process.h"
#include "core/camera/resect.h"
#include "core/video/encode.h"
#include "tests/core/camera/textured_room.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 66, kRestFrom = 40;

Intrinsics clip_intrinsics() {
  Intrinsics k;
  k.width = 320, k.height = 240;
  k.fx = k.fy = 330, k.cx = 160, k.cy = 120;
  return k;
}

Pose truth(int frame) {
  const double t = std::min(frame, kRestFrom) / double(kRestFrom);  // 0..1 while moving
  const double angle = -0.45 + 0.9 * t;
  return look_at({1.5 * std::sin(angle), 0.15 * std::sin(5 * t), 1.0 - 1.6 * std::cos(angle)}, {0.1, 0, 1.4});
}

// The masked person: a disc in the middle that moves on its own.
void draw_person(Image8& picture, int frame) {
  const double cx = 160 + 12 * std::sin(frame * 0.5), cy = 150;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (std::hypot(x - cx, y - cy) < 45)
        for (int c = 0; c < 3; ++c)
          picture.at(x, y)[c] = std::uint8_t(220 * wall_texture(2 * (x - cx), 2 * (y - cy), 50));
}

Image8 person_mask(int, const Image8& rgb) {
  Image8 mask(rgb.width, rgb.height, 1, 0);
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x)
      if (std::hypot(x - 160, y - 150) < 62) *mask.at(x, y) = 255;
  return mask;
}

AlignOptions small_options() {
  AlignOptions options;
  options.keyframes = 14;
  options.colmap_width = 320;
  options.colmap_features = 900;
  return options;
}

class AlignMovingClip : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("likeness_align_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    const Intrinsics k = clip_intrinsics();
    auto writer = VideoWriter::create(folder_ / "clip.mp4", k.width, k.height, {20, 14});
    ASSERT_TRUE(writer.ok());
    for (int frame = 0; frame < kFrames; ++frame) {
      Image8 picture = render_room(k, truth(frame));
      draw_person(picture, frame);
      ASSERT_TRUE(writer->add(picture).ok());
    }
    ASSERT_TRUE(writer->finish().ok());
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static fs::path folder_;
};
fs::path AlignMovingClip::folder_;

TEST_F(AlignMovingClip, AMissingColmapSaysHowToInstallIt) {
  AlignOptions options = small_options();
  options.colmap = "likeness-no-such-program";
  const auto result = align_clip(folder_ / "clip.mp4", person_mask, folder_ / "none", options, {}, {});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::missing_dependency);
  EXPECT_NE(result.error().fix.find("apt install colmap"), std::string::npos);
}

TEST_F(AlignMovingClip, RecoversThePathUpToASimilarityAndSharesThePoseOfTheRest) {
  if (!find_program("colmap")) GTEST_SKIP() << "colmap is not installed";
  // -- Interrupted in the middle of the solve, then run again: it continues.
  std::stop_source stop;
  const Progress interrupter([&](const ProgressReport& report) {
    if (report.text.find("Matching pictures") != std::string::npos) stop.request_stop();
  });
  const auto cut = align_clip(folder_ / "clip.mp4", person_mask, folder_ / "work", small_options(),
                              interrupter, stop.get_token());
  ASSERT_FALSE(cut.ok());
  EXPECT_EQ(cut.error().code, ErrorCode::cancelled);
  EXPECT_TRUE(fs::exists(folder_ / "work" / "features.done"));
  EXPECT_FALSE(fs::exists(folder_ / "work" / "model.done"));

  std::mutex mutex;
  double fraction = 0;
  bool rising = true;
  const Progress progress([&](const ProgressReport& report) {
    const std::lock_guard lock(mutex);
    rising = rising && report.fraction >= fraction;
    fraction = report.fraction;
  });
  const auto result =
      align_clip(folder_ / "clip.mp4", person_mask, folder_ / "work", small_options(), progress, {});
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_TRUE(rising);
  EXPECT_DOUBLE_EQ(fraction, 1);
  EXPECT_FALSE(result->cameras.rests());
  EXPECT_EQ(result->cameras.scale, CameraScale::arbitrary);
  EXPECT_EQ(result->frames, kFrames);
  EXPECT_GE(result->registered, kFrames * 9 / 10);
  EXPECT_LT(result->cameras.reprojection_px, 1.0);

  // -- Centres against the truth after the best similarity.
  const auto& cameras = result->cameras.cameras;
  Eigen::Matrix3Xd found(3, cameras.size()), expected(3, cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    found.col(long(i)) = inverse(cameras[i].cam_from_world).translation();
    expected.col(long(i)) = inverse(truth(cameras[i].frame)).translation();
  }
  const Eigen::Matrix4d similarity = similarity_between(found, expected);
  const double scale = similarity.block<3, 1>(0, 0).norm();
  const Mat3d rotation = similarity.topLeftCorner<3, 3>() / scale;
  const double extent = (expected.rowwise().maxCoeff() - expected.rowwise().minCoeff()).norm();
  // A principal point that is a little off turns every camera by the same angle: that part is bounded on its
  // own.
  std::vector<double> position, turn_deg;
  std::vector<Pose> differences;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Vec3d moved = (similarity * found.col(long(i)).homogeneous()).head<3>();
    position.push_back((moved - expected.col(long(i))).norm() / extent);
    Pose difference = Pose::Identity();
    difference.linear() = cameras[i].cam_from_world.linear() * rotation.transpose() *
                          truth(cameras[i].frame).linear().transpose();
    differences.push_back(difference);
  }
  const Mat3d constant = mean_pose(differences).linear();
  for (const auto& difference : differences)
    turn_deg.push_back(rotation_angle(constant.transpose() * difference.linear()) * 180 / M_PI);
  std::sort(position.begin(), position.end());
  std::sort(turn_deg.begin(), turn_deg.end());
  EXPECT_LT(rotation_angle(constant) * 180 / M_PI, 2.0);
  EXPECT_LT(position[position.size() / 2], 0.01);
  EXPECT_LT(position.back(), 0.05);
  EXPECT_LT(turn_deg[turn_deg.size() / 2], 0.25);
  EXPECT_LT(turn_deg.back(), 1.0);
  std::printf(
      "position median %.4f max %.4f; rotation median %.3f max %.3f degrees, constant %.3f; %d placed; fx "
      "%.1f\n",
      position[position.size() / 2], position.back(), turn_deg[turn_deg.size() / 2], turn_deg.back(),
      rotation_angle(constant) * 180 / M_PI, result->registered, cameras[0].intrinsics.fx);
  EXPECT_NEAR(cameras[0].intrinsics.fx, 330, 330 * 0.03);
  EXPECT_EQ(cameras[0].intrinsics.width, 320);

  // -- The rest has one pose, bit for bit.
  const Camera* last = find_camera(result->cameras, kFrames - 1);
  ASSERT_NE(last, nullptr);
  int sharing = 0;
  for (int frame = kRestFrom; frame < kFrames; ++frame) {
    const Camera* camera = find_camera(result->cameras, frame);
    if (camera && camera->cam_from_world.matrix() == last->cam_from_world.matrix()) ++sharing;
  }
  EXPECT_GE(sharing, kFrames - kRestFrom - 5);
}

}  // namespace
}  // namespace likeness
