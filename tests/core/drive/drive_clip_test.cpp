// Claims about driving from a finished track: no clip is tracked twice, and a foreign track is refused.
#include "core/drive/drive_clip.h"

#include <gtest/gtest.h>

#include "core/base/rigid.h"
#include "core/camera/clip_camera.h"
#include "core/direct/direct_avatar.h"
#include "core/video/encode.h"
#include "tests/core/export/tiny_project.h"
#include "tests/core/lab/truth/acted_track.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

fs::path grey_clip(const fs::path& path, int frames) {
  auto writer = VideoWriter::create(path, 64, 48, {.frames_per_second = 25});
  EXPECT_TRUE(writer.ok());
  for (int i = 0; i < frames; ++i) EXPECT_TRUE(writer->add(Image8(64, 48, 3, 128)).ok());
  EXPECT_TRUE(writer->finish().ok());
  return path;
}

Track acted_driver(int frames) {
  Track track = acted_truth(frames).track;
  track.neutral = neutral_articulation(tiny_head());
  for (TrackedFrame& frame : track.frames) frame.landmarks.fill(Vec2d::Zero());
  return track;
}

TEST(Driving, CarriesAFinishedTrackOverFrameByFrame) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  Track track = acted_driver(40);
  DriveRequest request;
  request.video = grey_clip(project.root / "clip.mp4", 40);
  request.track = project.root / "track.json";
  ASSERT_TRUE(write_track(request.track, track).ok());
  const auto clip = drive_clip(opened, request, Progress(), {});
  ASSERT_TRUE(clip.ok()) << clip.error().what;
  EXPECT_EQ(clip->frames.size(), 40u);
  EXPECT_DOUBLE_EQ(clip->frames_per_second, 25);
  const auto poses = film_poses(*clip);
  ASSERT_EQ(poses.size(), 40u);
  EXPECT_TRUE(poses[7].world_from_head.isApprox(clip->frames[7].pose.world_from_head));
  // The driver turns by half a radian to either side of the typical pose, and so does the avatar.
  double turned = 0;
  for (const AvatarPose& pose : poses)
    turned = std::max(turned, rotation_angle(opened.avatar.world_from_head.linear().transpose() *
                                             pose.world_from_head.linear()));
  EXPECT_GT(turned, 0.3);
}

TEST(Driving, TrackOfEveryFourthFrameKeepsTheFilmsTiming) {
  const TinyProject project;
  Track track = acted_driver(40);
  std::erase_if(track.frames, [](const TrackedFrame& frame) { return frame.frame % 4 != 0; });
  DriveRequest request;
  request.video = grey_clip(project.root / "clip.mp4", 40);
  request.track = project.root / "track.json";
  ASSERT_TRUE(write_track(request.track, track).ok());
  const auto clip = drive_clip(tiny_opened(), request, Progress(), {});
  ASSERT_TRUE(clip.ok()) << clip.error().what;
  EXPECT_EQ(clip->frames.size(), 10u);
  EXPECT_DOUBLE_EQ(clip->frames_per_second, 6.25);
}

TEST(Driving, FramesOfAClipThatPausesKeepTheirTimes) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  Track track = acted_driver(40);
  for (TrackedFrame& frame : track.frames) frame.time_s = frame.frame / 30.0 + (frame.frame < 25 ? 0.2 : 5);
  DriveRequest request;
  request.video = grey_clip(project.root / "clip.mp4", 40);
  request.track = project.root / "track.json";
  ASSERT_TRUE(write_track(request.track, track).ok());
  const auto clip = drive_clip(opened, request, Progress(), {});
  ASSERT_TRUE(clip.ok()) << clip.error().what;
  EXPECT_FALSE(is_steady(*clip));
  EXPECT_NEAR(clip->frames_per_second, 30, 1e-6) << "of most frames, whatever the mean";
  const auto times_s = times_of(clip->frames);
  EXPECT_NEAR(times_s[10], 10 / 30.0, 1e-9);
  EXPECT_NEAR(times_s[30], 1 + 4.8, 1e-9);
  const Performance keys = performance_of(*clip, direct_avatar(opened.avatar, opened.model));
  ASSERT_FALSE(keys.channels.empty());
  EXPECT_NEAR(keys.channels.begin()->second.back().time_s, 39 / 30.0 + 4.8, 1e-6);
}

TEST(Driving, RefusesATrackOfALongerClip) {
  const TinyProject project;
  DriveRequest request;
  request.video = grey_clip(project.root / "clip.mp4", 20);
  request.track = project.root / "track.json";
  ASSERT_TRUE(write_track(request.track, acted_driver(40)).ok());
  const auto clip = drive_clip(tiny_opened(), request, Progress(), {});
  ASSERT_FALSE(clip.ok());
  EXPECT_NE(clip.error().what.find("frame 39"), std::string::npos) << clip.error().what;
}

TEST(Driving, RefusesATrackOfAnotherHeadModel) {
  const TinyProject project;
  Track track = acted_driver(8);
  track.head_model_hash = std::string(32, '0');
  DriveRequest request;
  request.video = grey_clip(project.root / "clip.mp4", 8);
  request.track = project.root / "track.json";
  ASSERT_TRUE(write_track(request.track, track).ok());
  const auto clip = drive_clip(tiny_opened(), request, Progress(), {});
  ASSERT_FALSE(clip.ok());
  EXPECT_NE(clip.error().fix.find("--head-model"), std::string::npos);
}

TEST(Driving, ClipWithoutSolvedCamerasGetsARestingCamera) {
  VideoInfo info;
  info.width = 1080, info.height = 1920;
  const CameraSet set = assumed_camera(info);
  ASSERT_EQ(set.cameras.size(), 1u);
  EXPECT_TRUE(set.rests());
  EXPECT_DOUBLE_EQ(set.cameras[0].intrinsics.cx, 540);
  EXPECT_DOUBLE_EQ(set.cameras[0].intrinsics.fx, 1512);
  info.focal_35mm = 27;
  EXPECT_DOUBLE_EQ(assumed_camera(info).cameras[0].intrinsics.fx, 1440);
}

TEST(AssumedCamera, LooksAtTheFilmWithinItsBars) {
  const VideoInfo upright{.width = 608, .height = 1080, .focal_35mm = 26},
      barred{.width = 1920, .height = 1080, .focal_35mm = 26};
  const Intrinsics alone = assumed_camera(upright).cameras[0].intrinsics,
                   within = assumed_camera(barred, {656, 0, 608, 1080}).cameras[0].intrinsics;
  EXPECT_DOUBLE_EQ(within.fx, alone.fx);
  EXPECT_DOUBLE_EQ(within.cx, alone.cx + 656);
  EXPECT_DOUBLE_EQ(within.cy, alone.cy);
  EXPECT_EQ(within.width, 1920);
}

}  // namespace
}  // namespace likeness::test
