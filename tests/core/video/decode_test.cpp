// Claims about decoding: colours, times and orientation are correct, and every bad file is diagnosed.
#include "core/video/decode.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include <fmt/format.h>

#include "core/base/files.h"
#include "tests/core/video/tag_rotation.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class Decode : public InFolder {
 protected:
  fs::path cut(const fs::path& from, double share) const {
    const auto whole = read_file(from);
    EXPECT_TRUE(whole);
    const fs::path to = from.parent_path() / from.stem().concat(".cut.mp4");
    EXPECT_TRUE(write_file(to, std::span(*whole).first(std::size_t(double(whole->size()) * share))));
    return to;
  }
  static Error error_of(const fs::path& path) {
    auto reader = VideoReader::open(path);
    if (!reader) return reader.error();
    while (true) {
      auto frame = reader->next();
      if (!frame) return frame.error();
      if (!*frame) return reader->fault().value_or(Error{ErrorCode::failed, "no error", "", ""});
    }
  }
  static bool have_ffmpeg() { return std::system("ffmpeg -version > /dev/null 2>&1") == 0; }
  int ffmpeg(const std::string& arguments) const {
    return std::system(("cd '" + folder_.string() + "' && ffmpeg -y -loglevel error " + arguments).c_str());
  }
};

void expect_near(const std::uint8_t* pixel, int r, int g, int b, int tolerance, const std::string& what) {
  EXPECT_NEAR(pixel[0], r, tolerance) << what;
  EXPECT_NEAR(pixel[1], g, tolerance) << what;
  EXPECT_NEAR(pixel[2], b, tolerance) << what;
}

// Numbers and times of the frames that a reader gives.
std::vector<std::pair<int, double>> frames_of(VideoReader& reader) {
  std::vector<std::pair<int, double>> frames;
  while (true) {
    const auto next = reader.next();
    EXPECT_TRUE(next) << next.error().what;
    if (!next || !*next) return frames;
    frames.emplace_back((*next)->index, (*next)->time_s);
  }
}

TEST_F(Decode, SomeSecondsOfAFilmKeepTheirNumbersAndTimes) {
  write_clip(folder_ / "a.mp4", 64, 48, 100);
  for (const std::uint64_t room : {std::uint64_t(0), std::uint64_t(1) << 30}) {
    auto reader = VideoReader::open(folder_ / "a.mp4");
    ASSERT_TRUE(reader);
    reader->show_seconds({1, 2.2});
    reader->keep_frames(room);
    for (int pass = 0; pass < 2; ++pass) {
      const auto frames = frames_of(*reader);
      ASSERT_EQ(frames.size(), 30u);
      for (std::size_t i = 0; i < frames.size(); ++i) {
        EXPECT_EQ(frames[i].first, 25 + int(i));
        EXPECT_NEAR(frames[i].second, 1 + double(i) / 25, 1e-6);
      }
      ASSERT_TRUE(reader->rewind(VideoPixels::luma));
    }
  }
  auto from = VideoReader::open(folder_ / "a.mp4");
  from->show_seconds({3.5, 0});
  EXPECT_EQ(frames_of(*from).size(), 12u);  // 88 is at 3.52 s
}

TEST_F(Decode, AFilmThatEndsAtAFrameIsNotReadBeyondIt) {
  write_clip(folder_ / "a.mp4", 64, 48, 100);
  auto reader = VideoReader::open(folder_ / "a.mp4");
  ASSERT_TRUE(reader);
  reader->start_at(10);
  reader->end_at(19);
  const auto frames = frames_of(*reader);
  ASSERT_EQ(frames.size(), 10u);
  EXPECT_EQ(frames.front().first, 10);
  EXPECT_EQ(frames.back().first, 19);
}

TEST_F(Decode, RoundTripsColoursTimesAndNumbers) {
  write_clip(folder_ / "a.mp4", 128, 96, 60, 30);
  auto reader = VideoReader::open(folder_ / "a.mp4");
  ASSERT_TRUE(reader) << reader.error().what;
  EXPECT_EQ(reader->info().width, 128);
  EXPECT_EQ(reader->info().height, 96);
  EXPECT_EQ(reader->info().frame_count, 60);
  EXPECT_NEAR(reader->info().frames_per_second, 30, 1e-6);
  EXPECT_NEAR(reader->info().duration_s, 2, 1e-3);
  EXPECT_EQ(reader->info().codec, "h264");
  for (int i = 0; i < 60; ++i) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame) << frame.error().what;
    ASSERT_TRUE(frame->has_value()) << i;
    const VideoFrame& f = **frame;
    EXPECT_EQ(f.index, i);
    EXPECT_NEAR(f.time_s, i / 30.0, 1e-3);
    const std::string what = std::string("frame ").append(std::to_string(i));
    expect_near(f.rgb.at(30, 20), 200, 30, 40, 4, what);
    expect_near(f.rgb.at(98, 20), 30, 180, 60, 4, what);
    expect_near(f.rgb.at(30, 70), 20, 50, 210, 4, what);
    const int level = 40 + 5 * (i % 40);
    expect_near(f.rgb.at(98, 70), level, level, level, 3, what);
  }
  const auto end = reader->next();
  ASSERT_TRUE(end);
  EXPECT_FALSE(end->has_value());
  EXPECT_FALSE(reader->next()->has_value());
}

