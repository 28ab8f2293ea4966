// Claims about the torso: a textured board in the camera's view below the chin.
#include "core/track/torso/torso.h"

#include <gtest/gtest.h>

#include "core/base/rigid.h"
#include "tests/core/track/torso/torso_board.h"

namespace likeness {
namespace {

TEST(Torso, FollowsAShiftInThePicture) {
  std::vector<Vec3d> motions;
  for (int i = 0; i < 12; ++i) motions.push_back({0.0015 * i, -0.001 * i, 0});
  const BoardClip clip = make_clip(motions);
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  ASSERT_TRUE(track->has_torso);
  const Vec3d chest(0.05, -0.2, 0.04);
  const auto place = [&](int i) { return Vec3d(track->world_from_torso[i] * chest); };
  for (int i : {4, 9}) {
    const Vec3d moved = place(i) - place(2);
    EXPECT_NEAR(moved.x(), 0.0015 * (i - 2), 0.0012);
    EXPECT_NEAR(moved.y(), -0.001 * (i - 2), 0.0012);
  }
  EXPECT_LT(track->residual_after, 0.5 * track->residual_before);
}

TEST(Torso, IsFollowedBesideAFaceThatFillsThePicture) {
  std::vector<Image8> images;
  for (int i = 0; i < 12; ++i) {
    const Image8 whole = board(0.0015 * i, -0.001 * i, 0);
    constexpr int kHeight = 116;  // px: the chin lies on the last row
    Image8 cut(whole.width, kHeight, 1);
    std::copy_n(whole.data.begin(), cut.data.size(), cut.data.begin());
    images.push_back(std::move(cut));
  }
  BoardClip clip = show(std::move(images));
  for (TorsoFrame& f : clip.frames) f.intrinsics.height = clip.images[0].height;
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  ASSERT_TRUE(track->has_torso);
  const Vec3d shoulder(0.12, -0.06, 0.04);
  const Vec3d moved = track->world_from_torso[9] * shoulder - track->world_from_torso[2] * shoulder;
  EXPECT_NEAR(moved.x(), 0.0105, 0.002);
  EXPECT_NEAR(moved.y(), -0.007, 0.002);
}

TEST(Torso, FollowsARollInThePicture) {
  std::vector<Vec3d> motions;
  for (int i = 0; i < 12; ++i) motions.push_back({0, 0, 0.006 * i});
  const BoardClip clip = make_clip(motions);
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  const Mat3d off = track->world_from_torso[9].linear() * track->world_from_torso[2].linear().transpose();
  EXPECT_NEAR(vector_from_turn(off).z(), 0.042, 0.012);
}

TEST(Torso, ComesNearerOnlyWhereTheCameraMayHave) {
  std::vector<Image8> images;
  for (int i = 0; i < 12; ++i) images.push_back(board(0.001 * i, 0, 0, 0, 0.012 * i));
  BoardClip clip = show(std::move(images));
  for (std::size_t i = 0; i < clip.frames.size(); ++i)  // the camera draws back: from the head, too
    clip.frames[i].world_from_head.translation().z() += 0.012 * double(i);
  TorsoOptions options;
  options.approaches = true, options.deform = false;
  const auto track = track_torso(clip.frames, kChin, {}, {}, options);
  ASSERT_TRUE(track.ok());
  const auto moved = [](const TorsoTrack& t, int from, int to) {
    const Vec3d chest(0, -0.2, 0.04);
    return Vec3d(t.world_from_torso[std::size_t(to)] * chest - t.world_from_torso[std::size_t(from)] * chest);
  };
  for (const int i : {0, 4, 11}) {
    EXPECT_NEAR(moved(*track, 6, i).z(), 0.012 * (i - 6), 0.003) << i;
    EXPECT_NEAR(moved(*track, 6, i).x(), 0.001 * (i - 6), 0.001) << i;
  }
  options.approaches = false;
  const auto still = track_torso(clip.frames, kChin, {}, {}, options);
  ASSERT_TRUE(still.ok());
  for (const int i : {0, 11}) EXPECT_EQ(moved(*still, 6, i).z(), 0);
  EXPECT_LT(track->residual_after, 0.5 * still->residual_after);
}

TEST(Torso, StaysAtRestWhereThePictureShowsNoMotion) {
  BoardClip clip = make_clip({{0, 0, 0}, {0, 0, 0}});
  for (TorsoFrame& f : clip.frames)
    f.world_from_head = facing_pose(0, 0, {0, 0.15, 0.7});  // the chin at the lower edge
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  EXPECT_FALSE(track->has_torso);
  EXPECT_EQ(track->world_from_torso.size(), 2u);
}

// Where a point of the canonical torso is in a frame, world.
Vec3d posed_place(const TorsoTrack& track, std::size_t frame, const Vec3d& canonical) {
  const auto d = posed_displacement(track.modes, track.shapes[frame]);
  const GridPlace at = place_in(track.modes.grid, float(canonical.x()), float(canonical.y()));
  Vec3d p = canonical;
  for (std::size_t k = 0; k < 4; ++k)
    for (int c = 0; c < 2; ++c)
      p[c] += double(at.weight[k]) * d[2 * std::size_t(at.node[k]) + std::size_t(c)];
  return track.world_from_torso[frame] * p;
}

TEST(Torso, FollowsADeformationThatTrainingFramesShow) {
  const BoardClip clip = sagging_clip();
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  ASSERT_FALSE(track->modes.empty());
  EXPECT_LT(track->residual_after, 0.5 * track->residual_rigid);
  for (const double x : {-0.12, 0.12}) {
    const Vec3d canonical = inverse(clip.frames[0].world_from_head) * Vec3d(x, 0.1, kDepth);
    for (const int i : {7, 16, 31, 34}) {
      const Vec3d moved = posed_place(*track, std::size_t(i), canonical) - posed_place(*track, 2, canonical);
      EXPECT_NEAR(moved.x(), shift_of(i) - shift_of(2), 0.0012) << "frame " << i << " at " << x;
      EXPECT_NEAR(moved.y(), (sag_of(i) - sag_of(2)) * sunk(x), 0.0012) << "frame " << i << " at " << x;
    }
  }
}

// The head's shadow on the chest: the picture above a soft edge, which keeps `left` of itself.
Image8 shadowed(const Image8& picture, double edge, double left) {
  Image8 made = picture;
  for (int y = 0; y < made.height; ++y)
    for (int x = 0; x < made.width; ++x) {
      std::uint8_t& value = made.at(x, y)[0];
      value = std::uint8_t(std::lround(value * (1 - (1 - left) / (1 + std::exp((y - edge) / 12)))));
    }
  return made;
}

TEST(Torso, ShadowDoesNotMoveIt) {
  const BoardClip lit = sagging_clip();
  std::vector<Image8> images = lit.images;
  for (std::size_t i = 30; i < images.size(); ++i) images[i] = shadowed(images[i], 215, 0.5);
  BoardClip clip = show(std::move(images));
  for (std::size_t i = 30; i < clip.frames.size(); ++i) clip.frames[i].held_out = true;
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  for (const double x : {-0.12, 0.12}) {
    const Vec3d canonical = inverse(clip.frames[0].world_from_head) * Vec3d(x, 0.1, kDepth);
    for (const int i : {31, 34}) {
      const Vec3d moved = posed_place(*track, std::size_t(i), canonical) - posed_place(*track, 2, canonical);
      EXPECT_NEAR(moved.x(), shift_of(i) - shift_of(2), 0.0012) << "frame " << i << " at " << x;
      EXPECT_NEAR(moved.y(), (sag_of(i) - sag_of(2)) * sunk(x), 0.0012) << "frame " << i << " at " << x;
    }
  }
}

TEST(Torso, HeldOutPicturesChangeNothingThatIsShared) {
  const BoardClip clip = sagging_clip();
  const auto track = track_torso(clip.frames, kChin, {}, {});
  BoardClip other = sagging_clip();
  for (std::size_t i = 30; i < 36; ++i) other.images[i] = board(-0.01, 0.01, 0.05, -1);
  const auto changed = track_torso(other.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok() && changed.ok());
  EXPECT_EQ(track->modes.mean, changed->modes.mean);
  EXPECT_EQ(track->modes.modes, changed->modes.modes);
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(track->world_from_torso[i].matrix(), changed->world_from_torso[i].matrix());
    EXPECT_EQ(track->shapes[i], changed->shapes[i]);
  }
  EXPECT_NE(track->world_from_torso[33].matrix(), changed->world_from_torso[33].matrix());
}

TEST(Torso, TheSamePicturesGiveTheSameBits) {
  const BoardClip clip = sagging_clip();
  const auto once = track_torso(clip.frames, kChin, {}, {}), twice = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(once.ok() && twice.ok());
  for (std::size_t i = 0; i < clip.frames.size(); ++i) {
    EXPECT_EQ(once->world_from_torso[i].matrix(), twice->world_from_torso[i].matrix());
    EXPECT_EQ(once->shapes[i], twice->shapes[i]);
  }
}

TEST(Torso, StopsWhenAsked) {
  const BoardClip clip = sagging_clip();
  std::stop_source stop;
  stop.request_stop();
  const auto track = track_torso(clip.frames, kChin, {}, stop.get_token());
  ASSERT_FALSE(track.ok());
  EXPECT_EQ(track.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
