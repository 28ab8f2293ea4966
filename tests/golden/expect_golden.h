// Comparison with a small picture kept in tests/golden, within three limits.
// LIKENESS_WRITE_GOLDEN=1 writes the picture anew instead: look at it before it is kept.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/image/files.h"

namespace likeness::test {

// Of the channels' differences, 0..255.
struct GoldenLimits {
  double mean = 4;       // usual error
  int off = 24;          // a channel that differs by more is off,
  double off_share = 0;  // and of those there may be this share
  int worst = 255;       // none differs by more
};

inline void expect_golden(const Image8& picture, const std::string& name, const GoldenLimits& limits) {
  const std::filesystem::path file =
      std::filesystem::path(LIKENESS_SOURCE) / "tests/golden" / (name + ".png");
  ASSERT_LE(std::max(picture.width, picture.height), 256) << name;
  if (std::getenv("LIKENESS_WRITE_GOLDEN")) {
    ASSERT_TRUE(write_image(file, picture, {.png_level = 9}).ok()) << file;
  }
  const auto golden = read_image(file);
  ASSERT_TRUE(golden.ok()) << golden.error().what;
  EXPECT_LE(std::filesystem::file_size(file), 60'000u) << name;
  ASSERT_EQ(golden->width, picture.width) << name;
  ASSERT_EQ(golden->data.size(), picture.data.size()) << name;
  double sum = 0;
  std::size_t off = 0;
  int worst = 0;
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    const int difference = std::abs(int(picture.data[i]) - int(golden->data[i]));
    sum += difference;
    off += difference > limits.off;
    worst = std::max(worst, difference);
  }
  EXPECT_LE(sum / double(picture.data.size()), limits.mean) << name;
  EXPECT_LE(double(off) / double(picture.data.size()), limits.off_share) << name;
  EXPECT_LE(worst, limits.worst) << name;
}

}  // namespace likeness::test