TEST_F(Decode, AppliesTheRotationTag) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to tag a rotation";
  write_clip(folder_ / "a.mp4", 128, 64, 10);
  // What the ffmpeg program shows is the reference for the sense of the turn.
  for (const int degrees : {90, 180, 270}) {
    const std::string name = std::string("r").append(std::to_string(degrees));
    ASSERT_TRUE(test::tag_rotation(folder_, "a.mp4", name + ".mp4", degrees));
    ASSERT_EQ(ffmpeg("-i " + name + ".mp4 -frames:v 1 -pix_fmt rgb24 -f rawvideo " + name + ".rgb"), 0);
    auto reader = VideoReader::open(folder_ / (name + ".mp4"));
    ASSERT_TRUE(reader) << reader.error().what;
    const bool turned = degrees != 180;
    EXPECT_EQ(reader->info().width, turned ? 64 : 128);
    EXPECT_EQ(reader->info().height, turned ? 128 : 64);
    EXPECT_NE(reader->info().rotation_deg, 0);
    const auto frame = reader->next();
    ASSERT_TRUE(frame && *frame);
    const auto reference = read_file(folder_ / (name + ".rgb"));
    ASSERT_TRUE(reference);
    ASSERT_EQ(reference->size(), (*frame)->rgb.data.size());
    const int width = reader->info().width, height = reader->info().height;
    for (const auto& [x, y] :
         {std::pair{width / 4, height / 4}, {3 * width / 4, height / 4}, {width / 4, 3 * height / 4}}) {
      const auto* r = reinterpret_cast<const std::uint8_t*>(reference->data()) + 3 * (y * width + x);
      expect_near((*frame)->rgb.at(x, y), r[0], r[1], r[2], 6, name);
    }
  }
}

TEST_F(Decode, RefusesPicturesLargerThanAnyCameras) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make a clip of odd pixels";
  write_clip(folder_ / "a.mp4", 1024, 1024, 2);
  ASSERT_EQ(ffmpeg("-i a.mp4 -vf setsar=60/1 wide.mp4"), 0);
  ASSERT_EQ(ffmpeg("-i a.mp4 -vf setsar=70/1 wider.mp4"), 0);
  const auto wide = VideoReader::open(folder_ / "wide.mp4");
  ASSERT_TRUE(wide) << wide.error().what;
  EXPECT_EQ(wide->info().width, 60 * 1024);
  const auto wider = VideoReader::open(folder_ / "wider.mp4");
  ASSERT_FALSE(wider);
  EXPECT_EQ(wider.error().code, ErrorCode::bad_input);
  EXPECT_NE(wider.error().what.find("71680 x 1024"), std::string::npos) << wider.error().what;
}

TEST_F(Decode, KeepsVariableFrameTimes) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to retime a clip";
  // How long the last one is shown is not said, and versions of ffmpeg differ on whether it is then played at
  // all.
  write_clip(folder_ / "a.mp4", 64, 64, 21);
  ASSERT_EQ(ffmpeg("-i a.mp4 -vf \"setpts='if(lt(N,10),N/25,0.4+(N-10)*0.12)/TB'\" -vsync vfr v.mp4"), 0);
  auto reader = VideoReader::open(folder_ / "v.mp4");
  ASSERT_TRUE(reader) << reader.error().what;
  for (int i = 0; i < 20; ++i) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame && *frame) << i;
    EXPECT_NEAR((*frame)->time_s, i < 10 ? i / 25.0 : 0.4 + (i - 10) * 0.12, 2e-3) << i;
  }
}

