// Claims about the people drawn by hand: each file belongs to a clip that is there, and names frames of it.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/lab/truth/person_marks.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

TEST(RealPersonMarks, AreOfTheClipsThatAreThere) {
  const fs::path shared = LIKENESS_SHARED;
  if (!fs::exists(shared / "captures")) GTEST_SKIP() << "no real clips at " << shared;
  for (const auto& entry :
       fs::directory_iterator(fs::path(LIKENESS_SOURCE) / "tests/core/lab/truth/person_marks")) {
    const auto marks = read_person_marks(entry.path());
    ASSERT_TRUE(marks) << marks.error().what;
    fs::path clip = shared / "captures" / marks->clip;
    if (!fs::exists(clip)) clip = shared / "driving" / marks->clip;
    if (!fs::exists(clip)) continue;  // one clip less than the drawings are of
    const auto hash = hash_video(clip);
    ASSERT_TRUE(hash) << hash.error().what;
    EXPECT_EQ(*hash, marks->video_hash) << clip;
    const auto info = probe_video(clip);
    ASSERT_TRUE(info) << info.error().what;
    EXPECT_EQ(info->width, marks->width) << clip;
    EXPECT_EQ(info->height, marks->height) << clip;
    for (const PersonOutline& outline : marks->frames) EXPECT_LT(outline.frame, info->frame_count) << clip;
  }
}

}  // namespace
}  // namespace likeness
