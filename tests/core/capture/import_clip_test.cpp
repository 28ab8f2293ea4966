// Claims about import: what it refuses and why, that nothing half-made stays, and that the pictures are the
// crop.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include "core/base/files.h"
#include "core/capture/capture.h"
#include "core/capture/import_listeners.h"
#include "core/face/landmarks.h"
#include "core/image/files.h"
#include "core/video/decode.h"
#include "core/video/encode.h"
#include "tests/core/capture/demo_film.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class ImportClip : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              std::string("likeness_import_")
                  .append(std::to_string(getpid()))
                  .append(::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Result<Capture> import(const fs::path& video, const ImportOptions& options = {.size = 128}) const {
    return import_clip(video, folder_ / "project", options, Progress(), {});
  }
  // Everything in the project folder, hidden files included.
  std::size_t entries() const {
    const fs::path project = folder_ / "project";
    return fs::exists(project) ? std::size_t(std::distance(fs::recursive_directory_iterator(project), {}))
                               : 0;
  }
  void write_video(const fs::path& path, const std::vector<Image8>& frames) const {
    auto writer = VideoWriter::create(path, frames[0].width, frames[0].height);
    ASSERT_TRUE(writer) << writer.error().what;
    for (const Image8& frame : frames) ASSERT_TRUE(writer->add(frame));
    ASSERT_TRUE(writer->finish());
  }
  // A wall of coloured tiles, shifted from frame to frame; no face in it.
  static std::vector<Image8> tiles(int count) {
    std::vector<Image8> frames;
    for (int i = 0; i < count; ++i) {
      Image8 image(256, 192, 3);
      for (int y = 0; y < 192; ++y) {
        for (int x = 0; x < 256; ++x) {
          const int tile = (x + 2 * i) / 24 + 3 * (y / 24);
          for (int c = 0; c < 3; ++c) image.at(x, y)[c] = std::uint8_t(60 + (tile * (37 + 50 * c)) % 160);
        }
      }
      frames.push_back(std::move(image));
    }
    return frames;
  }

  fs::path folder_;
};

// The first frames of a real clip, where there is one.
class ImportFace : public ImportClip {
 protected:
  void SetUp() override {
    ImportClip::SetUp();
    const fs::path clip = fs::path(LIKENESS_SHARED) / "captures" / "wojtek.mp4";
    if (!fs::exists(clip)) GTEST_SKIP() << clip << " is not here";
    auto detector = FaceDetector::load();
    ASSERT_TRUE(detector) << detector.error().what;
    detector_.emplace(std::move(*detector));
    auto reader = VideoReader::open(clip);
    ASSERT_TRUE(reader);
    while (frames_.size() < 50) {
      auto frame = reader->next();
      ASSERT_TRUE(frame && *frame);
      frames_.push_back(std::move((*frame)->rgb));
    }
  }
  std::optional<FaceDetector> detector_;  // held so that its 100 MB are read once for all imports of a test
  std::vector<Image8> frames_;
};

TEST_F(ImportClip, RefusesAClipWithoutAFace) {
  write_video(folder_ / "a.mp4", tiles(40));
  const auto capture = import(folder_ / "a.mp4");
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().code, ErrorCode::no_face);
  EXPECT_THAT(capture.error().what, HasSubstr("A face was found in 0 of 8 frames"));
  EXPECT_FALSE(capture.error().fix.empty());
  EXPECT_EQ(entries(), 0u);
}

TEST_F(ImportClip, OfACutClipWhatComesBeforeIsUsedAndAWarningSaysUpToWhere) {
  const auto& person = test::demo_pictures();
  write_video(folder_ / "a.mp4", person);
  const auto bytes = read_file(folder_ / "a.mp4");
  ASSERT_TRUE(bytes);
  ASSERT_TRUE(write_file(folder_ / "cut.mp4", std::span(*bytes).first(bytes->size() * 85 / 100)));
  const auto capture = import(folder_ / "cut.mp4");
  ASSERT_TRUE(capture) << capture.error().what;
  EXPECT_GE(capture->frames.size(), 30u);
  EXPECT_LT(capture->frames.size(), person.size());
  EXPECT_THAT(capture->warnings, testing::Contains(testing::AllOf(HasSubstr("is cut short after frame"),
                                                                  HasSubstr("Only what comes before"))));
  // Of one that does not serve, the cut is told, too.
  write_video(folder_ / "b.mp4", tiles(60));
  const auto wall = read_file(folder_ / "b.mp4");
  ASSERT_TRUE(write_file(folder_ / "cut.mp4", std::span(*wall).first(wall->size() * 85 / 100)));
  EXPECT_THAT(import(folder_ / "cut.mp4").error().what,
              testing::AllOf(HasSubstr("is cut short after frame"), HasSubstr("A face was found in 0")));
}