TEST_F(Decode, MeasuresTheRateOfAFileThatDoesNotStateIt) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make a WebM file";
  write_clip(folder_ / "a.mp4", 64, 64, 90);
  // Thirty a second, each a little late.
  ASSERT_EQ(
      ffmpeg("-i a.mp4 -vf \"settb=1/1000,setpts='floor((N+0.4*mod(7*N,5)/5)/30/TB)'\" -vsync passthrough "
             "-enc_time_base 1/1000 -c:v libvpx b.webm"),
      0);
  // As browsers write it: without the track's default duration (EBML element 0x23E383), here made void.
  auto bytes = *read_file(folder_ / "b.webm");
  const std::array<std::byte, 3> wanted{std::byte(0x23), std::byte(0xe3), std::byte(0x83)};
  const auto at = std::search(bytes.begin(), bytes.end(), wanted.begin(), wanted.end());
  if (at != bytes.end()) {
    const int length = int(at[3]) & 0x7f;  // of its data, one byte said how many
    ASSERT_LE(length, 8);
    at[0] = std::byte(0xec), at[1] = std::byte(0x80 | (length + 2));
  }
  ASSERT_TRUE(write_file(folder_ / "c.webm", bytes).ok());
  const auto info = probe_video(folder_ / "c.webm");
  ASSERT_TRUE(info) << info.error().what;
  EXPECT_NEAR(info->frames_per_second, 30, 1);
  EXPECT_NEAR(info->frame_count, 90, 4);
  EXPECT_EQ(sampling_stride(*info), 1);
}

TEST_F(Decode, ReadsFullRangeTenBitAndMatroska) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make other formats";
  write_clip(folder_ / "a.mp4", 64, 64, 5);
  const std::string cases[] = {
      "-vf scale=out_range=full:out_color_matrix=bt709,format=yuv420p -color_range pc -colorspace bt709 "
      "full.mp4",
      "-vf scale=out_color_matrix=bt601:out_range=tv,format=yuv420p -color_range tv -colorspace smpte170m "
      "sd.mp4",
      "-vf format=yuv420p10le -colorspace bt709 ten.mkv"};
  for (const auto& arguments : cases) {
    ASSERT_EQ(ffmpeg("-i a.mp4 -crf 10 " + arguments), 0) << arguments;
    auto reader = VideoReader::open(folder_ / arguments.substr(arguments.rfind(' ') + 1));
    ASSERT_TRUE(reader) << reader.error().what;
    const auto frame = reader->next();
    ASSERT_TRUE(frame && *frame) << arguments;
    expect_near((*frame)->rgb.at(16, 16), 200, 30, 40, 5, arguments);
    expect_near((*frame)->rgb.at(48, 16), 30, 180, 60, 5, arguments);
    expect_near((*frame)->rgb.at(16, 48), 20, 50, 210, 5, arguments);
  }
}

TEST_F(Decode, MapsHighDynamicRangeToNaturalGreys) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make an HLG clip";
  // HLG signal 0.75 is diffuse white, near the top of what is left after highlights are compressed; half the
  // signal is a middle grey. Neutral stays neutral.
  const std::pair<std::string, int> cases[] = {{"0x000000", 0}, {"0x808080", 137}, {"0xBFBFBF", 243}};
  for (const auto& [colour, expected] : cases) {
    ASSERT_EQ(ffmpeg("-f lavfi -i color=c=" + colour +
                     ":s=64x64:r=25:d=0.2 -vf scale=out_color_matrix=bt2020:out_range=tv,format=yuv420p10le,"
                     "setparams=range=tv:color_primaries=bt2020:color_trc=arib-std-b67:colorspace=bt2020nc "
                     "-crf 5 hlg.mp4"),
              0);
    auto reader = VideoReader::open(folder_ / "hlg.mp4");
    ASSERT_TRUE(reader) << reader.error().what;
    const auto frame = reader->next();
    ASSERT_TRUE(frame && *frame);
    expect_near((*frame)->rgb.at(32, 32), expected, expected, expected, 4, colour);
  }
}

TEST_F(Decode, ALumaReaderGivesTheLumaOfTheSameFrames) {
  write_clip(folder_ / "a.mp4", 64, 64, 12);
  auto reader = VideoReader::open(folder_ / "a.mp4", VideoPixels::luma);
  ASSERT_TRUE(reader);
  for (int i = 0; i < 12; ++i) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame && *frame);
    const Image8& luma = (*frame)->rgb;
    ASSERT_EQ(luma.channels, 1);
    EXPECT_NEAR(*luma.at(48, 48), 40 + 5 * i, 3);
    EXPECT_NEAR(*luma.at(16, 16), 0.2126 * 200 + 0.7152 * 30 + 0.0722 * 40, 4);
  }
  EXPECT_FALSE(reader->next()->has_value());
}

