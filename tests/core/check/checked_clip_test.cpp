// Claims about check.json: what was found is read as it was written, and nothing else is.
#include "core/check/checked_clip.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "tests/core/capture/demo_film.h"

namespace likeness {
namespace {

TEST(CheckedClipFile, IsReadAsItWasWritten) {
  const test::FilmFolder folder;
  const std::filesystem::path path = checked_clip_path(folder.path);
  EXPECT_FALSE(read_checked_clip(path).ok());
  CheckedClip checked{.clip_hash = "0123"};
  checked.verdict = {Verdict::refilm,
                     {{Fault::no_face, true, 0, 12.5, "No face was found.", "Keep it in the picture."}},
                     true};
  checked.facts.camera = {CameraKind::handheld, false, false, "It moves."};
  checked.facts.mask = {MaskPrior::person_network, 30, 28};
  checked.facts.parts = {.seconds = 12.5, .faceless_s = 3, .frames = 375, .width = 64, .height = 48};
  checked.facts.parts.film = {4, 0, 56, 48};
  checked.facts.parts.shots = {{0, 99, 0, 3.3, false, "no face"}, {100, 374, 3.3, 12.5, true, ""}};
  ASSERT_TRUE(write_checked_clip(path, checked).ok());
  const auto read = read_checked_clip(path);
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(read->clip_hash, "0123");
  EXPECT_EQ(read->verdict.verdict, Verdict::refilm);
  EXPECT_TRUE(read->verdict.faceless);
  ASSERT_EQ(read->verdict.remarks.size(), 1u);
  EXPECT_EQ(read->verdict.remarks[0].what, "No face was found.");
  EXPECT_EQ(read->verdict.remarks[0].to_s, 12.5);
  EXPECT_EQ(camera_sentence(read->facts.camera), camera_sentence(checked.facts.camera));
  EXPECT_EQ(mask_sentence(read->facts.mask), mask_sentence(checked.facts.mask));
  EXPECT_EQ(parts_sentence(read->facts.parts), parts_sentence(checked.facts.parts));
  // What is damaged counts as not there.
  const std::string text = *read_text(path);
  ASSERT_TRUE(write_text(path, text.substr(0, text.size() / 2)).ok());
  EXPECT_FALSE(read_checked_clip(path).ok());
  std::string other = text;
  other.replace(other.find("refilm"), 6, "reread");
  ASSERT_TRUE(write_text(path, other).ok());
  EXPECT_FALSE(read_checked_clip(path).ok());
}

}  // namespace
}  // namespace likeness
