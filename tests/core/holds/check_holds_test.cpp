// Claims about the check of what holds: a head that is painted on holds everywhere; each fault that is put in
// ends the range where it was put, and only there; a stop stops it.
#include "core/holds/check_holds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/head/action_amounts.h"
#include "tests/core/holds/painted_head.h"

namespace likeness::test {
namespace {

Result<HoldCheck> check_painted(const SpoilPicture& spoil = {}, const Progress& progress = Progress(),
                                std::stop_token stop = {}) {
  const RenderPlace place{std::make_shared<PaintedBackend>(spoil), false, {}};
  return check_holds(painted_avatar(), painted_model(), place, {160}, progress, stop);
}

double yaw_of(const Camera& camera) {
  const Vec3d at = inverse(camera.cam_from_world).translation();
  return std::atan2(at.x(), at.z()) * 180 / std::numbers::pi;
}

const HeldAction& held(const HoldCheck& check, const std::string& name) {
  return *std::ranges::find(check.range.actions, name, &HeldAction::name);
}

TEST(CheckHolds, APaintedHeadHoldsFromEverySide) {
  const auto check = check_painted();
  ASSERT_TRUE(check.ok()) << check.error().what;
  EXPECT_NEAR(check->typical_yaw_deg, 0, 1e-6);
  const HoldingRange& range = check->range;
  EXPECT_EQ(range.yaw_low.fault, "");
  EXPECT_EQ(range.yaw_high.fault, "");
  EXPECT_EQ(range.pitch_low.fault, "");
  EXPECT_EQ(range.pitch_high.fault, "");
  EXPECT_LE(range.yaw_low.deg, -45);
  EXPECT_GE(range.yaw_high.deg, 45);
  EXPECT_LE(range.pitch_low.deg, -25);
  EXPECT_GE(range.pitch_high.deg, 25);
  EXPECT_EQ(held(*check, "jawOpen").amount, 1) << held(*check, "jawOpen").fault;
  EXPECT_EQ(held(*check, "mouthSmile").amount, 1) << held(*check, "mouthSmile").fault;
  for (const AskedAction& asked : asked_actions())
    EXPECT_TRUE(std::ranges::any_of(check->actions, [&](const TriedAction& t) {
      return t.asked.name == asked.name && t.asked.amount == asked.amount;
    })) << asked.name;
}

TEST(CheckHolds, AColourThatDriftsOnOneSideEndsItThere) {
  const auto check = check_painted([](const Camera& camera, const RenderState&, PaintedPicture& picture) {
    if (yaw_of(camera) < 20) return;
    for (std::size_t i = 0; i < picture.rgb.data.size(); i += 3) picture.rgb.data[i] += 0.05f;
  });
  ASSERT_TRUE(check.ok());
  EXPECT_GE(check->range.yaw_high.deg, 15);
  EXPECT_LT(check->range.yaw_high.deg, 30);
  EXPECT_EQ(check->range.yaw_high.fault, "drift");
  EXPECT_LE(check->range.yaw_low.deg, -45);
  EXPECT_GE(check->range.pitch_high.deg, 25);
}

TEST(CheckHolds, PiecesBesideTheHeadEndItWhereTheyAppear) {
  const auto check = check_painted([](const Camera& camera, const RenderState&, PaintedPicture& picture) {
    if (yaw_of(camera) > -35) return;
    for (int y = 10; y < 40; ++y)
      for (int x = 2; x < 32; ++x) *picture.alpha.at(x, y) = 1;
  });
  ASSERT_TRUE(check.ok());
  EXPECT_LE(check->range.yaw_low.deg, -30);
  EXPECT_GT(check->range.yaw_low.deg, -45);
  EXPECT_TRUE(check->range.yaw_low.fault == "loose" || check->range.yaw_low.fault == "outside")
      << check->range.yaw_low.fault;
  EXPECT_GE(check->range.yaw_high.deg, 45);
}

TEST(CheckHolds, AForeheadThatAnswersToTheJawEndsTheJawAlone) {
  const ActionBasis basis = action_basis(painted_model());
  const int jaw = action_index(basis, "jawOpen");
  const auto check = check_painted([&](const Camera&, const RenderState& state, PaintedPicture& picture) {
    const float open = face_amounts(basis, state.pose.articulation)[jaw];
    if (open < 0.7f) return;
    for (int y = 0; y < picture.rgb.height / 2; ++y)
      for (int x = 0; x < picture.rgb.width; ++x) picture.rgb.at(x, y)[1] += 0.04f;
  });
  ASSERT_TRUE(check.ok());
  EXPECT_GE(held(*check, "jawOpen").amount, 0.5f);
  EXPECT_LT(held(*check, "jawOpen").amount, 0.9f);
  EXPECT_FALSE(held(*check, "jawOpen").fault.empty());
  EXPECT_EQ(held(*check, "mouthPucker").amount, 1) << held(*check, "mouthPucker").fault;
}

TEST(CheckHolds, AMouthThatIsNotDarkInsideEndsTheJaw) {
  const auto check = check_painted([](const Camera&, const RenderState&, PaintedPicture& picture) {
    for (std::size_t i = 0; i < picture.rgb.data.size(); i += 3)
      if (picture.rgb.data[i] < 0.11f)
        picture.rgb.data[i] = 0.7f, picture.rgb.data[i + 1] = 0.5f, picture.rgb.data[i + 2] = 0.4f;
  });
  ASSERT_TRUE(check.ok());
  EXPECT_LT(held(*check, "jawOpen").amount, 1);
  EXPECT_EQ(held(*check, "jawOpen").fault, "mouth");
}

TEST(CheckHolds, ProgressRisesToItsEndAndAStopIsNoResult) {
  double last = 0;
  bool rises = true;
  const auto whole = check_painted({}, Progress([&](const ProgressReport& report) {
                                     rises &= report.fraction >= last;
                                     last = report.fraction;
                                   }));
  ASSERT_TRUE(whole.ok());
  EXPECT_TRUE(rises);
  EXPECT_EQ(last, 1);
  std::stop_source source;
  int pictures = 0;
  const auto stopped = check_painted(
      [&](const Camera&, const RenderState&, PaintedPicture&) {
        if (++pictures == 5) source.request_stop();
      },
      Progress(), source.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  EXPECT_EQ(pictures, 5);
}

}  // namespace
}  // namespace likeness::test