TEST_F(Decode, ATruncatedFileNamesTheLastFrame) {
  write_clip(folder_ / "a.mp4", 128, 96, 80);
  for (const double share : {0.5, 0.9}) {
    const Error error = error_of(cut(folder_ / "a.mp4", share));
    EXPECT_EQ(error.code, ErrorCode::bad_input) << error.what;
    EXPECT_THAT(error.what, HasSubstr("is cut short"));
    EXPECT_THAT(error.what, HasSubstr("of about 80"));
    EXPECT_THAT(error.fix, HasSubstr("Copy it again"));
  }
}

// What a recorder leaves that crashed, or a copy that was not completed: whatever comes before is good.
TEST_F(Decode, AFilmThatIsCutShortOrDamagedEndsThere) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make Matroska and fragmented files";
  write_clip(folder_ / "a.mp4", 64, 64, 120);
  ASSERT_EQ(ffmpeg("-i a.mp4 -c copy -cluster_time_limit 500 b.mkv"), 0);
  ASSERT_EQ(ffmpeg("-i a.mp4 -c:v libx264 -g 12 -movflags frag_keyframe+empty_moov -sc_threshold 0 c.mp4"),
            0);
  auto damaged = *read_file(folder_ / "a.mp4");
  std::fill(damaged.begin() + std::ptrdiff_t(damaged.size() * 0.7), damaged.end() - 100, std::byte(0x5A));
  ASSERT_TRUE(write_file(folder_ / "d.mp4", damaged));
  for (const fs::path& file : {cut(folder_ / "a.mp4", 0.8), cut(folder_ / "b.mkv", 0.7),
                               cut(folder_ / "c.mp4", 0.8), folder_ / "d.mp4"}) {
    auto reader = VideoReader::open(file);
    ASSERT_TRUE(reader) << file << reader.error().what;
    EXPECT_FALSE(reader->fault()) << "nothing is known yet";
    const auto frames = frames_of(*reader);
    EXPECT_GT(frames.size(), 50u) << file;
    EXPECT_LT(frames.size(), 120u) << file;
    ASSERT_TRUE(reader->fault()) << file;
    const std::string said = fault_words(*reader->fault());
    EXPECT_THAT(said, HasSubstr(fmt::format("after frame {}", frames.size()))) << file;
    EXPECT_THAT(said, HasSubstr(fmt::format("{:.1f} s from its start", frames.back().second))) << file;
    EXPECT_THAT(said, HasSubstr("Only what comes before is used.")) << file;
    // Every reader of it finds the same end.
    ASSERT_TRUE(reader->rewind(VideoPixels::luma));
    EXPECT_EQ(frames_of(*reader), frames) << file;
    EXPECT_TRUE(reader->fault()) << file;
  }
}

// Where the last fragment's list of pictures itself is cut, nothing counts what is lost.
TEST_F(Decode, AFilmThatIsCutWithinAFragmentsListIsCutShort) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make fragmented files";
  write_clip(folder_ / "a.mp4", 64, 64, 60);
  ASSERT_EQ(ffmpeg("-i a.mp4 -c:v libx264 -g 12 -movflags frag_keyframe+empty_moov -sc_threshold 0 c.mp4"),
            0);
  const auto bytes = *read_file(folder_ / "c.mp4");
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t last = text.rfind("moof");
  ASSERT_NE(last, std::string_view::npos);
  ASSERT_TRUE(write_file(folder_ / "d.mp4", std::span(bytes).first(last + 20)));
  EXPECT_THAT(error_of(folder_ / "d.mp4").what, HasSubstr("is cut short after frame 48"));
}

TEST_F(Decode, ATruncatedFileWithItsIndexAtTheEndIsNamedIncomplete) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to put the index at the end";
  write_clip(folder_ / "a.mp4", 64, 64, 30);
  ASSERT_EQ(ffmpeg("-i a.mp4 -c copy -movflags -faststart b.mp4"), 0);
  const Error error = error_of(cut(folder_ / "b.mp4", 0.8));
  EXPECT_EQ(error.code, ErrorCode::bad_input);
  EXPECT_THAT(error.what, HasSubstr("is cut short before its index"));
}

// FFmpeg opens a playlist by its first line, whatever its name, and all that it names.
TEST_F(Decode, WhatLeadsToOtherFilesIsNotOpened) {
  write_clip(folder_ / "victim.mp4", 64, 64, 10);
  const std::pair<const char*, std::string> lists[] = {
      {"hls.mp4", "#EXTM3U\n#EXT-X-TARGETDURATION:2\n#EXTINF:2,\n" + (folder_ / "victim.mp4").string() +
                      "\n#EXT-X-ENDLIST\n"},
      {"concat.mkv", "ffconcat version 1.0\nfile victim.mp4\n"}};
  for (const auto& [name, text] : lists) {
    ASSERT_TRUE(write_text(folder_ / name, text).ok());
    const Error error = error_of(folder_ / name);
    EXPECT_EQ(error.code, ErrorCode::bad_input) << name;
    EXPECT_THAT(error.what, HasSubstr("none of the kinds of video")) << name;
    EXPECT_THAT(error.fix, HasSubstr("convert")) << name;
  }
}

