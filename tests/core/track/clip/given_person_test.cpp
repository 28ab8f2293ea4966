// Claims about a person whose shape is known from elsewhere: it is held to the bit, and the head is found at
// least as well as with a shape that was fitted.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <numbers>
#include <random>

#include "core/base/rigid.h"
#include "core/face/landmarks.h"
#include "core/face/reduced_head.h"
#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"
#include "core/synth/demo_capture.h"
#include "core/track/clip/track_clip.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

TEST(ReduceHead, KeepsAPersonsOffsetsOutsideTheIdentityDirections) {
  const HeadModel model = make_builtin_head();
  std::mt19937 engine(4);
  std::normal_distribution<float> normal;
  PersonShape person;
  person.identity.resize(model.identity_count());
  for (float& value : person.identity) value = normal(engine);
  for (int v = 0; v < model.vertex_count(); ++v)
    person.offsets.emplace_back(0.001f * std::sin(float(v)), 0, 0);
  constexpr int kKept = 3;
  const ReducedHead head = reduce_head(model, kKept, person);
  ASSERT_EQ(head.identity_count(), kKept);
  const ReducedPerson reduced = reduced_person(head, person.identity.head(kKept).cast<double>());
  const auto whole = landmark_positions(model, shape_head(model, person).vertices);
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(head.expression_count());
  for (int k = 0; k < kLandmarkCount; ++k)
    EXPECT_LT((reduced_point(head, reduced, k, rest, 0).cast<float>() - whole[std::size_t(k)]).norm(), 1e-6f)
        << k;
}

struct Off {
  double turn_deg = 0, place_m = 0;  // means over the frames
};

Off off_from(const Track& track, const Track& truth) {
  Off off;
  for (const TrackedFrame& frame : track.frames) {
    const TrackedFrame* own = find_tracked(truth, frame.frame);
    EXPECT_NE(own, nullptr);
    const Pose &a = frame.pose.world_from_head, &b = own->pose.world_from_head;
    off.turn_deg += vector_from_turn(a.linear() * b.linear().transpose()).norm() * 180 / std::numbers::pi /
                    double(track.frames.size());
    off.place_m += (a.translation() - b.translation()).norm() / double(track.frames.size());
  }
  return off;
}

TEST(TrackClip, KeepsAGivenTrueShapeAndPlacesTheHeadAsWell) {
  if (auto detector = FaceDetector::load(); !detector) GTEST_SKIP() << detector.error().what;
  std::string name = (fs::temp_directory_path() / "likeness_given_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path folder = name;
  DemoOptions demo;
  demo.width = demo.height = 320;
  demo.frames = 24;
  demo.moving_share = 0;
  demo.samples_per_pixel = 1;
  ASSERT_TRUE(write_demo_capture(folder, demo, Progress(), {}).ok());
  const auto truth = read_track(folder / "track_truth.json");
  const auto cameras = read_cameras(folder / "cameras_truth.json");
  ASSERT_TRUE(truth.ok() && cameras.ok());
  const HeadModel model = make_builtin_head();
  const TrackRegion region{0, 0, demo.width, demo.height};
  TrackOptions options;
  const auto fitted = track_clip(folder / "demo.mp4", region, *cameras, {}, model, options, Progress(), {});
  options.person = truth->person;
  const auto given = track_clip(folder / "demo.mp4", region, *cameras, {}, model, options, Progress(), {});
  fs::remove_all(folder);
  ASSERT_TRUE(fitted.ok()) << fitted.error().what;
  ASSERT_TRUE(given.ok()) << given.error().what;

  EXPECT_EQ(given->person.identity, truth->person.identity);
  EXPECT_EQ(given->person.offsets, truth->person.offsets);
  EXPECT_NE(fitted->person.identity, truth->person.identity);
  const Off with = off_from(*given, *truth), without = off_from(*fitted, *truth);
  RecordProperty("turn_deg", std::to_string(with.turn_deg) + " of " + std::to_string(without.turn_deg));
  RecordProperty("place_m", std::to_string(with.place_m) + " of " + std::to_string(without.place_m));
  // Landmarks have an error of their own, which a shape that is fitted takes up in part.
  EXPECT_LE(with.turn_deg, 1.1 * without.turn_deg) << "degrees";
  EXPECT_LE(with.place_m, without.place_m) << "m";
}

}  // namespace
}  // namespace likeness
