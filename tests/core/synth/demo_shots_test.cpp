// Claims about the demo's cuts.
#include "core/synth/demo_shots.h"

#include <gtest/gtest.h>

#include <set>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"
#include "core/synth/performance.h"

namespace likeness {
namespace {

DemoOptions cut_film(int cuts, int frames = 240, int seed = 0) {
  return {.frames = frames, .seed = seed, .camera = DemoCamera::resting, .cuts = cuts};
}

TEST(DemoShots, FollowEachOtherWithoutGaps) {
  for (const int seed : {0, 1, 2, 9})
    for (const auto& [cuts, frames] :
         {std::pair(0, 12), std::pair(3, 48), std::pair(11, 12), std::pair(20, 300)}) {
      const auto shots = demo_shots(cut_film(cuts, frames, seed));
      ASSERT_EQ(int(shots.size()), cuts + 1);
      EXPECT_EQ(shots.front().first, 0);
      EXPECT_EQ(shots.back().last, frames - 1);
      for (std::size_t i = 0; i < shots.size(); ++i) {
        EXPECT_LE(shots[i].first, shots[i].last);
        if (i == 0) continue;
        EXPECT_EQ(shots[i].first, shots[i - 1].last + 1);
        EXPECT_GT(shots[i].dropped, shots[i - 1].dropped);
        EXPECT_NE(shots[i].kind, CutKind::opening);
      }
      for (int frame = 0; frame < frames; ++frame) {
        const DemoShot& shot = shot_of(shots, frame);
        EXPECT_TRUE(shot.first <= frame && frame <= shot.last);
      }
    }
}

TEST(DemoShots, ThreeCutsAreOfThreeKindsAndCamerasAreNumberedByPlaceAndCrop) {
  for (const int seed : {0, 1, 2}) {
    const auto shots = demo_shots(cut_film(3, 240, seed));
    std::set<CutKind> kinds;
    for (std::size_t i = 1; i < shots.size(); ++i) kinds.insert(shots[i].kind);
    EXPECT_EQ(kinds.size(), 3u) << seed;
    for (const DemoShot& a : shots)
      for (const DemoShot& b : shots)
        EXPECT_EQ(a.camera == b.camera, a.place == b.place && a.close == b.close);
  }
}

// In place the camera stays; a punch-in is the same view cropped; another angle has another view.
TEST(DemoShots, EachKindChangesTheCameraAsItSays) {
  const HeadModel model = make_builtin_head();
  const HeadShape shape = shape_head(model, Eigen::VectorXf::Zero(model.identity_count()));
  const DemoOptions options = cut_film(5);
  const auto shots = demo_shots(options);
  for (std::size_t i = 1; i < shots.size(); ++i) {
    const Shot before = perform(model, shape, options, shots[i].first - 1),
               after = perform(model, shape, options, shots[i].first);
    const bool same_pose = before.camera.cam_from_world.isApprox(after.camera.cam_from_world, 1e-9);
    const double zoom = after.camera.intrinsics.fx / before.camera.intrinsics.fx;
    switch (shots[i].kind) {
      case CutKind::jump:
        EXPECT_TRUE(same_pose);
        EXPECT_DOUBLE_EQ(zoom, 1);
        break;
      case CutKind::punch_in:
        EXPECT_TRUE(same_pose);
        EXPECT_GT(zoom, 1.2);
        break;
      case CutKind::punch_out:
        EXPECT_TRUE(same_pose);
        EXPECT_LT(zoom, 1 / 1.2);
        break;
      case CutKind::angle:
        EXPECT_GT(rotation_angle(Mat3d(before.camera.cam_from_world.linear() *
                                       after.camera.cam_from_world.linear().transpose())),
                  0.4);
        // The person has turned to it, so that the face is seen from the front again.
        EXPECT_GT((after.camera.cam_from_world.linear() * after.world_from_torso.linear() * Vec3d::UnitZ())
                      .dot(-Vec3d::UnitZ()),
                  0.95);
        break;
      case CutKind::opening:
        ADD_FAILURE() << "in the middle";
    }
  }
}

// Of the head against the torso's place: a cut is a larger step than any between two frames.
TEST(DemoShots, ThePoseJumpsAtCutsAndNowhereElse) {
  const HeadModel model = make_builtin_head();
  const HeadShape shape = shape_head(model, Eigen::VectorXf::Zero(model.identity_count()));
  const DemoOptions options = cut_film(4);
  const auto shots = demo_shots(options);
  std::set<int> cuts;
  for (std::size_t i = 1; i < shots.size(); ++i) cuts.insert(shots[i].first);
  double least_cut = 1e9, most_step = 0;
  for (int frame = 1; frame < options.frames; ++frame) {
    const Shot a = perform(model, shape, options, frame - 1), b = perform(model, shape, options, frame);
    const Mat3d head_a = a.world_from_torso.linear().transpose() * a.world_from_head.linear();
    const Mat3d head_b = b.world_from_torso.linear().transpose() * b.world_from_head.linear();
    const double step = rotation_angle(Mat3d(head_a.transpose() * head_b)) +
                        (a.articulation.expression - b.articulation.expression).cast<double>().norm();
    (cuts.contains(frame) ? least_cut : most_step) =
        cuts.contains(frame) ? std::min(least_cut, step) : std::max(most_step, step);
    if (cuts.contains(frame)) {
      EXPECT_GT(rotation_angle(Mat3d(head_a.transpose() * head_b)), 0.05) << frame;
    }
  }
  EXPECT_LT(most_step, 1.2);
}

TEST(DemoShots, WithoutCutsTheFilmIsThePerformance) {
  const DemoOptions options = cut_film(0);
  const auto shots = demo_shots(options);
  EXPECT_EQ(shots.size(), 1u);
  EXPECT_EQ(uncut(options, shots).frames, options.frames);
}

}  // namespace
}  // namespace likeness