TEST_F(Decode, OtherKindsAreRefusedWithTheirName) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make other formats";
  write_clip(folder_ / "a.mp4", 64, 64, 5);
  ASSERT_EQ(ffmpeg("-i a.mp4 -f gif b.mp4"), 0);
  EXPECT_THAT(error_of(folder_ / "b.mp4").what, HasSubstr("GIF"));
  ASSERT_EQ(ffmpeg("-i a.mp4 -c:v cinepak c.avi"), 0);
  EXPECT_THAT(error_of(folder_ / "c.avi").what, HasSubstr("cinepak"));
}

// What it claims decides how many of its frames are taken, and what is made ready for them.
TEST_F(Decode, ALengthThatTheFileHasNoRoomForIsNotBelieved) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make Matroska files";
  write_clip(folder_ / "a.mp4", 64, 64, 50);
  ASSERT_EQ(ffmpeg("-i a.mp4 -c:v copy a.mkv"), 0);
  auto bytes = *read_file(folder_ / "a.mkv");
  const std::string was = "00:00:02.000000000", is = "99:59:59.000000000";
  const auto tag = std::search(bytes.begin(), bytes.end(), was.begin(), was.end(),
                               [](std::byte a, char b) { return char(a) == b; });
  ASSERT_NE(tag, bytes.end());
  std::transform(is.begin(), is.end(), tag, [](char c) { return std::byte(c); });
  ASSERT_TRUE(write_file(folder_ / "long.mkv", bytes).ok());
  auto reader = VideoReader::open(folder_ / "long.mkv");
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->info().frame_count, 0);
  EXPECT_EQ(reader->info().duration_s, 0);
  EXPECT_EQ(sampling_stride(reader->info()), 1);
  EXPECT_EQ(frames_of(*reader).size(), 50u);
}

// A Matroska file claims the length of its longest stream, counted from zero.
TEST_F(Decode, AMatroskaFileIsJudgedByItsOwnPictures) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make Matroska files";
  write_clip(folder_ / "a.mp4", 64, 64, 50);
  const std::string cases[] = {
      "-i a.mp4 -f lavfi -i sine=d=9 -map 0:v -map 1:a -c:v copy -c:a aac sound.mkv",
      "-itsoffset 4 -i a.mp4 -f lavfi -i sine=d=4 -map 0:v -map 1:a -c:v copy -c:a aac late.mkv",
      "-i a.mp4 -c:v copy -output_ts_offset 4 clock.mkv",
      "-i a.mp4 -f lavfi -i sine=d=9 -map 0:v -map 1:a -c:v libvpx -c:a libopus sound.webm"};
  for (const std::string& arguments : cases) {
    ASSERT_EQ(ffmpeg(arguments), 0) << arguments;
    auto reader = VideoReader::open(folder_ / arguments.substr(arguments.rfind(' ') + 1));
    ASSERT_TRUE(reader) << arguments;
    EXPECT_NEAR(reader->info().duration_s, 2, 0.1) << arguments;
    EXPECT_NEAR(reader->info().frame_count, 50, 3) << arguments;
    EXPECT_EQ(frames_of(*reader).size(), 50u) << arguments;
  }
}

TEST_F(Decode, ATruncatedMatroskaFileIsToldFromAWholeOne) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make Matroska files";
  write_clip(folder_ / "a.mp4", 64, 64, 50);
  ASSERT_EQ(
      ffmpeg(
          "-i a.mp4 -f lavfi -i sine=d=2 -map 0:v -map 1:a -c:v copy -c:a aac -cluster_time_limit 500 b.mkv"),
      0);
  EXPECT_THAT(error_of(cut(folder_ / "b.mkv", 0.7)).what, HasSubstr("is cut short after frame"));
  // What is missing here is the index alone, and what nothing claims to be there is not missing.
  const auto bytes = *read_file(folder_ / "b.mkv");
  const std::array<std::byte, 4> index{std::byte(0x1c), std::byte(0x53), std::byte(0xbb), std::byte(0x6b)};
  const auto at = std::find_end(bytes.begin(), bytes.end(), index.begin(), index.end());
  ASSERT_NE(at, bytes.end());
  ASSERT_TRUE(write_file(folder_ / "c.mkv", std::span(bytes).first(std::size_t(at - bytes.begin()) + 8)));
  EXPECT_EQ(error_of(folder_ / "c.mkv").what, "no error");
  ASSERT_EQ(ffmpeg("-i b.mkv -c copy -live 1 -f matroska pipe:1 | cat > live.mkv"), 0);
  EXPECT_EQ(error_of(cut(folder_ / "live.mkv", 0.7)).what, "no error");
}

