// Claims about copying a clip's sound.
#include "core/video/copy_sound.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <complex>
#include <cstdlib>
#include <cstring>
#include <numbers>

#include "core/base/files.h"
#include "core/video/decode.h"
#include "core/video/encode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

fs::path write_film(const std::string& name, int frames) {
  const fs::path path =
      fs::temp_directory_path() / ("likeness_sound_" + std::to_string(::getpid()) + "_" + name + ".mp4");
  auto writer = VideoWriter::create(path, 64, 48);
  EXPECT_TRUE(writer.ok());
  for (int f = 0; f < frames; ++f) EXPECT_TRUE(writer->add(Image8(64, 48, 3, std::uint8_t(8 * f))).ok());
  EXPECT_TRUE(writer->finish().ok());
  return path;
}

int count_frames(const fs::path& path) {
  auto reader = VideoReader::open(path);
  EXPECT_TRUE(reader.ok());
  int count = 0;
  while (true) {
    const auto next = reader->next();
    EXPECT_TRUE(next.ok());
    if (!next.ok() || !next->has_value()) return count;
    ++count;
  }
}

TEST(CopySound, AClipWithoutSoundLeavesTheFilmAsItIs) {
  const fs::path silent = write_film("silent", 5), film = write_film("film", 8);
  const auto bytes = fs::file_size(film);
  const auto copied = copy_sound(silent, film);
  ASSERT_TRUE(copied.ok());
  EXPECT_FALSE(copied->copied);
  EXPECT_FALSE(copied->why_not.empty());
  EXPECT_EQ(fs::file_size(film), bytes);
  fs::remove(silent), fs::remove(film);
}

TEST(CopySound, FilmKeepsItsPicturesAndGainsTheSound) {
  const fs::path talking = fs::path(LIKENESS_SHARED) / "driving" / "talking_1.mp4";
  if (!fs::exists(talking)) GTEST_SKIP() << "needs " << talking.string();
  const fs::path film = write_film("with", 20), next = write_film("next", 20);
  const auto copied = copy_sound(talking, film);
  ASSERT_TRUE(copied.ok()) << copied.error().what;
  EXPECT_TRUE(copied->copied) << copied->why_not;
  EXPECT_EQ(count_frames(film), 20);
  const auto again = copy_sound(film, next);  // the film now has sound of its own to give
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(again->copied);
  EXPECT_LT(probe_video(film)->duration_s, 1.0) << "the sound ends with the pictures";
  fs::remove(film), fs::remove(next);
}

bool ffmpeg(const std::string& arguments) {
  return std::system(("ffmpeg -y -loglevel error " + arguments + " 2> /dev/null").c_str()) == 0;
}

// Of the first sound: how loud the tone of a pitch is.
double tone(const fs::path& film, int hertz) {
  const fs::path raw = film.string() + ".raw";
  EXPECT_TRUE(ffmpeg("-i " + film.string() + " -ac 1 -ar 8000 -f s16le " + raw.string()));
  const auto bytes = read_file(raw);
  EXPECT_TRUE(bytes.ok());
  fs::remove(raw);
  std::complex<double> sum;
  const std::size_t count = bytes->size() / 2;
  for (std::size_t i = 0; i < count; ++i) {
    std::int16_t value = 0;
    std::memcpy(&value, bytes->data() + 2 * i, 2);
    sum += value / 32768.0 * std::polar(1.0, -2 * std::numbers::pi * hertz * double(i) / 8000);
  }
  return count > 0 ? 2 * std::abs(sum) / double(count) : 0;
}

// As phones write it: beside the sound for everybody a richer one, of a kind that nobody else knows.
TEST(CopySound, OfSeveralTracksTheDefaultOneThatAnMp4CanHold) {
  if (!ffmpeg("-version > /dev/null")) GTEST_SKIP() << "needs the ffmpeg program to make sound";
  const fs::path film = write_film("tracks", 25), clip = film.string() + ".clip.mov";
  const auto make = [&](const std::string& first_kind, const std::string& dispositions) {
    EXPECT_TRUE(ffmpeg("-i " + film.string() +
                       " -f lavfi -i sine=f=440:d=1 -f lavfi -i sine=f=1000:d=1 -map 0:v -map 1:a -map 2:a "
                       "-c:v copy -c:a aac -b:a:0 32k -b:a:1 192k " +
                       first_kind + dispositions + clip.string()));
  };
  const auto copied = [&] {
    const fs::path next = write_film("next", 25);
    const auto done = copy_sound(clip, next);
    EXPECT_TRUE(done.ok() && done->copied) << (done.ok() ? done->why_not : done.error().what);
    const bool first = tone(next, 440) > tone(next, 1000);
    fs::remove(next);
    return first ? 440 : 1000;
  };
  const std::string first_is_default = "-disposition:a:0 default -disposition:a:1 0 ";
  make("", first_is_default);
  EXPECT_EQ(copied(), 440);
  make("", "-disposition:a:0 0 -disposition:a:1 default ");
  EXPECT_EQ(copied(), 1000);
  // The default one is of a kind that no mp4 holds, then of one that is not known at all.
  make("-c:a:0 pcm_s16le ", first_is_default);
  EXPECT_EQ(copied(), 1000);
  auto bytes = *read_file(clip);
  const std::string_view known = "sowt";
  const auto at = std::search(bytes.begin(), bytes.end(), known.begin(), known.end(),
                              [](std::byte a, char b) { return a == std::byte(b); });
  ASSERT_NE(at, bytes.end());
  std::memcpy(&*at, "apac", 4);
  ASSERT_TRUE(write_file(clip, bytes).ok());
  EXPECT_EQ(copied(), 1000);
  fs::remove(film), fs::remove(clip);
}

TEST(CopySound, BeginsWhereTheFilmDoes) {
  if (!ffmpeg("-version > /dev/null")) GTEST_SKIP() << "needs the ffmpeg program to make sound";
  const fs::path film = write_film("late", 50), clip = film.string() + ".clip.mp4";
  ASSERT_TRUE(ffmpeg("-i " + film.string() +
                     " -f lavfi -i sine=f=440:d=1 -f lavfi -i sine=f=1000:d=1 -filter_complex "
                     "[1:a][2:a]concat=v=0:a=1 -c:v copy -c:a aac " +
                     clip.string()));
  const fs::path end = write_film("end", 22);
  const auto copied = copy_sound(clip, end, 1.1);
  ASSERT_TRUE(copied.ok() && copied->copied);
  EXPECT_GT(tone(end, 1000), 20 * tone(end, 440));
  fs::remove(film), fs::remove(clip), fs::remove(end);
}

}  // namespace
}  // namespace likeness
