// Claims about the face network as a source of landmarks: what region it looks at, that one picture's points
// lead to the next, which faces it finds, and how near the true landmarks lie.
#include "core/face/face_network.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "core/camera/camera.h"
#include "core/face/landmarks.h"
#include "core/face/network_landmarks.h"
#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"
#include "core/network/installed_networks.h"
#include "core/synth/demo_stage.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using Points = std::array<Vec2d, kLandmarkCount>;

// Sets LIKENESS_NETWORKS for as long as this lives.
class NetworksIn {
 public:
  explicit NetworksIn(const fs::path& folder) {
    if (const char* given = std::getenv("LIKENESS_NETWORKS")) before_ = given;
    ::setenv("LIKENESS_NETWORKS", folder.c_str(), 1);
  }
  ~NetworksIn() {
    if (before_)
      ::setenv("LIKENESS_NETWORKS", before_->c_str(), 1);
    else
      ::unsetenv("LIKENESS_NETWORKS");
  }
  NetworksIn(const NetworksIn&) = delete;
  NetworksIn& operator=(const NetworksIn&) = delete;

 private:
  std::optional<std::string> before_;
};

// Any points: a spiral.
std::array<Vec2d, kMeshCount> some_points() {
  std::array<Vec2d, kMeshCount> points;
  for (int i = 0; i < kMeshCount; ++i)
    points[std::size_t(i)] = Vec2d(100, 80) + 0.1 * i * Vec2d(std::cos(0.3 * i), std::sin(0.3 * i));
  return points;
}

TEST(MeshRegion, TurnsMovesAndGrowsWithTheFace) {
  auto points = some_points();
  const MeshRegion one = region_round(points);
  const double turn = 0.4;
  Mat3d rotation = Mat3d::Identity();
  rotation.topLeftCorner<2, 2>() << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
  const auto moved = [&](const Vec2d& p) {
    return Vec2d(Vec2d(7, -3) + 2 * (rotation.topLeftCorner<2, 2>() * p));
  };
  for (Vec2d& p : points) p = moved(p);
  const MeshRegion two = region_round(points);
  EXPECT_NEAR(std::remainder(two.roll - one.roll, 2 * M_PI), turn, 1e-9);
  EXPECT_NEAR(two.side, 2 * one.side, 1e-9);
  EXPECT_NEAR((two.centre - moved(one.centre)).norm(), 0, 1e-9);
  EXPECT_FALSE(is_same_region(one, two));
  EXPECT_TRUE(is_same_region(one, one));
}

// Of an affine map the mixture of the points is the mixture's: the weights of each landmark sum to one.
TEST(NetworkLandmarks, MoveWithTheFace) {
  auto points = some_points();
  const Points before = ibug_points(points);
  const auto moved = [](const Vec2d& p) {
    return Vec2d(3 + 1.2 * p.x() - 0.4 * p.y(), -5 + 0.3 * p.x() + 0.9 * p.y());
  };
  for (Vec2d& p : points) p = moved(p);
  const Points after = ibug_points(points);
  for (int k = 0; k < kLandmarkCount; ++k)
    EXPECT_NEAR((after[std::size_t(k)] - moved(before[std::size_t(k)])).norm(), 0, 1e-4) << k;
}

TEST(NetworkLandmarks, ShutLipsAreDrawnTogetherAndOpenOnesStay) {
  double before = 0;
  for (double gap = 0; gap < 20; gap += 0.25) {  // px, of eyes 100 px apart
    Points points;
    points.fill(Vec2d(50, 60));
    points[36] = Vec2d(0, 0), points[45] = Vec2d(100, 0);
    for (const int lower : {65, 66, 67}) points[std::size_t(lower)] = Vec2d(50, 60 + gap);
    close_shut_lips(points);
    const double left = points[66].y() - points[62].y();
    EXPECT_GE(left, before) << gap;  // more open never reads as more shut
    EXPECT_LE(left, gap);
    if (gap <= 2) {
      EXPECT_LT(left, 0.4 * gap + 1e-9);
    }
    if (gap >= 6) {
      EXPECT_GT(left, 0.98 * gap);
    }
    EXPECT_NEAR(points[62].y() + points[66].y(), 120 + gap, 1e-9);  // about the middle
    EXPECT_EQ(points[36], Vec2d(0, 0));
    before = left;
  }
}