// Copied by a program that had reserved the room: all elements are whole, and nothing is in the last ones.
TEST_F(Decode, AMatroskaFileWhoseTailIsEmptyIsCutShort) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make Matroska files";
  write_clip(folder_ / "a.mp4", 64, 64, 150);
  ASSERT_EQ(ffmpeg("-i a.mp4 -c copy -cluster_time_limit 500 b.mkv"), 0);
  auto bytes = *read_file(folder_ / "b.mkv");
  const std::array<std::byte, 4> cluster{std::byte(0x1f), std::byte(0x43), std::byte(0xb6), std::byte(0x75)};
  const auto middle = bytes.begin() + std::ptrdiff_t(bytes.size() / 2);
  const auto at = std::search(middle, bytes.end(), cluster.begin(), cluster.end());
  ASSERT_NE(at, bytes.end());
  std::fill(at, bytes.end(), std::byte(0));
  ASSERT_TRUE(write_file(folder_ / "b.mkv", bytes).ok());
  EXPECT_THAT(error_of(folder_ / "b.mkv").what, HasSubstr("is cut short after frame"));
}

// Joined recordings each bring a clock of their own.
TEST_F(Decode, TimesRiseWhereTheClockJumpsBack) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make a transport stream";
  write_clip(folder_ / "a.mp4", 64, 64, 50);
  ASSERT_EQ(ffmpeg("-i a.mp4 -c copy a.ts"), 0);
  auto bytes = *read_file(folder_ / "a.ts");
  const auto more = bytes;
  bytes.insert(bytes.end(), more.begin(), more.end());
  ASSERT_TRUE(write_file(folder_ / "joined.ts", bytes).ok());
  auto reader = VideoReader::open(folder_ / "joined.ts");
  ASSERT_TRUE(reader.ok());
  const auto frames = frames_of(*reader);
  ASSERT_EQ(frames.size(), 100u);
  for (std::size_t i = 1; i < frames.size(); ++i) EXPECT_GT(frames[i].second, frames[i - 1].second) << i;
  EXPECT_NEAR(frames.back().second, 99 / 25.0, 0.1);
}

TEST_F(Decode, WhatAFilmHidesIsNotSeen) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make films with alpha";
  const std::string source =
      "-f lavfi -i \"color=c=red:s=96x64:r=25:d=0.2,format=yuva444p,geq=lum='lum(X,Y)':cb='cb(X,Y)':"
      "cr='cr(X,Y)':a='if(between(X,32,63),255,0)'\" ";
  for (const std::string& film :
       {std::string("-pix_fmt yuva420p -c:v libvpx-vp9 -b:v 1M vp9.webm"),
        std::string("-pix_fmt yuva420p -c:v libvpx -auto-alt-ref 0 -b:v 1M vp8.webm"),
        std::string("-pix_fmt yuva444p10le -c:v prores_ks -profile:v 4444 prores.mov"),
        std::string("-pix_fmt rgba -c:v qtrle animation.mov")}) {
    ASSERT_EQ(ffmpeg(source + film), 0) << film;
    auto reader = VideoReader::open(folder_ / film.substr(film.rfind(' ') + 1));
    ASSERT_TRUE(reader.ok()) << film;
    const auto frame = reader->next();
    ASSERT_TRUE(frame.ok() && *frame) << film;
    ASSERT_FALSE((*frame)->alpha.empty()) << film;
    expect_near((*frame)->rgb.at(8, 32), 128, 128, 128, 3, film);
    EXPECT_GT((*frame)->rgb.at(48, 32)[0], 230) << film;
    EXPECT_NEAR(*(*frame)->alpha.at(8, 32), 0, 3) << film;
    EXPECT_NEAR(*(*frame)->alpha.at(48, 32), 255, 3) << film;
  }
}

