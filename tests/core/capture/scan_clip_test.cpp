// Claims about the first look at a clip, on pictures of a rendered person.
#include "core/capture/scan_clip.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/head/builtin_head.h"
#include "core/synth/demo_stage.h"
#include "core/video/encode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// Rendered once; its face is found.
const Image8& person() {
  static const Image8 picture = [] {
    DemoOptions options;
    options.width = options.height = 288;
    options.samples_per_pixel = 2;
    options.moving_share = 0;
    return DemoStage(make_builtin_head(), options).film(24, {}).rgb;
  }();
  return picture;
}

class ScanClip : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const auto detector = FaceDetector::load(); !detector) GTEST_SKIP() << detector.error().what;
    std::string name = (fs::temp_directory_path() / "likeness_scan_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }

  // Four seconds; a hand covers mouth and chin in [covered, gone), nobody is there from gone on.
  std::vector<FaceSample> scan(double covered_s, double gone_s) const {
    const auto detector = FaceDetector::load();
    const fs::path path = folder_ / "clip.mp4";
    auto writer = VideoWriter::create(path, 288, 288);
    for (int f = 0; f < 100; ++f) {
      Image8 picture = f < 25 * gone_s ? person() : Image8(288, 288, 3, 120);
      if (f >= 25 * covered_s && f < 25 * gone_s)
        for (int y = 150; y < 240; ++y)
          for (int x = 60; x < 230; ++x) std::fill_n(picture.at(x, y), 3, 90);
      EXPECT_TRUE(writer->add(picture).ok());
    }
    EXPECT_TRUE(writer->finish().ok());
    auto scanned = scan_clip(path, *detector, {}, {}, Progress(), {});
    EXPECT_TRUE(scanned.ok());
    return scanned ? scanned->samples : std::vector<FaceSample>();
  }

  fs::path folder_;
};

TEST_F(ScanClip, AFaceHalfHiddenStaysItselfAndAFaceGoneIsGone) {
  const auto samples = scan(1, 3);
  ASSERT_EQ(samples.size(), 20U);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ASSERT_EQ(samples[i].face.has_value(), i < 15) << i;
    EXPECT_FALSE(samples[i].second_face) << i;
    if (i >= 5 && i < 15) {
      EXPECT_LT(samples[i].face->score, 0) << i;
      EXPECT_GT(overlap(*samples[i].face, *samples[0].face), 0.6) << i;
    }
  }
}

TEST_F(ScanClip, AFaceHalfHiddenFromTheStartIsNotFound) {
  for (const FaceSample& sample : scan(0, 4)) EXPECT_FALSE(sample.face) << sample.frame;
}

}  // namespace
}  // namespace likeness