TEST_F(ImportClip, RefusesTooFewFrames) {
  write_video(folder_ / "a.mp4", tiles(12));
  const auto capture = import(folder_ / "a.mp4");
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().code, ErrorCode::bad_input);
  EXPECT_THAT(capture.error().what, HasSubstr("12 frames"));
  EXPECT_EQ(entries(), 0u);
}

TEST_F(ImportClip, RefusesAMissingVideoAndATextFile) {
  EXPECT_EQ(import(folder_ / "missing.mp4").error().code, ErrorCode::not_found);
  std::ofstream(folder_ / "text.mp4") << "no video";
  EXPECT_EQ(import(folder_ / "text.mp4").error().code, ErrorCode::bad_input);
}

TEST_F(ImportClip, SaysSoWhenTheFolderCannotBeMade) {
  write_video(folder_ / "a.mp4", tiles(40));
  std::ofstream(folder_ / "project") << "a file stands where the folder should be";
  const auto capture = import(folder_ / "a.mp4");
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().code, ErrorCode::io);
  EXPECT_THAT(capture.error().what, HasSubstr("project"));
}

TEST_F(ImportClip, StopsBeforeItStarts) {
  write_video(folder_ / "a.mp4", tiles(40));
  std::stop_source stop;
  stop.request_stop();
  const auto capture = import_clip(folder_ / "a.mp4", folder_ / "project", {}, Progress(), stop.get_token());
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().code, ErrorCode::cancelled);
  EXPECT_EQ(entries(), 0u);
}

TEST_F(ImportFace, WritesTheCropOfUsedAndHeldOutFrames) {
  write_video(folder_ / "a.mp4", frames_);
  std::vector<double> fractions;
  const auto capture =
      import_clip(folder_ / "a.mp4", folder_ / "project", {.size = 128},
                  Progress([&](const ProgressReport& r) { fractions.push_back(r.fraction); }), {});
  ASSERT_TRUE(capture) << capture.error().what;
  EXPECT_EQ(capture->frames.size(), 50u);
  EXPECT_EQ(held_out_frames(*capture), (std::set<int>{45, 46, 47, 48, 49}));
  EXPECT_EQ(capture->crop.side, 512);  // the head nearly fills this picture
  EXPECT_EQ(capture->width, 512);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1);

  auto reader = VideoReader::open(folder_ / "a.mp4");
  ASSERT_TRUE(reader);
  std::size_t pictures = 0;
  for (const CaptureFrame& f : capture->frames) {
    const auto source = reader->next();
    ASSERT_TRUE(source && *source);
    const fs::path name = folder_ / "project" / frame_name(f.frame);
    ASSERT_EQ(fs::exists(name), f.used || f.held_out) << f.frame;
    if (!f.used && !f.held_out) continue;
    ++pictures;
    const auto picture = read_image(name);
    ASSERT_TRUE(picture);
    const SquareCrop& c = capture->crop;
    EXPECT_EQ(picture->data, resize(crop((*source)->rgb, c.x, c.y, c.side, c.side), 128, 128).data)
        << f.frame;
  }
  EXPECT_EQ(entries(), pictures + 1);  // and the folder frames/ itself: nothing temporary remains
}

// A film so low that the heads, which go from left to right, do not fit into a square within it.
TEST_F(ImportClip, WhatTheCropShowsBeyondTheFilmIsPlainAndSaidToBeUnknown) {
  constexpr int kWidth = 480, kHeight = 136, kTop = 22;
  std::vector<Image8> frames;
  for (std::size_t i = 0; i < test::demo_pictures().size(); ++i) {
    const Image8& person = test::demo_pictures()[i];
    Image8 frame(kWidth, kHeight, 3);
    const int x0 = int(i) * (kWidth - test::kDemoSide) / (test::kDemoFrames - 1);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        std::copy_n(person.at(std::clamp(x - x0, 0, test::kDemoSide - 1), y + kTop), 3, frame.at(x, y));
    frames.push_back(std::move(frame));
  }
  write_video(folder_ / "a.mp4", frames);
  const auto capture = import(folder_ / "a.mp4", {.size = 128});
  ASSERT_TRUE(capture) << capture.error().what;
  const SquareCrop& c = capture->crop;
  ASSERT_GT(c.side, kHeight);
  EXPECT_LT(c.y, 0);
  EXPECT_EQ(capture->inside, filmed_part(c, {0, 0, kWidth, kHeight}, 128));
  EXPECT_EQ(capture->inside.width, 128);
  EXPECT_LT(capture->inside.height, 128);
  for (const CaptureFrame& frame : capture->frames) {
    if (!frame.used && !frame.held_out) continue;
    const auto picture = read_image(folder_ / "project" / frame_name(frame.frame));
    ASSERT_TRUE(picture);
    Image8 plain = *picture;
    fill_outside(plain, capture->inside, kUnfilmed);
    ASSERT_EQ(picture->data, plain.data) << frame.frame;
  }
}