TEST(LandmarkSource, IsDlibWhereNoNetworkIsInstalled) {
  const NetworksIn nowhere("/nowhere/at/all");
  EXPECT_EQ(landmark_source(""), LandmarkSource::dlib);
  EXPECT_EQ(landmark_source("dlib"), LandmarkSource::dlib);
  EXPECT_EQ(landmark_source("model.dat"), LandmarkSource::dlib);
  EXPECT_EQ(landmark_source_hash(""), "");
  EXPECT_EQ(landmark_source("network"), LandmarkSource::network);
  const auto asked = FaceDetector::load("network");
  ASSERT_FALSE(asked.ok());
  EXPECT_EQ(asked.error().code, ErrorCode::missing_dependency);
  EXPECT_NE(asked.error().fix.find("packaging/networks"), std::string::npos);
}

// A picture of the demo's person with the true landmarks.
struct Portrait {
  Image8 rgb, room;
  Points truth;
  double eyes = 0;  // px
};
const Portrait& portrait() {
  static const Portrait shown = [] {
    DemoOptions options;
    options.width = options.height = 320;
    options.samples_per_pixel = 2;
    DemoStage stage(make_builtin_head(), options);
    constexpr int kFrame = 150;
    const Shot shot = stage.shot(kFrame);
    Portrait made;
    made.rgb = stage.film(kFrame, {}).rgb;
    made.room = *stage.film_room(kFrame, {});
    const auto places = landmark_positions(stage.model(), stage.posed(shot));
    for (std::size_t k = 0; k < kLandmarkCount; ++k)
      made.truth[k] = project<double>(
          shot.camera.intrinsics,
          Vec3d(shot.camera.cam_from_world * shot.world_from_head * places[k].cast<double>()));
    made.eyes = (made.truth[45] - made.truth[36]).norm();
    return made;
  }();
  return shown;
}

double inner_distance(const Points& a, const Points& b) {
  double sum = 0;
  for (std::size_t k = 17; k < kLandmarkCount; ++k) sum += (a[k] - b[k]).norm() / (kLandmarkCount - 17);
  return sum;
}

class InstalledFaceNetwork : public testing::Test {
 protected:
  void SetUp() override {
    if (const char* given = std::getenv("LIKENESS_NETWORKS"); given == nullptr || *given == '\0')
      checkouts_.emplace(LIKENESS_SOURCE "/build/networks");
    auto loaded = FaceNetwork::installed();
    if (!loaded) GTEST_SKIP() << loaded.error().what << ' ' << loaded.error().fix;
    network_.emplace(std::move(*loaded));
  }
  std::optional<NetworksIn> checkouts_;
  std::optional<FaceNetwork> network_;
};

TEST_F(InstalledFaceNetwork, FindsTheFaceWithItsLandmarksNearTheTrueOnes) {
  const auto faces = network_->find(portrait().rgb);
  ASSERT_EQ(faces.size(), 1u);
  EXPECT_GT(faces[0].presence, 0.9);
  EXPECT_LT(inner_distance(ibug_points(faces[0].points), portrait().truth), 0.06 * portrait().eyes);
}

TEST_F(InstalledFaceNetwork, IsDrawnTheSameFromWhereverALookBegins) {
  const auto faces = network_->find(portrait().rgb);
  ASSERT_EQ(faces.size(), 1u);
  const MeshRegion right = region_round(faces[0].points);
  for (const double sign : {-1.0, 1.0}) {
    MeshRegion start = right;
    start.centre += Vec2d(0.15, -0.1) * sign * right.side;
    start.side *= 1 + 0.2 * sign;
    start.roll += 0.3 * sign;
    const auto settled = network_->settle(portrait().rgb, start);
    ASSERT_TRUE(settled.has_value()) << sign;
    EXPECT_LT(inner_distance(ibug_points(settled->points), ibug_points(faces[0].points)),
              0.02 * portrait().eyes);
  }
}

TEST_F(InstalledFaceNetwork, DrawsTheMarginsOfTheLids) {
  const auto faces = network_->find(portrait().rgb);
  ASSERT_EQ(faces.size(), 1u);
  const auto lids = network_->lids(portrait().rgb, faces[0].points);
  ASSERT_TRUE(lids.has_value());
  for (const int side : {0, 1}) {
    const auto& margin = (*lids)[std::size_t(side)];
    EXPECT_LT(margin[12].y(), margin[4].y()) << side;  // the upper one over the lower
    const Vec2d inner = portrait().truth[side == 0 ? 39 : 42], outer = portrait().truth[side == 0 ? 36 : 45];
    EXPECT_LT((margin[0] - inner).norm(), 0.1 * portrait().eyes) << side;
    EXPECT_LT((margin[8] - outer).norm(), 0.1 * portrait().eyes) << side;
  }
  EXPECT_FALSE(network_->lids(Image8(), faces[0].points).has_value());
}

