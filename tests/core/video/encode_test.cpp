// Claims about encoding: whole or not at all, odd sizes padded, tags written.
#include "core/video/encode.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <random>

#include "core/base/files.h"
#include "core/video/decode.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class Encode : public InFolder {};

TEST_F(Encode, PadsOddSizesByRepeatingTheBorder) {
  write_clip(folder_ / "a.mp4", 101, 75, 8);
  auto reader = VideoReader::open(folder_ / "a.mp4");
  ASSERT_TRUE(reader) << reader.error().what;
  EXPECT_EQ(reader->info().width, 102);
  EXPECT_EQ(reader->info().height, 76);
  const auto frame = reader->next();
  ASSERT_TRUE(frame && *frame);
  const std::uint8_t* corner = (*frame)->rgb.at(101, 10);
  EXPECT_NEAR(corner[0], 30, 6);
  EXPECT_NEAR(corner[1], 180, 6);
}

TEST_F(Encode, UnfinishedLeavesNothingAndFinishedLeavesOneFile) {
  {
    auto writer = VideoWriter::create(folder_ / "a.mp4", 64, 64);
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->add(quadrant_frame(64, 64, 0)));
  }
  EXPECT_EQ(files(), 0u);
  write_clip(folder_ / "a.mp4", 64, 64, 3);
  EXPECT_EQ(files(), 1u);
}

TEST_F(Encode, AnUnfinishedVideoLeavesTheOldOneUntouched) {
  write_clip(folder_ / "a.mp4", 64, 64, 3);
  const auto before = read_file(folder_ / "a.mp4");
  {
    auto writer = VideoWriter::create(folder_ / "a.mp4", 64, 64);
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->add(quadrant_frame(64, 64, 0)));
  }
  const auto after = read_file(folder_ / "a.mp4");
  ASSERT_TRUE(before && after);
  EXPECT_EQ(*before, *after);
}

// They come from files.
TEST_F(Encode, ATimeBeforeTheStartIsMovedToIt) {
  auto writer = VideoWriter::create(folder_ / "a.mp4", 64, 64, {.timed = true});
  ASSERT_TRUE(writer.ok());
  for (const double time_s : {-2.0, 0.5, 0.2}) ASSERT_TRUE(writer->add(Image8(64, 64, 3, 90), time_s).ok());
  EXPECT_TRUE(writer->finish().ok());
}

TEST_F(Encode, PutsTheIndexFirst) {
  write_clip(folder_ / "a.mp4", 64, 64, 12);
  const auto text = read_text(folder_ / "a.mp4");
  ASSERT_TRUE(text);
  EXPECT_LT(text->find("moov"), text->find("mdat"));
}

TEST_F(Encode, TheSameFramesGiveTheSameBytes) {
  write_clip(folder_ / "a.mp4", 64, 64, 12);
  write_clip(folder_ / "b.mp4", 64, 64, 12);
  EXPECT_EQ(*read_file(folder_ / "a.mp4"), *read_file(folder_ / "b.mp4"));
}

TEST_F(Encode, AFullDiskIsAnErrorAndLeavesNothing) {
  // A limit on file size stands in for a full disk: the write call fails part way.
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{100000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  std::optional<Error> error;
  {
    auto writer = VideoWriter::create(folder_ / "a.mp4", 256, 256, {.crf = 1});
    std::mt19937 random(1);
    for (int i = 0; writer && i < 80 && !error; ++i) {
      Image8 noise(256, 256, 3);
      for (auto& v : noise.data) v = std::uint8_t(random());
      const auto added = writer->add(noise);
      if (!added) error = added.error();
    }
    if (writer && !error) {
      const auto finished = writer->finish();
      if (!finished) error = finished.error();
    }
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_TRUE(error);
  EXPECT_TRUE(error->code == ErrorCode::io || error->code == ErrorCode::no_space);
  EXPECT_THAT(error->what, HasSubstr("a.mp4"));
  EXPECT_FALSE(error->fix.empty());
  EXPECT_EQ(files(), 0u);
}

TEST_F(Encode, RefusesAnotherExtensionAndAnUnwritablePlace) {
  const auto wrong = VideoWriter::create(folder_ / "a.txt", 64, 64);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, ErrorCode::bad_input);
  const auto nowhere = VideoWriter::create("/proc/no such place/a.mp4", 64, 64);
  ASSERT_FALSE(nowhere);
  EXPECT_FALSE(nowhere.error().fix.empty());
}

}  // namespace
}  // namespace likeness