// Bars all round the film: black above and below, and a blurred copy, with another face, on both sides.
TEST_F(ImportClip, OnlyTheFilmWithinItsBarsIsLookedAt) {
  constexpr int kSide = test::kDemoSide, kX = 100, kY = 30, kWidth = kSide + 2 * kX, kHeight = kSide + 2 * kY;
  std::vector<Image8> frames;
  for (const Image8& person : test::demo_pictures()) {
    const Image8 blurred = resize(resize(person, 14, 14), kWidth, kWidth);
    Image8 frame(kWidth, kHeight, 3);
    for (int y = 0; y < kSide; ++y) {
      std::copy_n(blurred.at(0, y + (kWidth - kSide) / 2), 3 * kWidth, frame.at(0, kY + y));
      std::copy_n(person.at(0, y), 3 * kSide, frame.at(kX, kY + y));
    }
    frames.push_back(std::move(frame));
  }
  write_video(folder_ / "a.mp4", frames);
  ImportListeners listeners;
  std::vector<PixelRect> films;
  PixelRect seen;
  listeners.looking = [&](const VideoInfo& info,
                          const PixelRect& film) -> Result<std::vector<FrameListener>> {
    films.push_back(film);
    EXPECT_EQ(info.width, film.empty() ? kWidth : film.width);
    return std::vector<FrameListener>{{VideoPixels::rgb, [&](const VideoFrame& frame) {
                                         seen = {0, 0, frame.rgb.width, frame.rgb.height};
                                         return Result<void>();
                                       }}};
  };
  const auto capture =
      import_clip(folder_ / "a.mp4", folder_ / "project", {.size = 128}, listeners, Progress(), {});
  ASSERT_TRUE(capture) << capture.error().what;
  const PixelRect truth{kX, kY, kSide, kSide}, &film = capture->film;
  EXPECT_EQ(common_part(film, truth), film);
  EXPECT_GE(film.width, kSide - 4);
  EXPECT_GE(film.height, kSide - 4);
  EXPECT_EQ(films.back(), film);
  EXPECT_EQ(seen, (PixelRect{0, 0, film.width, film.height}));
  EXPECT_EQ(capture->width, kWidth);
  EXPECT_TRUE(capture->inside.empty());
  const SquareCrop& c = capture->crop;
  EXPECT_EQ(common_part({c.x, c.y, c.side, c.side}, film), (PixelRect{c.x, c.y, c.side, c.side}));
  ASSERT_FALSE(capture->warnings.empty());
  EXPECT_THAT(capture->warnings.front(), HasSubstr("bars"));
}

