// Claims about a track drawn over its clip.
#include "core/track/clip/overlay.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"
#include "core/video/decode.h"
#include "core/video/encode.h"

namespace likeness {
namespace {

struct OverlayScene {
  HeadModel model = make_builtin_head();
  CameraSet cameras;
  Track track;
  OverlayScene() {
    cameras.cameras = {Camera{-1, {320, 240, 500, 500, 160, 120}}};
    track.person.identity = Eigen::VectorXf::Zero(model.identity_count());
    TrackedFrame f;
    f.pose.articulation = neutral_articulation(model);
    f.pose.world_from_head.linear() = Vec3d(1, -1, -1).asDiagonal();
    const auto points = landmark_positions(model, shape_head(model, track.person).vertices);
    f.pose.world_from_head.translation() =
        Vec3d(0, 0, 0.9) - f.pose.world_from_head.linear() * points[30].cast<double>();
    for (int i = 0; i < kLandmarkCount; ++i)
      f.landmarks[i] = project<double>(cameras.cameras[0].intrinsics,
                                       Vec3d(f.pose.world_from_head * points[i].cast<double>()));
    track.frames = {f};
  }
};

// Pixels of the picture part that are not as given.
int drawn(const Image8& overlay, std::uint8_t level, int rows) {
  int count = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(rows) * overlay.width * 3; ++i)
    count += overlay.data[i] != level;
  return count;
}

TEST(TrackOverlay, DrawsTheHeadWhereItIsAndNothingInTheCorners) {
  const OverlayScene s;
  OverlayOptions options;
  options.longer_side = 320;
  const TrackOverlay overlay(s.track, s.model, s.cameras, options);
  const Image8 picture = overlay.draw(Image8(320, 240, 3, 90), s.track.frames[0]);
  EXPECT_GT(picture.height, 240);
  EXPECT_GT(drawn(picture, 90, 240), 2000);
  for (const auto& [x, y] : {std::pair{2, 2}, {317, 2}}) EXPECT_EQ(picture.at(x, y)[0], 90);
}

TEST(TrackOverlay, ALostFrameKeepsItsPictureAndSaysWhy) {
  OverlayScene s;
  s.track.frames[0].status = FrameStatus::lost;
  OverlayOptions options;
  options.longer_side = 320;
  const TrackOverlay overlay(s.track, s.model, s.cameras, options);
  const Image8 silent = overlay.draw(Image8(320, 240, 3, 90), s.track.frames[0]);
  EXPECT_EQ(drawn(silent, 90, 240), 0);
  s.track.frames[0].reason = "no face found";
  EXPECT_NE(overlay.draw(Image8(320, 240, 3, 90), s.track.frames[0]).data, silent.data);
}

TEST(TrackOverlay, TheFilmHasTheClipsTimes) {
  const OverlayScene s;
  const std::string stem =
      (std::filesystem::temp_directory_path() / ("likeness_overlay_" + std::to_string(getpid()))).string();
  const std::vector<double> times_s{0, 0.04, 2.5, 2.52};
  auto clip = VideoWriter::create(stem + "_clip.mp4", 320, 240, {.timed = true});
  ASSERT_TRUE(clip.ok());
  for (const double time_s : times_s) ASSERT_TRUE(clip->add(Image8(320, 240, 3, 90), time_s).ok());
  ASSERT_TRUE(clip->finish().ok());
  ASSERT_TRUE(
      write_overlay(stem + "_clip.mp4", s.track, s.model, s.cameras, stem + "_film.mp4", {}, Progress(), {})
          .ok());
  auto film = VideoReader::open(stem + "_film.mp4");
  ASSERT_TRUE(film.ok());
  for (const double time_s : times_s) {
    const auto frame = film->next();
    ASSERT_TRUE(frame.ok() && *frame);
    EXPECT_NEAR((*frame)->time_s, time_s, 1e-3);
  }
  for (const char* end : {"_clip.mp4", "_film.mp4"}) std::filesystem::remove(stem + end);
}

TEST(TrackOverlay, UncertainLandmarksAreRedder) {
  OverlayScene s;
  OverlayOptions options;
  options.longer_side = 320;
  const TrackOverlay overlay(s.track, s.model, s.cameras, options);
  const auto red = [&] {
    const Image8 picture = overlay.draw(Image8(320, 240, 3, 0), s.track.frames[0]);
    int count = 0;
    for (std::size_t i = 0; i < std::size_t{240} * 320 * 3; i += 3)
      count += picture.data[i] > 200 && picture.data[i + 1] < 40 && picture.data[i + 2] < 40;
    return count;
  };
  const int sure = red();
  s.track.frames[0].landmark_spread.fill(20);
  EXPECT_GT(red(), sure + 50);
}

}  // namespace
}  // namespace likeness
