// Claims about smiles seen in the pictures: by a mouth's width, and by teeth between the lips.
#include "core/project/seen_mouth.h"

#include <gtest/gtest.h>

#include "core/head/pose_head.h"
#include "tests/core/lab/truth/acted_track.h"

namespace likeness {
namespace {

constexpr double kSmiled = 0.7;

// Two seconds of a face before a resting camera: at rest, then smiling, while the track's coefficients say
// that nothing happens.
struct Filmed {
  Filmed(float smile, float jaw) {
    const TrackTruth acted = acted_truth(50);
    track = acted.track;
    cameras = acted.cameras;
    track.neutral = neutral_articulation(acting_head());
    capture.width = capture.height = 512, capture.crop = {128, 128, 256}, capture.size = 256;
    const HeadShape shape = shape_head(acting_head(), track.person);
    for (TrackedFrame& frame : track.frames) {
      frame.pose.articulation = neutral_articulation(acting_head());
      Articulation shown = frame.pose.articulation;
      if (frame.frame < 20) {
        track.rest.frames.push_back(frame.frame);
      } else {
        for (const char* side : {"mouthSmile_L", "mouthSmile_R"})
          add_action(shown, *find_action(acting_head(), side), smile);
        add_action(shown, *find_action(acting_head(), "jawOpen"), jaw);
      }
      const auto points = landmark_positions(acting_head(), pose_head(acting_head(), shape, shown));
      for (int k = 0; k < kLandmarkCount; ++k)
        frame.landmarks[k] = project<double>(cameras.cameras[0].intrinsics,
                                             frame.pose.world_from_head * points[k].cast<double>());
      capture.frames.push_back({frame.frame, frame.time_s, 100, false, true, ""});
    }
  }
  SeenMouth seen(const FramePictures& pictures) const {
    return seen_mouth(capture, cameras, track, acting_head(), pictures);
  }
  SeenMouth seen() const {
    return seen([](int) { return std::nullopt; });
  }

  Capture capture;
  CameraSet cameras;
  Track track;
};

TEST(SeenMouth, ASmileThatTheTrackMissesIsSeenByTheMouthsWidth) {
  const SeenMouth seen = Filmed(kSmiled, 0).seen();
  EXPECT_GT(seen.widest, 1.1);
  EXPECT_NEAR(seen.smile, kSmiled, 0.15);
  EXPECT_FALSE(seen.teeth);
}

TEST(SeenMouth, AFaceAtRestOrAnOpenMouthIsNoSmile) {
  EXPECT_EQ(Filmed(0, 0).seen().smile, 0);
  EXPECT_EQ(Filmed(0, 0.6f).seen().smile, 0);
}

// Skin everywhere, and a colour between the lips.
Image8 picture_with(const std::array<Vec2d, kLandmarkCount>& p, std::array<int, 3> between) {
  Image8 rgb(256, 256, 3);
  Vec2d low = p[60], high = p[60];
  for (int k = 60; k < kLandmarkCount; ++k) low = low.cwiseMin(p[k]), high = high.cwiseMax(p[k]);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      const bool mouth = x > low.x() && x < high.x() && y > low.y() && y < high.y();
      const std::array<int, 3> colour = mouth ? between : std::array{205, 150, 125};
      for (int c = 0; c < 3; ++c) rgb.at(x, y)[c] = std::uint8_t(colour[std::size_t(c)]);
    }
  return rgb;
}

TEST(SeenMouth, TeethArePaleAndBrightADarkMouthAndATongueAreNot) {
  const Filmed smiling(kSmiled, 0.2f);
  const auto shown = [&](std::array<int, 3> between) {
    return smiling.seen([&](int frame) {
      std::array<Vec2d, kLandmarkCount> points = find_tracked(smiling.track, frame)->landmarks;
      for (Vec2d& p : points) p -= Vec2d(128, 128);
      return std::optional(picture_with(points, between));
    });
  };
  EXPECT_TRUE(shown({215, 210, 195}).teeth);
  EXPECT_FALSE(shown({40, 20, 20}).teeth);
  EXPECT_FALSE(shown({200, 95, 95}).teeth);
}

}  // namespace
}  // namespace likeness