// Calls and turned phones: what the header says of the picture holds for the beginning.
TEST_F(Decode, APictureThatChangesItsShapeKeepsItsProportions) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to join films";
  // A white disc, in its own place of either.
  const auto disc = [&](const std::string& name, int width, int height) {
    Image8 picture(width, height, 3, 60);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (std::hypot(x - width / 2, y - height / 2) < width / 4.0) std::fill_n(picture.at(x, y), 3, 250);
    auto writer = VideoWriter::create(folder_ / (name + ".mp4"), width, height, {.crf = 4});
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < 6; ++i) ASSERT_TRUE(writer->add(picture).ok());
    ASSERT_TRUE(writer->finish().ok());
    ASSERT_EQ(ffmpeg("-i " + name + ".mp4 -c:v libvpx -crf 4 -b:v 4M " + name + ".webm"), 0);
  };
  disc("wide", 256, 256), disc("tall", 180, 320);
  std::ofstream(folder_ / "list.txt") << "file wide.webm\nfile tall.webm\nfile wide.webm\n";
  ASSERT_EQ(ffmpeg("-f concat -i list.txt -c copy turned.webm"), 0);
  for (const VideoPixels pixels : {VideoPixels::rgb, VideoPixels::luma}) {
    auto reader = VideoReader::open(folder_ / "turned.webm", pixels);
    ASSERT_TRUE(reader.ok());
    for (int i = 0; i < 18; ++i) {
      const auto frame = reader->next();
      ASSERT_TRUE(frame.ok() && *frame) << i;
      const Image8& picture = (*frame)->rgb;
      EXPECT_EQ((*frame)->shape, i / 6 == 1 ? 1 : 0) << i;
      ASSERT_EQ(picture.width, 256);
      ASSERT_EQ(picture.height, 256);
      int wide = 0, high = 0;
      for (int k = 0; k < 256; ++k) wide += *picture.at(k, 128) > 180, high += *picture.at(128, k) > 180;
      EXPECT_GT(wide, 60) << i;
      EXPECT_NEAR(double(wide) / high, 1, 0.03) << i;
      if (i / 6 == 1) {
        EXPECT_LT(*picture.at(20, 128), 20) << "nothing was filmed there";
      }
    }
    EXPECT_TRUE(reader->changed_shape());
    EXPECT_EQ(reader->shape_part(0), (PixelRect{0, 0, 256, 256}));
    EXPECT_EQ(reader->shape_part(1), (PixelRect{56, 0, 144, 256}));
  }
}

// The same pixels, which are to be shown wider from the middle on.
TEST_F(Decode, PixelsThatChangeTheirShapeAreShownByIt) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to join films";
  write_clip(folder_ / "a.mp4", 96, 96, 6);
  ASSERT_EQ(ffmpeg("-i a.mp4 -c copy -bsf:v h264_metadata=sample_aspect_ratio=1/1 a.ts"), 0);
  ASSERT_EQ(
      ffmpeg("-i a.mp4 -c copy -bsf:v h264_metadata=sample_aspect_ratio=2/1 -output_ts_offset 0.24 b.ts"), 0);
  auto bytes = *read_file(folder_ / "a.ts");
  const auto more = *read_file(folder_ / "b.ts");
  bytes.insert(bytes.end(), more.begin(), more.end());
  ASSERT_TRUE(write_file(folder_ / "c.ts", bytes).ok());
  auto reader = VideoReader::open(folder_ / "c.ts");
  ASSERT_TRUE(reader.ok());
  int frames = 0, shapes = 0;
  while (true) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame.ok()) << frame.error().what;
    if (!*frame) break;
    ++frames, shapes = std::max(shapes, (*frame)->shape);
    EXPECT_EQ((*frame)->rgb.width, 96);
    if ((*frame)->shape == 1) {
      EXPECT_LT((*frame)->rgb.at(48, 10)[0] + (*frame)->rgb.at(48, 10)[1], 40);
    }
  }
  EXPECT_EQ(frames, 12);
  EXPECT_EQ(shapes, 1);
}

// A tagged default wins, then the first: FFmpeg itself would take the larger one.
TEST_F(Decode, OfTwoPicturesTheDefaultOneIsRead) {
  if (!have_ffmpeg()) GTEST_SKIP() << "needs the ffmpeg program to make two tracks";
  write_clip(folder_ / "a.mp4", 64, 64, 10), write_clip(folder_ / "b.mp4", 160, 96, 10);
  const std::string two = "-i a.mp4 -i b.mp4 -map 0:v -map 1:v -c copy ";
  ASSERT_EQ(ffmpeg(two + "-disposition:v:0 default -disposition:v:1 0 first.mkv"), 0);
  ASSERT_EQ(ffmpeg(two + "-disposition:v:0 0 -disposition:v:1 default second.mkv"), 0);
  ASSERT_EQ(ffmpeg(two + "-disposition:v:0 0 -disposition:v:1 0 neither.mkv"), 0);
  EXPECT_EQ(probe_video(folder_ / "first.mkv")->width, 64);
  EXPECT_EQ(probe_video(folder_ / "second.mkv")->width, 160);
  EXPECT_EQ(probe_video(folder_ / "neither.mkv")->width, 64);
}

