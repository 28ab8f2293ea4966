// Claims about track.json.
#include "core/scene/track.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <fstream>
#include <random>

#include "core/base/rigid.h"

namespace likeness {
namespace {

Track random_track() {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Track track;
  track.head_model_name = "a \"quoted\" näme";
  track.head_model_hash = "0123abcd";
  track.head_model_file = "/some/where/head.npz";
  track.person.identity = Eigen::VectorXf::NullaryExpr(7, [&] { return static_cast<float>(normal(random)); });
  track.person.offsets = {{0.001f, -0.002f, 1e-7f}, {0, 0.5f, -0.25f}};
  track.neutral.expression = Eigen::VectorXf::LinSpaced(3, 0, 0.3f);
  track.neutral.jaw = {0.02f, 0, 0};
  track.has_torso = false;
  track.shots = {{0, 5}, {6, 20}};
  track.metres_per_unit = 1.0 / 3.0;
  for (int i = 0; i < 3; ++i) {
    TrackedFrame f;
    f.frame = 5 * i + 1;
    f.time_s = i / 29.97;
    f.status = static_cast<FrameStatus>(i);
    f.reason = i ? "too dark" : "";
    const Vec3d axis = Vec3d(normal(random), normal(random), normal(random)).normalized();
    f.pose.world_from_head.linear() = rotation_about(axis, normal(random));
    f.pose.world_from_head.translation() = Vec3d(normal(random), 1e-17, -0.0);
    f.pose.world_from_torso = inverse(f.pose.world_from_head);
    f.pose.articulation.expression =
        Eigen::VectorXf::NullaryExpr(5, [&] { return static_cast<float>(normal(random)); });
    f.pose.articulation.jaw = Vec3f(0.1f, 1e-30f, -0.3f);
    f.pose.articulation.left_eye = Vec3f(0.7f, 0.1f, 1.0f / 7.0f);
    for (Vec2d& p : f.landmarks) p = Vec2d(1000 * normal(random), normal(random) / 3);
    f.inner_error_px = std::abs(normal(random));
    track.frames.push_back(f);
  }
  return track;
}

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::temp_directory_path() /
         ("likeness_track_test_" + std::to_string(::getpid()) + "_" + name);
}

TEST(TrackFile, ReadsBackTheSameBits) {
  const Track track = random_track();
  const auto path = scratch("round.json");
  ASSERT_TRUE(write_track(path, track).ok());
  const auto back = read_track(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(back.ok()) << back.error().what;
  EXPECT_EQ(back->head_model_name, track.head_model_name);
  EXPECT_EQ(back->head_model_file, track.head_model_file);
  EXPECT_EQ(back->has_torso, track.has_torso);
  EXPECT_EQ(back->shots, track.shots);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(back->metres_per_unit),
            std::bit_cast<std::uint64_t>(track.metres_per_unit));
  EXPECT_EQ(back->person.identity, track.person.identity);
  EXPECT_EQ(back->person.offsets, track.person.offsets);
  EXPECT_EQ(back->neutral.expression, track.neutral.expression);
  EXPECT_EQ(back->neutral.jaw, track.neutral.jaw);
  ASSERT_EQ(back->frames.size(), track.frames.size());
  for (std::size_t i = 0; i < track.frames.size(); ++i) {
    const TrackedFrame &a = track.frames[i], &b = back->frames[i];
    EXPECT_EQ(a.frame, b.frame);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.reason, b.reason);
    EXPECT_EQ(a.time_s, b.time_s);
    EXPECT_TRUE((a.pose.world_from_head.matrix().array() == b.pose.world_from_head.matrix().array()).all());
    EXPECT_TRUE((a.pose.world_from_torso.matrix().array() == b.pose.world_from_torso.matrix().array()).all());
    EXPECT_EQ(a.pose.articulation.expression, b.pose.articulation.expression);
    EXPECT_EQ(a.pose.articulation.jaw, b.pose.articulation.jaw);
    EXPECT_EQ(a.pose.articulation.left_eye, b.pose.articulation.left_eye);
    for (int k = 0; k < kLandmarkCount; ++k) EXPECT_EQ(a.landmarks[k], b.landmarks[k]);
    EXPECT_EQ(a.inner_error_px, b.inner_error_px);
  }
  EXPECT_EQ(find_tracked(*back, 6), &back->frames[1]);
  EXPECT_EQ(find_tracked(*back, 7), nullptr);
}

TEST(TrackFile, RefusesAFileThatIsNotATrack) {
  const auto path = scratch("bad.json");
  for (const std::string text : {"{}", "[1, 2", "{\"format\":\"likeness-track\",\"version\":99}",
                                 "{\"format\":\"likeness-track\",\"version\":1,\"frames\":[{}]}"}) {
    std::ofstream(path) << text;
    const auto track = read_track(path);
    ASSERT_FALSE(track.ok()) << text;
    EXPECT_EQ(track.error().code, ErrorCode::bad_input);
    EXPECT_FALSE(track.error().fix.empty());
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace likeness