// The demo's person, of whom the second third was cropped closer by an editor.
TEST_F(ImportClip, AShotThatIsCroppedCloserIsLeftOutAndSaidSo) {
  constexpr int kSide = test::kDemoSide, kShot = test::kDemoFrames, kCloser = kSide * 2 / 3;
  std::vector<Image8> frames;
  for (int part = 0; part < 3; ++part)
    for (const Image8& person : test::demo_pictures())
      frames.push_back(
          part == 1 ? resize(crop(person, (kSide - kCloser) / 2, kSide / 8, kCloser, kCloser), kSide, kSide)
                    : person);
  write_video(folder_ / "a.mp4", frames);
  const auto capture = import(folder_ / "a.mp4");
  ASSERT_TRUE(capture) << capture.error().what;
  ASSERT_EQ(capture->shots.size(), 3U);
  EXPECT_EQ(capture->shots[1].first, kShot);
  EXPECT_EQ(capture->shots[2].first, 2 * kShot);
  EXPECT_TRUE(capture->shots[0].used && capture->shots[2].used);
  EXPECT_FALSE(capture->shots[1].used);
  EXPECT_THAT(capture->warnings, ::testing::Contains(HasSubstr("0:00-0:02 and 0:04-0:06 serves")));
  for (const CaptureFrame& frame : capture->frames) {
    const bool outside = frame.frame >= kShot && frame.frame < 2 * kShot;
    ASSERT_EQ(frame.refused.starts_with("In another shot"), outside) << frame.frame << frame.refused;
    ASSERT_FALSE(outside && (frame.used || frame.held_out)) << frame.frame;
  }
  const fs::path file = folder_ / "capture.json";
  ASSERT_TRUE(write_capture(file, *capture));
  const auto kept = read_capture(file);
  ASSERT_TRUE(kept) << kept.error().what;
  ASSERT_EQ(kept->shots.size(), 3U);
  EXPECT_EQ(kept->shots[1].reason, capture->shots[1].reason);
  EXPECT_EQ(kept->shots[1].to_s, capture->shots[1].to_s);
}

TEST_F(ImportFace, TheClipIsDecodedOnceWhereThereIsRoomForItsFramesElseTwice) {
  write_video(folder_ / "a.mp4", frames_);
  std::map<bool, std::map<std::string, std::string>> files;
  for (const bool room : {true, false}) {
    const fs::path project = folder_ / (room ? "roomy" : "narrow");
    ImportOptions options{.size = 128};
    if (!room) options.memory = 0;
    const std::int64_t before = decoded_frames();
    const auto capture = import_clip(folder_ / "a.mp4", project, options, Progress(), {});
    ASSERT_TRUE(capture) << capture.error().what;
    EXPECT_EQ(decoded_frames() - before, room ? 50 : 100);
    ASSERT_TRUE(write_capture(project / "capture.json", *capture));
    for (const auto& entry : fs::recursive_directory_iterator(project))
      if (entry.is_regular_file())
        files[room][entry.path().lexically_relative(project).string()] = *read_text(entry.path());
  }
  EXPECT_GT(files[true].size(), 40u);
  EXPECT_EQ(files[true], files[false]);
}

TEST_F(ImportFace, ListenersSeeTheFramesThatImportDecodes) {
  write_video(folder_ / "a.mp4", frames_);
  std::vector<std::pair<int, Image8>> looking, writing;
  const auto into = [](std::vector<std::pair<int, Image8>>& seen) {
    return FrameListener{VideoPixels::rgb, [&seen](const VideoFrame& frame) {
                           seen.emplace_back(frame.index, frame.rgb);
                           return Result<void>();
                         }};
  };
  ImportListeners listeners;
  listeners.looking = [&](const VideoInfo& info, const PixelRect&) -> Result<std::vector<FrameListener>> {
    EXPECT_EQ(info.width, 512);
    return std::vector<FrameListener>{into(looking)};
  };
  listeners.writing = [&](const VideoInfo&, const Capture& capture) -> Result<std::vector<FrameListener>> {
    EXPECT_EQ(looking.size(), capture.frames.size());
    EXPECT_GT(capture.crop.side, 0);
    return std::vector<FrameListener>{into(writing)};
  };
  const std::int64_t before = decoded_frames();
  const auto capture =
      import_clip(folder_ / "a.mp4", folder_ / "project", {.size = 128}, listeners, Progress(), {});
  ASSERT_TRUE(capture) << capture.error().what;
  EXPECT_EQ(decoded_frames() - before, 50);
  auto reader = VideoReader::open(folder_ / "a.mp4");
  ASSERT_TRUE(reader);
  ASSERT_EQ(looking.size(), 50u);
  ASSERT_EQ(writing.size(), 50u);
  for (std::size_t i = 0; i < 50; ++i) {
    const auto source = reader->next();
    ASSERT_TRUE(source && *source);
    EXPECT_EQ(looking[i].first, (*source)->index);
    EXPECT_EQ(looking[i].second.data, (*source)->rgb.data) << i;
    EXPECT_EQ(writing[i].second.data, (*source)->rgb.data) << i;
  }
}

