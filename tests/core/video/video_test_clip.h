// Clips made in code for the tests of core/video: moving coloured patches whose true colours are known.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/image/image.h"
#include "core/video/encode.h"

namespace likeness {

// Four quadrants: red, green, blue, grey of the frame's own level.
inline Image8 quadrant_frame(int width, int height, int index) {
  Image8 image(width, height, 3);
  const auto level = std::uint8_t(40 + 5 * (index % 40));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::uint8_t* p = image.at(x, y);
      const bool right = x >= width / 2, low = y >= height / 2;
      if (!low && !right) p[0] = 200, p[1] = 30, p[2] = 40;
      if (!low && right) p[0] = 30, p[1] = 180, p[2] = 60;
      if (low && !right) p[0] = 20, p[1] = 50, p[2] = 210;
      if (low && right) p[0] = p[1] = p[2] = level;
    }
  }
  return image;
}

inline void write_clip(const std::filesystem::path& path, int width, int height, int frames,
                       double rate = 25) {
  auto writer = VideoWriter::create(path, width, height, {.frames_per_second = rate, .crf = 12});
  ASSERT_TRUE(writer) << writer.error().what;
  for (int i = 0; i < frames; ++i) {
    const auto added = writer->add(quadrant_frame(width, height, i));
    ASSERT_TRUE(added) << added.error().what;
  }
  const auto finished = writer->finish();
  ASSERT_TRUE(finished) << finished.error().what;
}

// A folder of its own for each test, removed afterwards.
class InFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("likeness_video_" + std::to_string(getpid()) + "_" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::size_t files() const {
    return std::size_t(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  std::filesystem::path folder_;
};

}  // namespace likeness
