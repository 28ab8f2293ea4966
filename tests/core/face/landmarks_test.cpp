// Claims about face detection and landmarks; on a real face where a capture is at hand.
#include "core/face/landmarks.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "core/video/decode.h"
#include "tests/core/face/tiny_predictor.h"

namespace likeness {
namespace {

TEST(FaceDetector, MissingModelNamesTheRemedy) {
  const auto absent = FaceDetector::load("/nowhere/at/all.dat");
  ASSERT_FALSE(absent.ok());
  EXPECT_EQ(absent.error().code, ErrorCode::not_found);
  EXPECT_NE(absent.error().fix.find("libdlib-data"), std::string::npos);
}

TEST(FaceDetector, RefusesAFileThatIsNotAModel) {
  const auto path = std::filesystem::temp_directory_path() / "likeness_no_model.dat";
  std::ofstream(path) << "this is no shape predictor";
  const auto bad = FaceDetector::load(path);
  std::filesystem::remove(path);
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().code, ErrorCode::bad_input);
}

// Loads a model from these bytes.
Result<FaceDetector> load_bytes(const std::string& bytes) {
  const auto path =
      std::filesystem::temp_directory_path() / ("likeness_model_" + std::to_string(::getpid()) + ".dat");
  std::ofstream(path, std::ios::binary) << bytes;
  auto loaded = FaceDetector::load(path);
  std::filesystem::remove(path);
  return loaded;
}

TEST(FaceDetector, UsesAUsersOwnModelUnchanged) {
  const auto detector = load_bytes(tiny_predictor(2));
  ASSERT_TRUE(detector.ok()) << detector.error().what;
  const Landmarks found = detector->landmarks(Image8(80, 80, 1, 90), {20, 20, 40, 40}, 0, nullptr, {1, 1});
  EXPECT_NEAR((found.points[0] - found.points[31]).norm(), 0.8 * 40, 3);  // across the circle
}

// dlib would read beyond its memory.
TEST(FaceDetector, RefusesADamagedModel) {
  const std::string good = tiny_predictor(2);
  const struct {
    const char* what;
    std::string bytes;
  } cases[] = {{"pixels", tiny_predictor(2, kLandmarkCount, 3)},
               {"numbers instead of 136", tiny_predictor(2, 5)},
               {"", good.substr(0, good.size() - 1)},
               {"", good.substr(0, good.size() / 2)}};
  for (const auto& c : cases) {
    const auto refused = load_bytes(c.bytes);
    ASSERT_FALSE(refused.ok()) << c.what;
    EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
    EXPECT_NE(refused.error().what.find(c.what), std::string::npos) << refused.error().what;
    EXPECT_FALSE(refused.error().fix.empty());
  }
}

class RealFace : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path video = std::filesystem::path(LIKENESS_SHARED) / "captures" / "wojtek.mp4";
    if (!std::filesystem::exists(video)) GTEST_SKIP() << "no real capture at " << video;
    auto loaded = FaceDetector::load(kDlibLandmarks);
    if (!loaded) GTEST_SKIP() << loaded.error().what;
    detector = std::make_unique<FaceDetector>(std::move(*loaded));
    auto reader = VideoReader::open(video);
    ASSERT_TRUE(reader.ok()) << reader.error().what;
    auto frame = reader->next();
    ASSERT_TRUE(frame.ok() && frame->has_value());
    rgb = (*frame)->rgb;
  }
  std::unique_ptr<FaceDetector> detector;
  Image8 rgb;
};

TEST_F(RealFace, OneFaceIsFoundAndItsPointsAreOrdered) {
  const auto faces = detector->detect(rgb);
  ASSERT_EQ(faces.size(), 1u);
  const Landmarks found = detector->landmarks(rgb, faces[0]);
  EXPECT_GT(found.cluster_share, 0.5);
  EXPECT_LT(found.points[36].x(), found.points[45].x());  // subject's right eye is on the picture's left
  EXPECT_LT(found.points[27].y(), found.points[33].y());  // nose downwards
  EXPECT_LT(found.points[33].y(), found.points[57].y());  // mouth below it
  EXPECT_LT(found.points[57].y(), found.points[8].y());   // chin below that
}

TEST_F(RealFace, ConsensusHardlyDependsOnTheBox) {
  const auto faces = detector->detect(rgb);
  ASSERT_FALSE(faces.empty());
  FaceBox shifted = faces[0];
  shifted.x += 0.04 * shifted.width;
  shifted.y -= 0.04 * shifted.width;
  const Landmarks a = detector->landmarks(rgb, faces[0]), b = detector->landmarks(rgb, shifted);
  double inner = 0;
  for (int i = 17; i < kLandmarkCount; ++i)
    inner += (a.points[i] - b.points[i]).norm() / (kLandmarkCount - 17);
  EXPECT_LT(inner, 0.012 * faces[0].width);
}

TEST_F(RealFace, AClearFaceNeedsOnlyTheFirstRuns) {
  const auto faces = detector->detect(rgb);
  ASSERT_FALSE(faces.empty());
  const Landmarks few = detector->landmarks(rgb, faces[0], 0, nullptr, {8, 32});
  const Landmarks all = detector->landmarks(rgb, faces[0]);
  EXPECT_EQ(few.runs, 8);
  EXPECT_EQ(all.runs, 32);
  double inner = 0;
  for (int i = 17; i < kLandmarkCount; ++i)
    inner += (few.points[i] - all.points[i]).norm() / (kLandmarkCount - 17);
  EXPECT_LT(inner, 0.012 * faces[0].width);
  // Nothing to agree on: all runs are made, and the uncertainty is reported.
  const Landmarks nothing =
      detector->landmarks(Image8(320, 320, 3, 90), {80, 80, 160, 160}, 0, nullptr, {8, 32});
  EXPECT_GE(nothing.runs, 8);
}

TEST_F(RealFace, EmptyPictureHoldsNoFace) {
  EXPECT_TRUE(detector->detect(Image8(320, 240, 3, 90)).empty());
  EXPECT_TRUE(detector->detect(Image8()).empty());
}

}  // namespace
}  // namespace likeness
