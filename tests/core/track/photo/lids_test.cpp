// Claims about lids read from pixels, on drawn eyes whose opening is known and whose landmarks never blink.
#include "core/track/photo/lids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/face/fit_clip.h"
#include "core/scene/mesh_scene.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

constexpr int kLidSize = 224, kViews = 64, kHeldOut = 8;

Intrinsics lid_lens() {
  return {kLidSize, kLidSize, 2.2 * kLidSize, 2.2 * kLidSize, kLidSize / 2.0, kLidSize / 2.0};
}

struct Look {
  double skin = 165, white = 205, iris = 70, noise = 4;
  bool glasses = false;
  double gaze = 0.3;     // rad to either side
  bool seldom = false;   // one blink of two frames
  double shut_left = 0;  // level of the left lid where it is shut, without lashes; 0: as the skin
};

EyeBalls eyes() { return eye_balls(test_head(), test_shape()); }

std::array<Vec2d, kLandmarkCount> landmarks_of(const Articulation& face, const Pose& pose) {
  const auto points = landmark_positions(test_head(), pose_head(test_head(), test_shape(), face));
  std::array<Vec2d, kLandmarkCount> px;
  for (int k = 0; k < kLandmarkCount; ++k)
    px[k] = project<double>(lid_lens(), Vec3d(pose * points[k].cast<double>()));
  return px;
}

double line_distance(const Vec2d& p, const Vec2d& a, const Vec2d& b) {
  const Vec2d d = b - a;
  const double t = std::clamp((p - a).dot(d) / std::max(1e-9, d.squaredNorm()), 0.0, 1.0);
  return (p - a - t * d).norm();
}

// Lashes along the upper margin; rims round the eyes and a glint that wanders over the glass.
void draw_over(const Look& look, const std::array<Vec2d, kLandmarkCount>& lids, int number, Image8& grey) {
  for (int side = 0; side < 2; ++side) {
    const int first = 36 + 6 * side;
    const Vec2d middle = 0.5 * (lids[first] + lids[first + 3]);
    const double width = (lids[first] - lids[first + 3]).norm();
    const Vec2d glint = middle + 0.3 * width * Vec2d(std::sin(number), 0.5 * std::cos(2.0 * number));
    for (int y = 0; y < kLidSize; ++y)
      for (int x = 0; x < kLidSize; ++x) {
        const Vec2d p(x + 0.5, y + 0.5), off = (p - middle) / width;
        for (int k = 0; k < 3; ++k)
          if (line_distance(p, lids[first + k], lids[first + k + 1]) < 0.035 * width) *grey.at(x, y) = 30;
        if (!look.glasses) continue;
        if (std::abs(std::hypot(off.x(), 1.3 * off.y()) - 0.82) < 0.05) *grey.at(x, y) = 25;
        if (std::abs(p.x() - glint.x()) < 0.07 * width && std::abs(p.y() - glint.y()) < 0.12 * width)
          *grey.at(x, y) = 250;
      }
  }
}

Image8 draw(const Look& look, const Articulation& face, const Pose& pose, int number) {
  const std::vector<Vec3f> posed = pose_head(test_head(), test_shape(), face);
  const Raster raster = rasterise(posed, test_head().triangles, lid_lens(), pose);
  Image8 grey(kLidSize, kLidSize, 1, 90);
  for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
    if (raster.triangle[i] < 0) continue;
    const Triangle& t = test_head().triangles[raster.triangle[i]];
    const HeadPart part = test_head().parts[t[0]];
    double level = look.skin;
    if (part == HeadPart::left_eyeball || part == HeadPart::right_eyeball) {
      Vec3f rest = Vec3f::Zero();
      for (int k = 0; k < 3; ++k) rest += raster.barycentric[i][k] * test_shape().vertices[t[k]];
      const int joint = part == HeadPart::left_eyeball ? kLeftEye : kRightEye;
      const float share =
          std::acos(std::min(1.0f, (rest - test_shape().joints[joint]).normalized().z())) / std::asin(0.49f);
      level = share < 0.4f ? 20 : share < 1 ? look.iris : look.white;
    }
    grey.data[i] = static_cast<std::uint8_t>(std::clamp(level, 0.0, 255.0));
  }
  draw_over(look, landmarks_of(face, pose), number, grey);
  std::mt19937 random(number);
  std::normal_distribution<double> normal(0, look.noise);
  for (std::uint8_t& v : grey.data) v = static_cast<std::uint8_t>(std::clamp(v + normal(random), 0.0, 255.0));
  return grey;
}

