// A rendered person as films of the tests show one: moves a little, and is filmed once for all tests of a
// program.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <vector>

#include "core/head/builtin_head.h"
#include "core/image/image.h"
#include "core/synth/demo_stage.h"
#include "core/video/encode.h"

namespace likeness::test {

inline constexpr int kDemoSide = 192, kDemoFrames = 48;

// 25 a second, the camera at rest. The face is some 70 px wide.
inline const std::vector<Image8>& demo_pictures() {
  static const std::vector<Image8> frames = [] {
    DemoOptions options;
    options.width = options.height = kDemoSide;
    options.samples_per_pixel = 1;
    options.moving_share = 0;
    DemoStage stage(make_builtin_head(), options);
    std::vector<Image8> all;
    for (int f = 0; f < kDemoFrames; ++f) all.push_back(stage.film(f, {}).rgb);
    return all;
  }();
  return frames;
}

inline void write_film(const std::filesystem::path& path, const std::vector<Image8>& frames,
                       const EncodeOptions& options = {}) {
  auto writer = VideoWriter::create(path, frames.front().width, frames.front().height, options);
  ASSERT_TRUE(writer) << writer.error().what;
  for (const Image8& frame : frames) ASSERT_TRUE(writer->add(frame));
  ASSERT_TRUE(writer->finish());
}

// A folder that is removed again.
struct FilmFolder {
  FilmFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "likeness_film_XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) path = name;
  }
  ~FilmFolder() {
    if (!path.empty()) std::filesystem::remove_all(path);
  }
  std::filesystem::path path;
};

}  // namespace likeness::test
