// Claims about seen views: they are where the camera stands from the head, of training frames alone.
#include "core/project/seen_views.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/render/camera_path.h"
#include "tests/core/export/tiny_project.h"
#include "tests/core/lab/truth/acted_track.h"

namespace likeness::test {
namespace {

TEST(SeenViews, AreWhereTheCameraStandsFromTheHead) {
  const Avatar avatar = filmed_avatar();
  const ViewAngle front = view_angle(avatar.cam_from_world * avatar.world_from_head);
  EXPECT_NEAR(front.yaw, 0, 1e-9);
  EXPECT_NEAR(front.pitch, 0, 1e-9);
  EXPECT_NEAR(front.roll, 0, 1e-9);
  // Seen from the head's own origin instead of its centre, so only nearly.
  const ViewAngle orbit = view_angle(orbit_camera(avatar, avatar.world_from_head, 0.4, 0.2).cam_from_world *
                                     avatar.world_from_head);
  EXPECT_NEAR(orbit.yaw, 0.4, 0.03);
  EXPECT_NEAR(orbit.pitch, 0.2, 0.03);
  const Vec3d origin = Vec3d::Zero();
  EXPECT_NEAR(view_angle(avatar.cam_from_world * turned_head(avatar.world_from_head, origin, 0.3, 0, 0)).yaw,
              -0.3, 1e-9);
  EXPECT_NEAR(
      view_angle(avatar.cam_from_world * turned_head(avatar.world_from_head, origin, 0, 0.3, 0)).pitch, 0.3,
      1e-9);
  EXPECT_NEAR(view_angle(avatar.cam_from_world * turned_head(avatar.world_from_head, origin, 0, 0, 0.3)).roll,
              0.3, 1e-9);
}

TEST(SeenViews, KnowHowFarTheNearestIs) {
  TrackTruth acted = acted_truth(80);
  Capture capture;
  capture.width = capture.height = 512, capture.crop = {0, 0, 512};
  for (const TrackedFrame& frame : acted.track.frames)
    capture.frames.push_back({frame.frame, frame.time_s, 1, frame.frame >= 70, frame.frame < 70, ""});
  acted.track.frames[3].status = FrameStatus::lost;
  const SeenViews seen = seen_views(capture, acted.cameras, acted.track);
  EXPECT_EQ(seen.views.size(), 69u);  // neither the held-out ones nor the lost one
  EXPECT_NEAR(seen.low.yaw, -0.5, 0.06);
  EXPECT_NEAR(seen.high.yaw, 0.5, 0.06);
  EXPECT_LT(from_nearest_view(seen, seen.views[5].yaw, seen.views[5].pitch), 1e-6);
  EXPECT_NEAR(from_nearest_view(seen, std::numbers::pi / 2, 0), std::numbers::pi / 2 - 0.5, 0.1);
  EXPECT_DOUBLE_EQ(from_nearest_view({}, 0, 0), std::numbers::pi);
}

}  // namespace
}  // namespace likeness::test
