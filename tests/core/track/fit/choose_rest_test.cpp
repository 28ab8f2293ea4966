// Claims about which frames are taken for a face at rest: from made-up courses of a mouth, and of the head
// model's own states.
#include "core/track/fit/choose_rest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

constexpr UsualMouth kUsual{
    .width = 1.45, .width_sigma = 0.2, .lift = -0.02, .lift_sigma = 0.04, .open = 0.01};

// What somebody does with their face, in eye gaps: see face_measures.h.
struct Deed {
  double width = 1.35, open = 0.03, lift = -0.02, brows = 0.5, lids = 1, aside = 0;
};
constexpr Deed kRest{};
constexpr Deed kSmile{.width = 1.65, .open = 0.02, .lift = 0.06};
constexpr Deed kGrin{.width = 1.72, .open = 0.3, .lift = 0.16};
constexpr Deed kPucker{.width = 1.05, .open = 0.05, .lift = -0.03};

// 25 frames a second, with a landmark predictor's noise.
std::vector<RestFrame> film(int count, const std::function<Deed(int)>& deed) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.01);
  std::vector<RestFrame> frames;
  for (int i = 0; i < count; ++i) {
    const Deed d = deed(i);
    RestFrame& f = frames.emplace_back();
    f.frame = i, f.time_s = i / 25.0, f.usable = true;
    f.face.mouth_width = d.width + noise(random);
    f.face.mouth_open = d.open + noise(random);
    f.face.corner_lift = d.lift + noise(random);
    f.face.brow_height = d.brows + noise(random);
    f.face.mouth_aside = d.aside + noise(random);
    f.face.turn = 0.05, f.face.sigma = 0.03;
    f.lids_known = true, f.lids = d.lids;
  }
  return frames;
}

// Syllables, four a second.
Deed speech(int i) {
  const double open = std::pow(std::sin(std::numbers::pi * i / 6.3), 2),
               vowel = std::sin(0.37 * i) * std::sin(0.11 * i);
  return {.width = 1.35 + 0.15 * vowel, .open = 0.03 + 0.25 * open, .lift = -0.02 + 0.03 * vowel};
}

bool within(const RestChoice& choice, int first, int last) {
  return std::ranges::all_of(choice.frames, [&](int f) { return f >= first && f <= last; });
}

TEST(ChooseRest, FindsTwelveCalmFramesOfSomeoneWhoSmilesThroughTheClip) {
  for (const Deed& smile : {kSmile, kGrin}) {
    const auto frames = film(300, [&](int i) { return i >= 140 && i < 152 ? kRest : smile; });
    const RestChoice choice = choose_rest(frames, kUsual, {});
    EXPECT_GE(choice.frames.size(), 8u);
    EXPECT_TRUE(within(choice, 140, 151)) << choice.frames.front() << " " << choice.frames.back();
    EXPECT_EQ(choice.warning, "");
    EXPECT_EQ(choice.trust, 1);
    EXPECT_NE(choice.why.find("narrower"), std::string::npos) << choice.why;
  }
}

TEST(ChooseRest, APuckerIsRarerAndNarrower) {
  const auto frames = film(300, [&](int i) {
    return i < 60 ? kRest : i < 90 ? kPucker : i < 200 ? speech(i) : i < 240 ? kSmile : speech(i);
  });
  const RestChoice choice = choose_rest(frames, kUsual, {});
  EXPECT_TRUE(within(choice, 0, 60)) << choice.frames.front() << " " << choice.frames.back();
  EXPECT_EQ(choice.warning, "");
}

TEST(ChooseRest, TakesNoShutLidsNoRaisedBrowsAndNoMouthToOneSide) {
  const auto frames = film(300, [&](int i) {
    Deed deed = kRest;
    if (i % 10 < 2) deed.lids = 0.1;
    if (i >= 100 && i < 170) deed.brows = 0.75;
    if (i >= 200 && i < 240) deed.aside = 0.2;
    return deed;
  });
  const RestChoice choice = choose_rest(frames, kUsual, {});
  ASSERT_GE(choice.frames.size(), 8u);
  for (const int f : choice.frames) {
    EXPECT_GE(f % 10, 2) << f;
    EXPECT_FALSE(f >= 100 && f < 170) << f;
    EXPECT_FALSE(f >= 200 && f < 240) << f;
  }
}

TEST(ChooseRest, SomeoneWhoOnlyTalksIsWarnedOf) {
  const RestChoice choice = choose_rest(film(300, speech), kUsual, {});
  ASSERT_FALSE(choice.frames.empty());
  EXPECT_NE(choice.warning.find("never closed and calm"), std::string::npos) << choice.warning;
  EXPECT_LT(choice.trust, 0.8);
  double open = 0;  // the mouths are the most closed ones there are
  for (const int f : choice.frames) open += speech(f).open / double(choice.frames.size());
  EXPECT_LT(open, 0.12);
}

TEST(ChooseRest, APermanentSmileIsNotCalledRest) {
  const RestChoice closed = choose_rest(film(300, [](int) { return kSmile; }), kUsual, {}),
                   toothy = choose_rest(film(300, [](int) { return kGrin; }), kUsual, {});
  EXPECT_NE(toothy.warning.find("never closed"), std::string::npos) << toothy.warning;
  EXPECT_LE(toothy.trust, 0.5);
  const Deed broad{.width = 1.95, .open = 0.02, .lift = 0.1};
  const RestChoice smile = choose_rest(film(300, [&](int) { return broad; }), kUsual, {});
  EXPECT_NE(smile.warning.find("smile"), std::string::npos) << smile.warning;
  EXPECT_LT(smile.trust, 0.8);
}

