// Claims about what is kept for aligning from import's decoding: it is what align_clip finds by
// itself, to the bit, and anything else is not used.
#include "core/camera/kept_path.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <map>

#include "core/base/files.h"
#include "core/camera/align.h"
#include "core/camera/process.h"
#include "core/camera/workplace.h"
#include "core/video/decode_for.h"
#include "core/video/encode.h"
#include "tests/core/camera/textured_room.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kPathFrames = 60, kPathRestFrom = 36;

Intrinsics path_lens() {
  Intrinsics k;
  k.width = 320, k.height = 240;
  k.fx = k.fy = 330, k.cx = 160, k.cy = 120;
  return k;
}

// A camera on an arc round the pillar, which then rests; `moving` false: it rests all the time.
Pose path_camera(int frame, bool moving) {
  const double angle = moving ? -0.45 + 0.9 * std::min(frame, kPathRestFrom) / kPathRestFrom : 0;
  return look_at({1.5 * std::sin(angle), 0.1 * std::sin(5 * angle), 1.0 - 1.6 * std::cos(angle)},
                 {0.1, 0, 1.4});
}

Image8 middle_mask(int, const Image8& rgb) {
  Image8 mask(rgb.width, rgb.height, 1, 0);
  for (int y = rgb.height / 2; y < rgb.height; ++y)
    for (int x = rgb.width * 2 / 5; x < rgb.width * 3 / 5; ++x) *mask.at(x, y) = 255;
  return mask;
}

AlignOptions path_options() {
  AlignOptions options;
  options.keyframes = 14;
  options.colmap_width = 320;
  options.colmap_features = 900;
  options.mask_inputs = "the middle";
  return options;
}

class KeptPath : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_kept_path_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path film(bool moving) const {
    fs::path video = folder_ / "clip.mp4";
    auto writer = VideoWriter::create(video, 320, 240, {20, 14});
    EXPECT_TRUE(writer.ok());
    for (int frame = 0; frame < kPathFrames; ++frame)
      EXPECT_TRUE(writer->add(render_room(path_lens(), path_camera(frame, moving))).ok());
    EXPECT_TRUE(writer->finish().ok());
    return video;
  }
  // As import does: the motion in one pass, the pictures in another.
  BackgroundMotion keep(const fs::path& video, const AlignOptions& options) const {
    const fs::path kept = folder_ / "kept";
    fs::create_directories(kept);
    const std::string hash = *hash_video(video);
    auto reader = VideoReader::open(video, VideoPixels::rgb, VideoFrames::sampled);
    EXPECT_TRUE(reader.ok());
    MotionMeter meter(reader->info(), video, middle_mask, rest_limit(options));
    const FrameListener first{VideoPixels::rgb, [&](const VideoFrame& frame) { return meter.add(frame); }};
    EXPECT_TRUE(decode_for(*reader, {&first, 1}, {}).ok());
    auto motion = meter.finish();
    EXPECT_TRUE(motion.ok());
    EXPECT_TRUE(keep_motion(kept, motion_inputs(hash, options), *motion).ok());
    EXPECT_TRUE(keep_background(kept, motion_inputs(hash, options), meter.take_pictures()).ok());
    if (!needs_path(*motion, options)) return *motion;
    auto pictures = PathPictures::create(kept, hash, *motion, middle_mask, options);
    EXPECT_TRUE(pictures.ok()) << pictures.error().what;
    EXPECT_TRUE(reader->rewind(VideoPixels::rgb).ok());
    const FrameListener second{VideoPixels::rgb,
                               [&](const VideoFrame& frame) { return pictures->add(frame); }};
    EXPECT_TRUE(decode_for(*reader, {&second, 1}, {}).ok());
    EXPECT_TRUE(pictures->finish().ok());
    return *motion;
  }
  // Contents by name.
  static std::map<std::string, std::string> files_in(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(folder))
      files[entry.path().filename().string()] = *read_text(entry.path());
    return files;
  }
  // cameras.json's bytes.
  std::string text_of(const CameraSet& cameras) const {
    EXPECT_TRUE(write_cameras(folder_ / "cameras.json", cameras).ok());
    return *read_text(folder_ / "cameras.json");
  }

  fs::path folder_;
};

void expect_same_motion(const BackgroundMotion& a, const BackgroundMotion& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.motion, b.motion);
  EXPECT_EQ(a.seconds, b.seconds);
  EXPECT_EQ(a.tracks, b.tracks);
  EXPECT_EQ(a.stride, b.stride);
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].frame, b.frames[i].frame);
    EXPECT_EQ(a.frames[i].path, b.frames[i].path);
    EXPECT_EQ(a.frames[i].travel, b.frames[i].travel);
    EXPECT_EQ(a.frames[i].sharpness, b.frames[i].sharpness);
    EXPECT_EQ(a.frames[i].x, b.frames[i].x);
    EXPECT_EQ(a.frames[i].y, b.frames[i].y);
  }
  ASSERT_EQ(a.rests.size(), b.rests.size());
  for (std::size_t i = 0; i < a.rests.size(); ++i) {
    EXPECT_EQ(a.rests[i].first, b.rests[i].first);
    EXPECT_EQ(a.rests[i].last, b.rests[i].last);
  }
}