TEST_F(InstalledFaceNetwork, SeesNobodyInAnEmptyRoom) {
  EXPECT_TRUE(network_->find(portrait().room).empty());
  EXPECT_TRUE(network_->find(Image8(320, 240, 3, 90)).empty());
  EXPECT_TRUE(network_->find(Image8()).empty());
  EXPECT_FALSE(network_->settle(portrait().room, {Vec2d(160, 130), 150, 0}).has_value());
  EXPECT_FALSE(network_->look(portrait().rgb, {Vec2d(-900, 0), 100, 0}).has_value());
  EXPECT_FALSE(network_->look(portrait().rgb, {Vec2d(NAN, 0), 100, 0}).has_value());
}

// A face a twentieth as wide as the picture: squares of it are searched.
TEST_F(InstalledFaceNetwork, FindsASmallFaceInAWidePicture) {
  const int side = 130, left = 700, top = 250;
  const Image8 small = resize(portrait().rgb, side, side);
  Image8 wide(960, 540, 3, 120);
  for (int y = 0; y < side; ++y) std::copy_n(small.at(0, y), 3 * side, wide.at(left, top + y));
  const auto faces = network_->find(wide);
  ASSERT_EQ(faces.size(), 1u);
  Points truth;
  for (std::size_t k = 0; k < kLandmarkCount; ++k)
    truth[k] = portrait().truth[k] * side / 320.0 + Vec2d(left, top);
  EXPECT_LT(inner_distance(ibug_points(faces[0].points), truth), 0.08 * portrait().eyes * side / 320.0);
}

TEST_F(InstalledFaceNetwork, DetectorOfTheChoiceUsesIt) {
  const auto detector = FaceDetector::load("network");
  ASSERT_TRUE(detector.ok()) << detector.error().what;
  EXPECT_EQ(detector->source(), LandmarkSource::network);
  EXPECT_EQ(landmark_source(""), LandmarkSource::network);
  EXPECT_NE(landmark_source_hash(""), "");
  const auto boxes = detector->detect(portrait().rgb);
  ASSERT_EQ(boxes.size(), 1u);
  EXPECT_GT(boxes[0].score, 0.8);
  const auto again = detector->detect(portrait().rgb, &boxes[0]);  // followed, not sought
  ASSERT_EQ(again.size(), 1u);
  EXPECT_GT(overlap(again[0], boxes[0]), 0.9);
  const Landmarks one = detector->landmarks(portrait().rgb, boxes[0], 0, nullptr, {8, 8});
  const Landmarks four = detector->landmarks(portrait().rgb, boxes[0]);
  EXPECT_EQ(one.runs, 1);
  EXPECT_EQ(four.runs, 4);
  EXPECT_GT(four.cluster_share, 0.9);
  EXPECT_LT(inner_distance(one.points, four.points), 0.02 * portrait().eyes);
  EXPECT_LT(inner_spread(four), 0.03 * portrait().eyes);
  // The jaw line, which both draw differently on a turned face, is believed less.
  EXPECT_GT(four.spread[4], four.spread[33]);
}

// What it draws where nobody is must not pass for a face.
TEST_F(InstalledFaceNetwork, SaysThatLandmarksOfNobodyAreNotAgreedOn) {
  const auto detector = FaceDetector::load("network");
  ASSERT_TRUE(detector.ok()) << detector.error().what;
  EXPECT_LT(detector->landmarks(portrait().room, {100, 100, 120, 120}).cluster_share, 0.4);
  EXPECT_LT(detector->landmarks(portrait().room, {-900, -900, 20, 20}).cluster_share, 0.4);
}

// Grey pictures are what the fit keeps.
TEST_F(InstalledFaceNetwork, ReadsGreyPicturesAlmostAsWell) {
  Image8 grey(320, 320, 1);
  for (int y = 0; y < 320; ++y)
    for (int x = 0; x < 320; ++x) {
      const std::uint8_t* p = portrait().rgb.at(x, y);
      *grey.at(x, y) = std::uint8_t((77 * p[0] + 150 * p[1] + 29 * p[2] + 128) >> 8);
    }
  const auto faces = network_->find(grey);
  ASSERT_EQ(faces.size(), 1u);
  EXPECT_LT(inner_distance(ibug_points(faces[0].points), portrait().truth), 0.06 * portrait().eyes);
}

}  // namespace
}  // namespace likeness
