// Claims about copying a clip's sound.
#include "core/video/copy_sound.h"

#include <gtest/gtest.h>
#include <unistd.h>

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

}  // namespace
}  // namespace likeness