TEST_F(KeptPath, TheMotionIsTheMeasuredOneToTheBit) {
  const fs::path video = film(true);
  const AlignOptions options = path_options();
  const auto listened = keep(video, options);
  const auto measured = measure_background_motion(video, middle_mask, rest_limit(options), {}, {});
  ASSERT_TRUE(measured.ok());
  expect_same_motion(listened, *measured);
  const std::string inputs = motion_inputs(*hash_video(video), options);
  const auto kept = kept_motion(folder_ / "kept", inputs);
  ASSERT_TRUE(kept.has_value());
  expect_same_motion(*kept, *measured);

  EXPECT_FALSE(kept_motion(folder_ / "kept", inputs + "0"));
  AlignOptions other = options;
  other.mask_inputs = "somewhere else";
  EXPECT_FALSE(kept_motion(folder_ / "kept", motion_inputs(*hash_video(video), other)));
  EXPECT_FALSE(kept_motion(folder_ / "nowhere", inputs));
  const std::string text = *read_text(folder_ / "kept" / "motion.json");
  ASSERT_TRUE(write_text(folder_ / "kept" / "motion.json", text.substr(0, text.size() / 2)).ok());
  EXPECT_FALSE(kept_motion(folder_ / "kept", inputs));
}

TEST_F(KeptPath, ARestingCamerasClipIsNotDecodedAgain) {
  const fs::path video = film(false);
  AlignOptions options = path_options();
  const auto alone = align_clip(video, middle_mask, folder_ / "work", options, {}, {});
  ASSERT_TRUE(alone.ok()) << alone.error().what;
  ASSERT_TRUE(alone->cameras.rests());
  keep(video, options);
  options.kept = folder_ / "kept";
  const std::int64_t before = decoded_frames();
  const auto with_kept = align_clip(video, middle_mask, folder_ / "work", options, {}, {});
  ASSERT_TRUE(with_kept.ok()) << with_kept.error().what;
  EXPECT_EQ(decoded_frames() - before, 0);
  EXPECT_EQ(with_kept->evidence, alone->evidence);
  EXPECT_EQ(text_of(with_kept->cameras), text_of(alone->cameras));
}

TEST_F(KeptPath, AMovingCamerasPathNeedsNoDecodingAndIsTheSameToTheBit) {
  if (!find_program("colmap")) GTEST_SKIP() << "colmap is not installed";
  const fs::path video = film(true);
  AlignOptions options = path_options();
  const auto alone = align_clip(video, middle_mask, folder_ / "alone", options, {}, {});
  ASSERT_TRUE(alone.ok()) << alone.error().what;
  ASSERT_FALSE(alone->cameras.rests());
  keep(video, options);
  options.kept = folder_ / "kept";
  std::int64_t before = decoded_frames();
  const auto with_kept = align_clip(video, middle_mask, folder_ / "work", options, {}, {});
  ASSERT_TRUE(with_kept.ok()) << with_kept.error().what;
  EXPECT_EQ(decoded_frames() - before, 0);
  EXPECT_EQ(with_kept->evidence, alone->evidence);
  // What colmap is given; two of its own solves of one input differ in their last digits.
  for (const char* kind : {"images", "masks"}) {
    const auto pictures = files_in(folder_ / "work" / kind);
    EXPECT_GT(pictures.size(), 2u);
    EXPECT_EQ(pictures, files_in(folder_ / "alone" / kind));
  }
  // The frames between, of the same solve: without the kept pictures, and with damaged ones.
  const std::string cameras = text_of(with_kept->cameras);
  ASSERT_TRUE(write_text(kept_greys(options.kept), "no pictures").ok());
  for (const fs::path& kept : {fs::path(), options.kept}) {
    options.kept = kept;
    before = decoded_frames();
    const auto decoded = align_clip(video, middle_mask, folder_ / "work", options, {}, {});
    ASSERT_TRUE(decoded.ok()) << decoded.error().what;
    EXPECT_GT(decoded_frames() - before, kPathRestFrom);
    EXPECT_EQ(text_of(decoded->cameras), cameras);
  }
}

TEST_F(KeptPath, KeyframesOfOtherInputsStayWhereTheyAre) {
  const fs::path video = film(true);
  keep(video, path_options());
  const fs::path from = kept_keyframes(folder_ / "kept");
  const std::string inputs = *read_text(from / "inputs.txt");
  ASSERT_TRUE(prepare_work_folder(folder_ / "work", "others").ok());
  EXPECT_FALSE(take_pictures(from, "others", folder_ / "work"));
  EXPECT_FALSE(pictures_ready(folder_ / "work"));
  ASSERT_FALSE(fs::is_empty(from / "images"));
  EXPECT_TRUE(take_pictures(from, inputs.substr(0, inputs.size() - 1), folder_ / "work"));
  EXPECT_TRUE(pictures_ready(folder_ / "work"));
  EXPECT_FALSE(fs::is_empty(folder_ / "work" / "masks"));
  // What was moved is not there a second time.
  EXPECT_FALSE(take_pictures(from, inputs.substr(0, inputs.size() - 1), folder_ / "again"));

  drop_path_pictures(folder_ / "kept");
  EXPECT_FALSE(path_exists(from));
  EXPECT_FALSE(path_exists(kept_greys(folder_ / "kept")));
  EXPECT_TRUE(path_exists(folder_ / "kept" / "motion.json"));
}

}  // namespace
}  // namespace likeness
