// Claims about films written in pieces: what a killed process left of one is finished, once, under its own
// name.
#include "core/video/finish_film.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <regex>

#include "core/base/files.h"
#include "core/video/decode.h"
#include "core/video/encode.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class FinishFilm : public InFolder {
 protected:
  // Hidden files of the folder.
  std::vector<fs::path> hidden() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder_))
      if (entry.path().filename().string().starts_with(".")) found.push_back(entry.path());
    return found;
  }
  // As a process that was killed after so many pictures leaves it.
  void leave_unfinished(int pictures) {
    auto writer = VideoWriter::create(folder_ / "a.mp4", 64, 48,
                                      {.frames_per_second = 10, .timed = true, .survives = true});
    ASSERT_TRUE(writer.ok()) << writer.error().what;
    for (int i = 0; i < pictures; ++i) ASSERT_TRUE(writer->add(quadrant_frame(64, 48, i % 20), 0.1 * i).ok());
    const auto written = hidden();
    ASSERT_EQ(written.size(), 1u);
    EXPECT_TRUE(finish_abandoned_films(folder_).empty()) << "it is still written";
    fs::copy_file(written.front(), folder_ / ".a.recording.999999999-7.part.mp4");
  }
};

TEST_F(FinishFilm, WhatAKilledRecordingLeftIsAFilm) {
  leave_unfinished(150);
  ASSERT_TRUE(write_text(folder_ / "a.mp4", "another").ok());
  const auto films = finish_abandoned_films(folder_);
  ASSERT_EQ(films.size(), 1u);
  EXPECT_EQ(films.front(), folder_ / "a-2.mp4");
  EXPECT_TRUE(hidden().empty());
  auto reader = VideoReader::open(films.front());
  ASSERT_TRUE(reader.ok()) << reader.error().what;
  int count = 0;
  for (auto frame = reader->next(); frame && *frame; frame = reader->next(), ++count)
    EXPECT_NEAR((*frame)->time_s, 0.1 * count, 1e-3);
  EXPECT_GT(count, 60);  // but for what the encoder still held, some seconds
  EXPECT_EQ(reader->info().frame_count, count);
  EXPECT_TRUE(finish_abandoned_films(folder_).empty());
}

TEST_F(FinishFilm, APieceOfALongNameIsFoundAndNobodyElseRemovesIt) {
  const std::string name(240, 'n');
  const fs::path pieces = unfinished_film_name(folder_ / (name + ".mp4"));
  leave_unfinished(150);
  fs::rename(folder_ / ".a.recording.999999999-7.part.mp4",
             folder_ / std::regex_replace(pieces.filename().string(), std::regex(R"(\.\d+-\d+\.part)"),
                                          ".999999999-7.part"));
  remove_abandoned_parts(folder_);
  const auto films = finish_abandoned_films(folder_);
  ASSERT_EQ(films.size(), 1u);
  EXPECT_TRUE(films.front().filename().string().starts_with("nnnn"));
}

TEST_F(FinishFilm, WhatAnotherStillWritesIsLeftAlone) {
  leave_unfinished(150);
  const fs::path pieces = folder_ / ".a.recording.999999999-7.part.mp4";
  auto held = lock_pieces(pieces);
  ASSERT_TRUE(held);
  EXPECT_TRUE(finish_abandoned_films(folder_).empty());
  EXPECT_TRUE(path_exists(pieces));
  held = nullptr;
  EXPECT_EQ(finish_abandoned_films(folder_).size(), 1u);
}

TEST_F(FinishFilm, WhatHoldsNoPictureGoes) {
  leave_unfinished(1);
  EXPECT_TRUE(finish_abandoned_films(folder_).empty());
  EXPECT_TRUE(hidden().empty());
}

TEST_F(FinishFilm, AFilmOfTheSameNameClearsWhatAKillLeftOfAnother) {
  const fs::path left = folder_ / ".b.999999999-7.part.mp4";
  ASSERT_TRUE(write_text(left, "half a film").ok());
  auto writer = VideoWriter::create(folder_ / "b.mp4", 64, 48, {});
  ASSERT_TRUE(writer.ok());
  EXPECT_FALSE(path_exists(left));
}

}  // namespace
}  // namespace likeness