// Covers the left eye with a lid of another level.
void whiten_left(const Look& look, const std::array<Vec2d, kLandmarkCount>& lids, int number, Image8& grey) {
  const Vec2d middle = 0.5 * (lids[42] + lids[45]), along = lids[45] - lids[42];
  const double width = along.norm();
  const Vec2d x_axis = along / width, y_axis(-x_axis.y(), x_axis.x());
  std::mt19937 random(1000 + number);
  std::normal_distribution<double> normal(0, look.noise);
  for (int y = 0; y < kLidSize; ++y)
    for (int x = 0; x < kLidSize; ++x) {
      const Vec2d off = (Vec2d(x + 0.5, y + 0.5) - middle) / width;
      if (std::hypot(off.dot(x_axis) / 0.5, (off.dot(y_axis) + 0.06) / 0.3) < 1)
        *grey.at(x, y) = static_cast<std::uint8_t>(std::clamp(look.shut_left + normal(random), 0.0, 255.0));
    }
}

// Blinks of five frames, every thirteenth; the gaze wanders, and is lowered with its lids from 40 to 46.
struct LidClip {
  std::vector<double> blink;
  std::vector<bool> lowered;
  std::vector<Image8> greys;
  std::vector<LidView> views;
};

LidClip make_lid_clip(const Look& look) {
  constexpr std::array<double, 5> kBlink{0.4, 0.95, 1, 0.7, 0.3};
  LidClip clip;
  for (int i = 0; i < kViews; ++i) {
    const bool lowered = i >= 40 && i < 46;
    const double blink = look.seldom                             ? (i == 30 || i == 31)
                         : !lowered && i % 13 >= 4 && i % 13 < 9 ? kBlink[i % 13 - 4]
                                                                 : 0;
    const Pose pose = facing_pose(0.35 * std::sin(0.4 * i), 0.1 * std::cos(0.3 * i), Vec3d(0, 0.03, 0.5));
    Articulation face = neutral_articulation(test_head());
    face.left_eye = face.right_eye =
        eye_rotation({look.gaze * std::sin(1.7 * i), lowered ? -0.35 : 0.1 * std::cos(1.1 * i), 0, {}});
    for (const char* side : {"L", "R"}) {
      add_action(face, *find_action(test_head(), std::string("eyeBlink_") + side), static_cast<float>(blink));
      if (lowered) add_action(face, *find_action(test_head(), std::string("eyeLookDown_") + side), 0.8f);
    }
    clip.blink.push_back(blink);
    clip.lowered.push_back(lowered);
    clip.greys.push_back(draw(look, face, pose, i));
    if (look.shut_left > 0 && blink > 0.9)
      whiten_left(look, landmarks_of(neutral_articulation(test_head()), pose), i, clip.greys.back());
    LidView view;
    view.intrinsics = lid_lens();
    view.cam_from_head = pose;
    view.landmarks = landmarks_of(neutral_articulation(test_head()), pose);
    view.held_out = i + kHeldOut >= kViews;
    clip.views.push_back(view);
  }
  for (int i = 0; i < kViews; ++i) clip.views[i].grey = &clip.greys[i];
  return clip;
}

void expect_followed(const Look& look) {
  const LidClip clip = make_lid_clip(look);
  const auto read = read_lids(eyes(), clip.views, {});
  ASSERT_TRUE(read);
  for (int side = 0; side < 2; ++side)
    for (int i = 0; i < kViews; ++i) {
      const LidOpening& lid = read->frames[i][side];
      ASSERT_TRUE(lid.known) << i;
      if (clip.blink[i] > 0.9) {
        EXPECT_LT(lid.opening, 0.3) << "closed, frame " << i << " eye " << side;
      } else if (clip.lowered[i]) {
        EXPECT_GT(lid.opening, 0.5) << "lowered, frame " << i << " eye " << side;
      } else if (clip.blink[i] == 0) {
        EXPECT_GT(lid.opening, 0.75) << "open, frame " << i << " eye " << side;
      }
    }
}