TEST_F(Decode, DamageInTheMiddleIsAnErrorThatSaysWhere) {
  write_clip(folder_ / "a.mp4", 128, 96, 80);
  auto bytes = read_file(folder_ / "a.mp4");
  ASSERT_TRUE(bytes);
  for (std::size_t i = bytes->size() / 2; i < bytes->size() * 3 / 4; ++i) (*bytes)[i] = std::byte(0x5A);
  ASSERT_TRUE(write_file(folder_ / "damaged.mp4", *bytes));
  const Error error = error_of(folder_ / "damaged.mp4");
  EXPECT_EQ(error.code, ErrorCode::bad_input);
  EXPECT_THAT(error.what, HasSubstr("damaged after frame"));
  EXPECT_FALSE(error.fix.empty());
}

TEST_F(Decode, AnErrorIsRepeatedByLaterCalls) {
  write_clip(folder_ / "a.mp4", 128, 96, 40);
  auto reader = VideoReader::open(cut(folder_ / "a.mp4", 0.6));
  ASSERT_TRUE(reader);
  std::string first;
  for (int i = 0; i < 100 && first.empty(); ++i) {
    const auto frame = reader->next();
    if (!frame) first = frame.error().what;
  }
  ASSERT_FALSE(first.empty());
  const auto again = reader->next();
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().what, first);
}

TEST_F(Decode, DistinguishesMissingEmptyTextFolderAndSoundOnly) {
  EXPECT_EQ(error_of(folder_ / "missing.mp4").code, ErrorCode::not_found);

  std::ofstream(folder_ / "empty.mp4").close();
  EXPECT_EQ(error_of(folder_ / "empty.mp4").code, ErrorCode::bad_input);
  EXPECT_THAT(error_of(folder_ / "empty.mp4").what, HasSubstr("is empty"));

  std::ofstream(folder_ / "text.mp4")
      << "Dear diary,\n\nthis is not a video at all, whatever its name may say.\n";
  EXPECT_EQ(error_of(folder_ / "text.mp4").code, ErrorCode::bad_input);
  EXPECT_THAT(error_of(folder_ / "text.mp4").what, HasSubstr("not a video"));

  fs::create_directory(folder_ / "folder.mp4");
  EXPECT_EQ(error_of(folder_ / "folder.mp4").code, ErrorCode::bad_input);
  EXPECT_THAT(error_of(folder_ / "folder.mp4").what, HasSubstr("folder"));

  // A WAV file of silence, written by hand: 44 bytes of header, 8 kHz, 16 bit.
  const auto word = [](std::uint32_t v) {
    return std::string{char(v), char(v >> 8), char(v >> 16), char(v >> 24)};
  };
  const std::string format = word(0x00010001) + word(8000) + word(16000) + word(0x00100002);
  std::ofstream(folder_ / "sound.mp4", std::ios::binary)
      << "RIFF" << word(36 + 16000) << "WAVEfmt " << word(16) << format << "data" << word(16000)
      << std::string(16000, '\0');
  EXPECT_EQ(error_of(folder_ / "sound.mp4").code, ErrorCode::bad_input);
  EXPECT_THAT(error_of(folder_ / "sound.mp4").what, HasSubstr("WAV"));
}

TEST_F(Decode, ProbeAgreesWithTheReader) {
  write_clip(folder_ / "a.mp4", 64, 48, 10, 24);
  const auto info = probe_video(folder_ / "a.mp4");
  ASSERT_TRUE(info);
  EXPECT_EQ(info->width, 64);
  EXPECT_EQ(info->frame_count, 10);
  EXPECT_FALSE(probe_video(folder_ / "missing.mp4"));
}

TEST(DecodeCapture, ReadsEveryFrameOfARealClipAtItsRate) {
  const fs::path clip = fs::path(LIKENESS_SHARED) / "captures" / "wojtek.mp4";
  if (!fs::exists(clip)) GTEST_SKIP() << clip << " is not here";
  auto reader = VideoReader::open(clip);
  ASSERT_TRUE(reader) << reader.error().what;
  EXPECT_DOUBLE_EQ(reader->info().frames_per_second, 25);
  int count = 0;
  while (true) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame) << frame.error().what;
    if (!*frame) break;
    ASSERT_EQ((*frame)->index, count);
    ASSERT_NEAR((*frame)->time_s, count / 25.0, 1e-3);
    ++count;
  }
  EXPECT_EQ(count, 400);
}

}  // namespace
}  // namespace likeness
