// Claims about a clip's pictures and landmarks kept from import's decoding: they are those that
// read_clip_frames finds, to the bit, and anything else is not used.
#include "core/track/kept_frames.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"
#include "core/synth/demo_capture.h"
#include "core/video/decode_for.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kKeptFrames = 30;

class KeptFrames : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "likeness_kept_frames_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    DemoOptions demo;
    demo.width = demo.height = 320;
    demo.frames = kKeptFrames;
    demo.moving_share = 0;
    demo.samples_per_pixel = 1;
    ASSERT_TRUE(write_demo_capture(folder_, demo, Progress(), {}).ok());
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  void SetUp() override {
    if (auto detector = FaceDetector::load(); !detector) GTEST_SKIP() << detector.error().what;
    fs::create_directories(folder_ / "kept");
  }
  void TearDown() override { fs::remove_all(folder_ / "kept"); }

  fs::path video() const { return folder_ / "demo.mp4"; }
  std::string inputs(const std::set<int>& held_out) const {
    return *clip_frames_inputs(*hash_video(video()), region_, held_out, options_);
  }
  void keep(int frames_named = kKeptFrames) const {
    auto reader = VideoReader::open(video(), VideoPixels::rgb, VideoFrames::sampled);
    ASSERT_TRUE(reader.ok());
    auto follower = ClipFollower::create(reader->info(), video(), region_, held_out_, options_);
    ASSERT_TRUE(follower.ok()) << follower.error().what;
    std::vector<int> frames;
    for (int i = 0; i < frames_named; ++i) frames.push_back(i);
    auto keeper = ClipFrameKeeper::create(folder_ / "kept", inputs(held_out_), std::move(*follower), frames);
    ASSERT_TRUE(keeper.ok());
    const FrameListener listener{VideoPixels::rgb,
                                 [&](const VideoFrame& frame) { return keeper->add(frame, {}); }};
    const auto decoded = decode_for(*reader, {&listener, 1}, {});
    ASSERT_EQ(decoded.ok(), frames_named >= kKeptFrames);
    ASSERT_EQ(keeper->finish({}).ok(), frames_named == kKeptFrames);
  }

  const TrackRegion region_{10, 0, 300, 310};
  const std::set<int> held_out_{25, 26, 27, 28, 29};
  const TrackOptions options_{};
  static fs::path folder_;
};
fs::path KeptFrames::folder_;

TEST_F(KeptFrames, AreThoseThatAreReadToTheBit) {
  const auto read = read_clip_frames(video(), region_, held_out_, options_, Progress(), {});
  ASSERT_TRUE(read.ok()) << read.error().what;
  keep();
  const auto kept = kept_clip_frames(folder_ / "kept", inputs(held_out_));
  ASSERT_TRUE(kept.has_value());
  EXPECT_EQ(kept->scale, read->scale);
  EXPECT_EQ(kept->region.x, read->region.x);
  EXPECT_EQ(kept->region.y, read->region.y);
  EXPECT_EQ(kept->region.width, read->region.width);
  EXPECT_EQ(kept->region.height, read->region.height);
  ASSERT_EQ(kept->frames.size(), read->frames.size());
  int found = 0;
  for (std::size_t i = 0; i < read->frames.size(); ++i) {
    const ClipFrame &a = kept->frames[i], &b = read->frames[i];
    EXPECT_EQ(a.frame, b.frame);
    EXPECT_EQ(a.time_s, b.time_s);
    EXPECT_EQ(a.held_out, b.held_out);
    EXPECT_EQ(a.detected, b.detected);
    EXPECT_EQ(a.scanned, b.scanned);
    EXPECT_EQ(a.rival, b.rival);
    EXPECT_EQ(a.grey.width, b.grey.width);
    EXPECT_EQ(a.grey.data, b.grey.data) << i;
    EXPECT_EQ(a.box.x, b.box.x);
    EXPECT_EQ(a.box.y, b.box.y);
    EXPECT_EQ(a.box.width, b.box.width);
    EXPECT_EQ(a.box.height, b.box.height);
    EXPECT_EQ(a.box.score, b.box.score);
    ASSERT_EQ(a.landmarks.has_value(), b.landmarks.has_value());
    if (!a.landmarks) continue;
    ++found;
    EXPECT_EQ(a.landmarks->points, b.landmarks->points) << i;
    EXPECT_EQ(a.landmarks->spread, b.landmarks->spread) << i;
    EXPECT_EQ(a.landmarks->cluster_share, b.landmarks->cluster_share);
    EXPECT_EQ(a.landmarks->runs, b.landmarks->runs);
  }
  EXPECT_GT(found, kKeptFrames / 2);
}

TEST_F(KeptFrames, OfOtherInputsOrDamagedAreNotUsed) {
  keep();
  const fs::path kept = folder_ / "kept";
  ASSERT_TRUE(kept_clip_frames(kept, inputs(held_out_)));
  EXPECT_FALSE(kept_clip_frames(kept, inputs({25, 26, 27, 28})));
  EXPECT_FALSE(kept_clip_frames(folder_ / "nowhere", inputs(held_out_)));
  const auto landmarks = read_text(kept / "landmarks.json");
  ASSERT_TRUE(landmarks.ok());
  ASSERT_TRUE(write_text(kept / "landmarks.json", landmarks->substr(0, landmarks->size() / 2)).ok());
  EXPECT_FALSE(kept_clip_frames(kept, inputs(held_out_)));
  ASSERT_TRUE(write_text(kept / "landmarks.json", *landmarks).ok());
  ASSERT_TRUE(kept_clip_frames(kept, inputs(held_out_)));
  fs::resize_file(kept / "track.greys", fs::file_size(kept / "track.greys") - 1);
  EXPECT_FALSE(kept_clip_frames(kept, inputs(held_out_)));
  drop_clip_frames(kept);
  EXPECT_TRUE(fs::is_empty(kept));
}

TEST_F(KeptFrames, OfAClipThatIsLongerOrShorterThanSaidAreNotKept) {
  keep(kKeptFrames + 1);
  EXPECT_FALSE(kept_clip_frames(folder_ / "kept", inputs(held_out_)));
  keep(kKeptFrames - 1);
  EXPECT_FALSE(kept_clip_frames(folder_ / "kept", inputs(held_out_)));
}

}  // namespace
}  // namespace likeness
