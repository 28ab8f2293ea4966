// Claims about output: the file name decides the format, and impossible requests are refused before long
// work.
#include "core/export/write_out.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/direct/edit_keys.h"
#include "core/render/render.h"
#include "core/video/decode.h"
#include "core/video/encode.h"
#include "tests/core/export/tiny_project.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

TEST(WriteOut, RefusesPictureOptionsForAMesh) {
  const OpenedAvatar opened = tiny_opened();
  const Intrinsics& picture = opened.avatar.intrinsics;
  const auto fine = [&](const FilmOptions& options, std::size_t frames = 1) {
    return check_output(opened.avatar, picture, frames, options).ok();
  };
  EXPECT_TRUE(fine({.out = "head.glb"}));
  EXPECT_FALSE(fine({.out = "head.glb", .background = "plate"}));
  EXPECT_FALSE(fine({.out = "head.glb", .width = 64}));
  EXPECT_FALSE(fine({.out = "head.glb", .alpha = true}));
  EXPECT_FALSE(fine({.out = "head.glb", .mark = true}));
  EXPECT_FALSE(fine({.out = "head.ply"}, 2));
  EXPECT_TRUE(fine({.out = "still.png", .background = "plate"}));
}

TEST(WriteOut, FileNameDecidesTheFormat) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  const Film film = resting_film(opened.avatar);
  for (const char* name : {"still.png", "film.mp4", "head.glb", "head.ply"}) {
    const auto written = write_posed(opened, film, {.out = project.root / name}, Progress(), {});
    ASSERT_TRUE(written.ok()) << written.error().what;
    EXPECT_EQ(*written, 1);
    EXPECT_TRUE(fs::exists(project.root / name)) << name;
  }
}

TEST(WriteOut, APerformanceHasItsOwnLengthAndRate) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  Performance performance;
  performance.duration_s = 0.3, performance.frames_per_second = 10;
  set_key(performance, "head yaw", {0, 10});
  const fs::path out = project.root / "film.mp4";
  const auto written = write_performed(opened, performance, {.out = out, .width = 48}, Progress(), {});
  ASSERT_TRUE(written.ok()) << written.error().what;
  EXPECT_EQ(*written, 3);
  const auto info = probe_video(out);
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->width, 48);
  EXPECT_EQ(info->height, 32);
  EXPECT_DOUBLE_EQ(info->frames_per_second, 10);
}

TEST(WriteOut, ADrivingClipIsNeverOverwritten) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  const fs::path clip = project.root / "clip.mp4";
  auto writer = VideoWriter::create(clip, 64, 48);
  ASSERT_TRUE(writer.ok() && writer->add(Image8(64, 48, 3, 90)).ok() && writer->finish().ok());
  const auto before = read_text(clip);
  const auto written = write_driven(opened, {.video = clip}, {.out = clip}, false, Progress(), {});
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::bad_input);
  EXPECT_EQ(*read_text(clip), *before);
  const auto keys =
      write_driven(opened, {.video = clip}, {.out = project.root / "k.json"}, true, Progress(), {});
  ASSERT_FALSE(keys.ok());
  EXPECT_NE(keys.error().fix.find("--side-by-side"), std::string::npos);
}

}  // namespace
}  // namespace likeness::test
