// Claims about heads fitted to a few looks, and about the patches in which their landmarks are sought.
#include "core/face/fit_looks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/rigid.h"
#include "core/camera/assumed_lens.h"
#include "core/face/face_patch.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

struct KnownLooks {
  std::vector<LandmarkLook> looks;
  std::vector<Vec3d> to_camera;
};

// A head that turns to both sides and up and down while its mouth opens.
KnownLooks known_looks(const Intrinsics& lens, int count) {
  const ReducedHead& head = test_reduced_head();
  const ReducedPerson person = reduced_person(head, Eigen::VectorXd::Zero(head.identity_count()));
  KnownLooks known;
  for (int i = 0; i < count; ++i) {
    FaceState truth;
    truth.cam_from_head = facing_pose(0.6 * std::sin(0.7 * i), 0.25 * std::cos(0.5 * i), {0.02, 0.01, 0.7});
    truth.expression = Eigen::VectorXd::Zero(head.expression_count());
    truth.jaw = 0.1 + 0.1 * std::sin(0.3 * i);
    FaceObservation seen = observe_state(head, person, truth, 0.5, std::uint32_t(i));
    const JawLine line = pick_jaw_line(head, person, seen, truth);
    for (int k = 0; k < kJawLineCount; ++k)
      seen.rays[k] =
          (truth.cam_from_head * reduced_point(head, person, line.point[k], truth.expression, truth.jaw))
              .hnormalized();
    LandmarkLook& look = known.looks.emplace_back();
    look.frame = 5 * i;
    for (int k = 0; k < kLandmarkCount; ++k)
      look.landmarks.points[k] = project<double>(lens, seen.rays[k].homogeneous());
    known.to_camera.push_back(inverse(truth.cam_from_head).translation().normalized());
  }
  return known;
}

TEST(FitLooks, TellsFromWhereEachLookSeesTheHead) {
  const Intrinsics lens = assumed_intrinsics(720, 1280, 0);
  const KnownLooks known = known_looks(lens, 24);
  const auto states = fit_looks(test_head(), lens, known.looks, {}, {});
  ASSERT_TRUE(states.ok()) << states.error().what;
  ASSERT_EQ(states->size(), known.looks.size());
  for (std::size_t i = 0; i < states->size(); ++i) {
    const double off = std::acos(std::min(1.0, direction_to_camera((*states)[i]).dot(known.to_camera[i])));
    EXPECT_LT(off * 180 / std::numbers::pi, 2.5) << i;
  }
}

TEST(FitLooks, SaysNothingOfTwoLooksAndStopsWhenAsked) {
  const Intrinsics lens = assumed_intrinsics(512, 512, 0);
  const KnownLooks known = known_looks(lens, 8);
  const auto two = fit_looks(test_head(), lens, std::span(known.looks).first(2), {}, {});
  ASSERT_TRUE(two.ok());
  EXPECT_TRUE(two->empty());
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = fit_looks(test_head(), lens, known.looks, {}, stop.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

TEST(FacePatch, HoldsTheFaceInThePlaceThatItSays) {
  Image8 picture(1600, 1200, 1);
  for (int y = 0; y < 1200; ++y)
    for (int x = 0; x < 1600; ++x) *picture.at(x, y) = std::uint8_t((x / 40 + y / 40) % 2 ? 200 : 40);
  for (const double width : {150.0, 420.0}) {  // the second is reduced
    const FaceBox face{500.25, 360.5, width, width, 1};
    const FacePatch patch = cut_face_patch(picture, face);
    EXPECT_LE(std::max(patch.luma.width, patch.luma.height), 640);
    EXPECT_EQ(patch.scale > 1, width > 300);
    EXPECT_NEAR(patch.x + patch.face.x * patch.scale, face.x, 1e-9);
    EXPECT_NEAR(patch.y + patch.face.y * patch.scale, face.y, 1e-9);
    EXPECT_NEAR(patch.face.width * patch.scale, face.width, 1e-9);
    const int x = int(patch.face.x + 0.5 * patch.face.width), y = int(patch.face.y + 0.5 * patch.face.height);
    const int sx = int(patch.x + (x + 0.5) * patch.scale), sy = int(patch.y + (y + 0.5) * patch.scale);
    EXPECT_NEAR(*patch.luma.at(x, y), *picture.at(sx, sy), 40);
  }
}

}  // namespace
}  // namespace likeness