TEST(ChooseRest, TheUsersWordDecides) {
  auto frames = film(100, [](int i) { return i < 50 ? kRest : kSmile; });
  frames[70].usable = false;
  const std::vector<int> named{60, 70, 61};
  const RestChoice choice = choose_rest(frames, kUsual, named);
  EXPECT_TRUE(choice.asked);
  EXPECT_EQ(choice.frames, (std::vector{60, 61}));
  const std::vector<int> hidden{70};
  const RestChoice other = choose_rest(frames, kUsual, hidden);
  EXPECT_FALSE(other.asked);
  EXPECT_TRUE(within(other, 0, 49));
  EXPECT_NE(other.warning.find("can be used"), std::string::npos);
}

TEST(ChooseRest, UnusableFramesDecideNothing) {
  auto frames = film(200, [](int i) { return i < 100 ? kRest : speech(i); });
  const RestChoice before = choose_rest(frames, kUsual, {});
  for (int i = 0; i < 100; ++i) {
    RestFrame more = frames[std::size_t(i)];
    more.frame += 200, more.time_s += 8, more.usable = false;
    more.face.mouth_width = 1.2;
    frames.push_back(more);
  }
  EXPECT_EQ(choose_rest(frames, kUsual, {}).frames, before.frames);
  for (RestFrame& f : frames) f.usable = false;
  EXPECT_TRUE(choose_rest(frames, kUsual, {}).frames.empty());
  EXPECT_TRUE(choose_rest({}, kUsual, {}).frames.empty());
}

// -- Measures

FaceState state_with(const char* action, float amount, double yaw, double pitch) {
  Articulation a = neutral_articulation(test_head());
  add_action(a, *find_action(test_head(), action), amount);
  FaceState state;
  state.cam_from_head = facing_pose(yaw, pitch, {0.01, 0.02, 0.6});
  state.expression = a.expression.cast<double>();
  state.jaw = a.jaw.x();
  return state;
}

TEST(FaceMeasures, ATurnOfTheHeadChangesNone) {
  const ReducedHead& head = test_reduced_head();
  const ReducedPerson person = reduced_person(head, Eigen::VectorXd::Zero(head.identity_count()));
  const FaceState front = state_with("jawOpen", 0, 0, 0);
  const FaceMeasures at_front =
      measure_face(head, person, observe_state(head, person, front, 0, 1), front.cam_from_head);
  const FaceState turned = state_with("jawOpen", 0, 0.4, -0.2);
  const FaceMeasures at_side =
      measure_face(head, person, observe_state(head, person, turned, 0, 1), turned.cam_from_head);
  EXPECT_NEAR(at_side.mouth_width, at_front.mouth_width, 1e-6);
  EXPECT_NEAR(at_side.mouth_open, at_front.mouth_open, 1e-6);
  EXPECT_NEAR(at_side.corner_lift, at_front.corner_lift, 1e-6);
  EXPECT_NEAR(at_side.brow_height, at_front.brow_height, 1e-6);
  EXPECT_GT(at_side.turn, at_front.turn + 0.3);
}

TEST(FaceMeasures, ASmileIsWideAPuckerNarrowAndRaisedBrowsAreHigh) {
  const ReducedHead& head = test_reduced_head();
  const ReducedPerson person = reduced_person(head, Eigen::VectorXd::Zero(head.identity_count()));
  const auto measured = [&](const char* left, const char* right) {
    FaceState state = state_with(left, 0.8f, 0.1, 0);
    if (right) state.expression += state_with(right, 0.8f, 0.1, 0).expression;
    return measure_face(head, person, observe_state(head, person, state, 0, 1), state.cam_from_head);
  };
  const FaceMeasures rest = measured("eyeBlink_L", nullptr), smile = measured("mouthSmile_L", "mouthSmile_R"),
                     pucker = measured("mouthPucker", nullptr), open = measured("jawOpen", nullptr),
                     brows = measured("browOuterUp_L", "browOuterUp_R");
  EXPECT_GT(smile.mouth_width, 1.1 * rest.mouth_width);
  EXPECT_GT(smile.corner_lift, rest.corner_lift + 0.05);
  EXPECT_LT(pucker.mouth_width, 0.9 * rest.mouth_width);
  EXPECT_GT(open.mouth_open, rest.mouth_open + 0.3);
  EXPECT_GT(brows.brow_height, rest.brow_height + 0.03);
}

TEST(FaceMeasures, PeoplesMouthsAreThoseOfTheModelsIdentities) {
  const UsualMouth usual = usual_mouth(test_reduced_head());
  const FaceMeasures mean =
      measure_state(test_reduced_head(), reduced_person(test_reduced_head(), Eigen::VectorXd::Zero(20)),
                    Eigen::VectorXd::Zero(test_reduced_head().expression_count()), 0);
  EXPECT_EQ(usual.width, mean.mouth_width);
  EXPECT_GT(usual.width_sigma, 0.05);
  EXPECT_LT(usual.width_sigma, 0.4);
  EXPECT_LT(usual.lift_sigma, 0.08);
}

}  // namespace
}  // namespace likeness