TEST(Lids, AreFollowedThroughBlinksThatTheLandmarksMiss) { expect_followed({}); }

TEST(Lids, AreFollowedOnDarkSkin) { expect_followed({.skin = 75, .white = 150, .iris = 35}); }

TEST(Lids, AreFollowedBehindGlassesWithGlints) { expect_followed({.glasses = true}); }

// The left lid, where it is shut, is as bright as the white of the eye: by itself it looks torn open.
TEST(Lids, ShutEyeAsBrightAsItsWhiteIsReadFromTheOther) {
  for (const Look& look : {Look{.white = 175, .gaze = 0.6, .seldom = true, .shut_left = 185},
                           Look{.white = 190, .gaze = 0.6, .seldom = true, .shut_left = 185}}) {
    const LidClip clip = make_lid_clip(look);
    const auto read = read_lids(eyes(), clip.views, {});
    ASSERT_TRUE(read);
    for (const int i : {30, 31})
      for (int side = 0; side < 2; ++side)
        EXPECT_LT(read->frames[i][side].opening, 0.35)
            << i << " eye " << side << " white " << look.white << " gaze " << look.gaze;
  }
}

TEST(Lids, HeldOutPicturesTeachTrainingFramesNothing) {
  LidClip clip = make_lid_clip({});
  const auto before = read_lids(eyes(), clip.views, {});
  for (int i = kViews - kHeldOut; i < kViews; ++i)
    for (std::uint8_t& v : clip.greys[i].data) v = static_cast<std::uint8_t>(255 - v);
  const auto after = read_lids(eyes(), clip.views, {});
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->usual_gap_m, after->usual_gap_m);
  for (int i = 0; i < kViews - kHeldOut; ++i)
    for (int side = 0; side < 2; ++side) {
      EXPECT_EQ(before->frames[i][side].opening, after->frames[i][side].opening);
      EXPECT_EQ(before->frames[i][side].sigma, after->frames[i][side].sigma);
    }
}

TEST(Lids, HandlesFewViewsAndAStop) {
  LidClip clip = make_lid_clip({});
  clip.views.resize(3);
  const auto few = read_lids(eyes(), clip.views, {});
  ASSERT_TRUE(few);
  EXPECT_FALSE(few->frames[0][0].known || few->frames[0][1].known);
  std::stop_source source;
  source.request_stop();
  EXPECT_FALSE(read_lids(eyes(), clip.views, source.get_token()));
}

// Three frames of closed lids, which the landmarks do not show: the fit closes them, and only then.
TEST(Lids, AsEvidenceCloseTheEyesOfThreeFrames) {
  const ReducedHead& head = test_reduced_head();
  const Eigen::VectorXd identity = Eigen::VectorXd::Zero(head.identity_count());
  const ReducedPerson person = reduced_person(head, identity);
  const ExpressionPrior prior = expression_prior(test_head());
  FaceState open;
  open.expression = Eigen::VectorXd::Zero(head.expression_count());
  open.cam_from_head = facing_pose(0.1, 0, Vec3d(0, 0.02, 0.5));
  const std::array<double, 2> usual{lid_gap(head, person, 0, open.expression),
                                    lid_gap(head, person, 1, open.expression)};
  std::vector<FaceFrame> frames(15);
  for (int i = 0; i < 15; ++i) {
    FaceFrame& f = frames[i];
    f.frame = i;
    f.seen = f.pose_given = true;
    f.state = open;
    f.observation = observe_state(head, person, open, 0.5, 40 + i);
    const bool closed = i >= 6 && i < 9;
    LidOpenings lids;
    for (LidOpening& lid : lids) lid = {true, closed ? 0.0 : 1.0, 0.08, closed ? 0.3 : 0.02};
    observe_lids(lids, usual, &f.observation);
  }
  ASSERT_TRUE(fit_states(head, identity, prior, {}, frames, Progress(), {}));
  for (int e = 0; e < head.expression_count(); ++e)
    if (test_head().expression_names[e].starts_with("eyeBlink"))
      for (int i = 0; i < 15; ++i) {
        if (i >= 6 && i < 9) {
          EXPECT_GT(frames[i].state.expression[e], 0.75) << i;
        } else {
          EXPECT_LT(frames[i].state.expression[e], 0.25) << i;
        }
      }
}

}  // namespace
}  // namespace likeness
