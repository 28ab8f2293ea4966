// Claims about the masks' state and pictures, without a window: painting, taking back, and what is drawn.
#include "ui/studio/masks.h"

#include <gtest/gtest.h>

namespace likeness::ui {
namespace {

Stroke mask_dab(StrokeMark mark, double x) { return {mark, 4, {{x, 10}}}; }

Masks opened() {
  Masks masks;
  masks.open({{3, {mask_dab(StrokeMark::person, 1)}}},
             {{7, Error{ErrorCode::bad_input, "damaged", "mend", ""}}});
  masks.set_frames({1, 3, 5, 7, 9});
  return masks;
}

TEST(Masks, ShowTheMiddleFrameAndStepToTheEnds) {
  Masks masks = opened();
  EXPECT_EQ(masks.frame(), 5);
  masks.step(1);
  EXPECT_EQ(masks.frame(), 7);
  masks.step(100);
  EXPECT_EQ(masks.frame(), 9);
  masks.step(-100);
  EXPECT_EQ(masks.frame(), 1);
  masks.look_at(4);
  EXPECT_EQ(masks.frame(), 1) << "4 has no mask";
  masks.set_frames({1, 2});
  EXPECT_EQ(masks.frame(), 1);
  masks.set_frames({});
  EXPECT_EQ(masks.frame(), -1);
  EXPECT_FALSE(masks.paint(mask_dab(StrokeMark::person, 1)));
}

TEST(Masks, StrokesAreTakenBackAndPutBackOnTheirOwnFrame) {
  Masks masks = opened();
  const auto edit = masks.edit();
  ASSERT_TRUE(masks.paint(mask_dab(StrokeMark::background, 2)));
  masks.look_at(3);
  ASSERT_TRUE(masks.paint(mask_dab(StrokeMark::person, 5)));
  EXPECT_GT(masks.edit(), edit);
  EXPECT_EQ(masks.take_unsaved(), (std::set<int>{3, 5}));
  EXPECT_TRUE(masks.take_unsaved().empty());
  masks.look_at(9);
  ASSERT_TRUE(masks.undo());
  EXPECT_EQ(masks.frame(), 3) << "what changes is shown";
  EXPECT_EQ(masks.strokes(3)->size(), 1u);
  ASSERT_TRUE(masks.undo());
  EXPECT_EQ(masks.frame(), 5);
  EXPECT_TRUE(masks.strokes(5)->empty());
  EXPECT_FALSE(masks.undo());
  EXPECT_EQ(masks.view().corrected, std::set<int>{3});
  ASSERT_TRUE(masks.redo());
  EXPECT_EQ(masks.strokes(5)->front(), mask_dab(StrokeMark::background, 2));
  EXPECT_TRUE(masks.can_redo());
  ASSERT_TRUE(masks.paint(mask_dab(StrokeMark::person, 8)));
  EXPECT_FALSE(masks.can_redo()) << "another change ends what could be put back";
}

TEST(Masks, WhatChangedOnTheDiskCountsButForWhatIsNotSavedYet) {
  Masks masks = opened();
  masks.look_at(3);
  ASSERT_TRUE(masks.paint(mask_dab(StrokeMark::person, 5)));
  masks.take_unsaved();
  // As it was saved: nothing happens, and it can still be taken back.
  masks.refresh({{3, *masks.strokes(3)}}, {{7, Error{}}});
  EXPECT_TRUE(masks.can_undo());
  masks.look_at(9);
  ASSERT_TRUE(masks.paint(mask_dab(StrokeMark::background, 6)));
  // Somebody mended one file and removed another; the newest stroke is still on its way to the disk.
  masks.refresh({{7, {mask_dab(StrokeMark::person, 2)}}}, {});
  EXPECT_TRUE(masks.strokes(3)->empty());
  EXPECT_EQ(masks.strokes(7)->size(), 1u);
  EXPECT_EQ(masks.strokes(9)->size(), 1u);
  EXPECT_TRUE(masks.view().unreadable.empty());
  EXPECT_FALSE(masks.can_undo());
  EXPECT_TRUE(masks.has_unsaved());
}

TEST(Masks, AFrameIsClearedInOneStep) {
  Masks masks = opened();
  masks.look_at(3);
  masks.paint(mask_dab(StrokeMark::person, 5));
  ASSERT_TRUE(masks.clear());
  EXPECT_TRUE(masks.strokes(3)->empty());
  EXPECT_FALSE(masks.clear());
  masks.undo();
  EXPECT_EQ(masks.strokes(3)->size(), 2u);
}

TEST(Masks, NothingIsPaintedOverAFileThatCannotBeRead) {
  Masks masks = opened();
  masks.look_at(7);
  EXPECT_FALSE(masks.paint(mask_dab(StrokeMark::person, 1)));
  EXPECT_TRUE(masks.take_unsaved().empty());
  masks.was_set_aside(7);
  EXPECT_TRUE(masks.paint(mask_dab(StrokeMark::person, 1)));
}

TEST(Masks, AnEraserOnAFrameWithoutStrokesIsNoChange) {
  Masks masks = opened();
  EXPECT_FALSE(masks.paint(mask_dab(StrokeMark::erase, 1)));
  EXPECT_FALSE(masks.can_undo());
}

TEST(Masks, AnotherProjectsStrokesCannotBeTakenBack) {
  Masks masks = opened();
  masks.paint(mask_dab(StrokeMark::person, 1));
  masks.open({}, {});
  EXPECT_FALSE(masks.can_undo());
  EXPECT_TRUE(masks.take_unsaved().empty());
}

TEST(Masks, ManyChangesForgetTheOldest) {
  Masks masks = opened();
  for (int i = 0; i < 250; ++i) ASSERT_TRUE(masks.paint(mask_dab(StrokeMark::person, i)));
  int undone = 0;
  while (masks.undo()) ++undone;
  EXPECT_EQ(undone, 200);
  EXPECT_EQ(masks.strokes(5)->size(), 50u);
}

// Left half person, right half background, on grey.
MaskSource half() {
  MaskSource source{0, Image8(64, 64, 3, 120), Image8(64, 64, 1)};
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 32; ++x) *source.alpha.at(x, y) = 255;
  return source;
}

TEST(MaskPictures, TintTheBackgroundAndDrawTheOutline) {
  const Image8 drawn = draw_mask(half(), {}, {0, 0, 64}, MaskLook::picture);
  const int y = drawn.height / 2, w = drawn.width;
  EXPECT_EQ(drawn.at(w / 8, y)[0], 120) << "the person as filmed";
  EXPECT_LT(drawn.at(w - w / 8, y)[0], 100);
  EXPECT_GT(drawn.at(w - w / 8, y)[2], 140);
  int yellow = 0;
  for (int x = 0; x < w; ++x) yellow += drawn.at(x, y)[0] > 200 && drawn.at(x, y)[2] < 120;
  EXPECT_GE(yellow, 1);
  EXPECT_LE(yellow, 8);
}

TEST(MaskPictures, ShowWhatStrokesSayAtOnce) {
  const Strokes strokes{{StrokeMark::person, 8, {{48, 32}}}, {StrokeMark::background, 8, {{16, 32}}}};
  const Image8 matte = draw_mask(half(), strokes, {0, 0, 64}, MaskLook::matte);
  const int w = matte.width, y = matte.height / 2;
  EXPECT_EQ(matte.at(w / 4, y)[0], 0);
  EXPECT_EQ(matte.at(w * 3 / 4, y)[0], 255);
  EXPECT_EQ(matte.at(w / 32, y)[0], 255);
  EXPECT_EQ(matte.at(w * 31 / 32, y)[0], 0);
  const Image8 picture = draw_mask(half(), strokes, {0, 0, 64}, MaskLook::picture);
  const std::uint8_t *person = picture.at(w * 3 / 4, y), *background = picture.at(w / 4, y);
  EXPECT_GT(person[1], person[0]);
  EXPECT_GT(background[0], background[1]);
  const Image8 cut_out = draw_mask(half(), {}, {0, 0, 64}, MaskLook::cut_out);
  EXPECT_EQ(cut_out.at(w / 8, y)[0], 120);
  EXPECT_GT(cut_out.at(w - w / 8, y)[0], 150);
}

}  // namespace
}  // namespace likeness::ui