TEST_F(ImportFace, AListenersErrorEndsTheImportAndLeavesNothing) {
  write_video(folder_ / "a.mp4", frames_);
  ImportListeners listeners;
  listeners.writing = [](const VideoInfo&, const Capture&) -> Result<std::vector<FrameListener>> {
    return std::vector<FrameListener>{{VideoPixels::rgb, [](const VideoFrame& frame) -> Result<void> {
                                         if (frame.index < 20) return {};
                                         return Error{ErrorCode::io, "The disk is full.", "", ""};
                                       }}};
  };
  const auto capture =
      import_clip(folder_ / "a.mp4", folder_ / "project", {.size = 128}, listeners, Progress(), {});
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().what, "The disk is full.");
  EXPECT_EQ(entries(), 0u);
}

TEST_F(ImportFace, RefusesFramesBlurredByHand) {
  for (const int i : {11, 12, 30}) {
    const Image8 small = resize(frames_[i], 64, 64);
    frames_[i] = resize(small, 512, 512);
  }
  write_video(folder_ / "a.mp4", frames_);
  const auto capture = import(folder_ / "a.mp4");
  ASSERT_TRUE(capture) << capture.error().what;
  for (const CaptureFrame& f : capture->frames) {
    EXPECT_EQ(!f.refused.empty(), f.frame == 11 || f.frame == 12 || f.frame == 30)
        << f.frame << ' ' << f.sharpness;
  }
}

TEST_F(ImportFace, RefusesTwoPeople) {
  for (Image8& frame : frames_) {
    Image8 pair(1024, 512, 3);
    for (int y = 0; y < 512; ++y) {
      std::memcpy(pair.at(0, y), frame.at(0, y), 512 * 3);
      std::memcpy(pair.at(512, y), frame.at(0, y), 512 * 3);
    }
    frame = std::move(pair);
  }
  write_video(folder_ / "a.mp4", frames_);
  const auto capture = import(folder_ / "a.mp4");
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().code, ErrorCode::bad_input);
  EXPECT_THAT(capture.error().what, HasSubstr("Two faces are in view in 10 of 10"));
  EXPECT_THAT(capture.error().fix, HasSubstr("one person"));
  EXPECT_EQ(entries(), 0u);
}

TEST_F(ImportFace, ATruncatedVideoLeavesAnEarlierImportAsItWas) {
  write_video(folder_ / "a.mp4", frames_);
  ASSERT_TRUE(import(folder_ / "a.mp4"));
  const std::size_t before = entries();
  const auto bytes = read_file(folder_ / "a.mp4");
  ASSERT_TRUE(bytes);
  ASSERT_TRUE(write_file(folder_ / "cut.mp4", std::span(*bytes).first(bytes->size() * 4 / 10)));
  const auto capture = import(folder_ / "cut.mp4");
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().code, ErrorCode::bad_input);
  EXPECT_THAT(capture.error().what, HasSubstr("is cut short after frame"));
  EXPECT_EQ(entries(), before);
}

TEST_F(ImportFace, StoppedMidwayLeavesNothingAndARerunEqualsAnUncutOne) {
  write_video(folder_ / "a.mp4", frames_);
  for (const double moment : {0.3, 0.9}) {  // in the first and in the second pass
    std::stop_source stop;
    const Progress progress([&](const ProgressReport& r) {
      if (r.fraction > moment) stop.request_stop();
    });
    const auto capture =
        import_clip(folder_ / "a.mp4", folder_ / "project", {.size = 128}, progress, stop.get_token());
    ASSERT_FALSE(capture);
    EXPECT_EQ(capture.error().code, ErrorCode::cancelled);
    EXPECT_EQ(entries(), 0u) << moment;
  }
  const auto rerun = import(folder_ / "a.mp4");
  const auto uncut = import_clip(folder_ / "a.mp4", folder_ / "other", {.size = 128}, Progress(), {});
  ASSERT_TRUE(rerun && uncut);
  ASSERT_TRUE(write_capture(folder_ / "rerun.json", *rerun));
  ASSERT_TRUE(write_capture(folder_ / "uncut.json", *uncut));
  EXPECT_EQ(*read_text(folder_ / "rerun.json"), *read_text(folder_ / "uncut.json"));
}

TEST_F(ImportFace, WarnsWhenPicturesAreEnlarged) {
  for (Image8& frame : frames_) frame = resize(frame, 400, 400);
  write_video(folder_ / "a.mp4", frames_);
  const auto capture = import(folder_ / "a.mp4", {.size = 512});
  ASSERT_TRUE(capture) << capture.error().what;
  EXPECT_THAT(capture->warnings, ::testing::Contains(HasSubstr("enlarged")));
}

}  // namespace
}  // namespace likeness
