// Claims about the attributes painted in the window: one change is one step of undo, and what was not saved
// is not overwritten by what is read.
#include "ui/studio/attribute_paint.h"

#include <gtest/gtest.h>

namespace likeness::ui {
namespace {

Stroke attribute_dab(double x, StrokeMark mark = StrokeMark::person) { return {mark, 3, {{x, 5}}}; }

TEST(AttributePaint, EveryChangeIsTakenBackAndDoneAgain) {
  AttributePaint paint;
  paint.open({}, std::nullopt);
  paint.choose("dimple");
  EXPECT_FALSE(paint.paint(3, 1, attribute_dab(1, StrokeMark::erase))) << "there is nothing to take away";
  std::vector<PaintedAttributes> states{*paint.all()};
  const auto changed = [&](bool done) {
    EXPECT_TRUE(done);
    states.push_back(*paint.all());
  };
  changed(paint.paint(3, 0.5f, attribute_dab(1)));
  changed(paint.paint(3, 0.9f, attribute_dab(2)));
  EXPECT_EQ(find_annotation(*paint.all(), "dimple", 3)->value, 0.5) << "a frame keeps its amount";
  changed(paint.set_value(3, 1));
  EXPECT_FALSE(paint.set_value(3, 1));
  changed(paint.set_value(8, 0));
  changed(paint.clear(3));
  EXPECT_FALSE(paint.clear(3));
  changed(paint.remove("dimple"));
  EXPECT_TRUE(paint.all()->empty());
  for (std::size_t i = states.size() - 1; i-- > 0;) {
    ASSERT_TRUE(paint.undo());
    EXPECT_EQ(*paint.all(), states[i]) << i;
  }
  EXPECT_FALSE(paint.undo());
  for (std::size_t i = 1; i < states.size(); ++i) {
    ASSERT_TRUE(paint.redo());
    EXPECT_EQ(*paint.all(), states[i]) << i;
  }
  EXPECT_FALSE(paint.redo());
}

TEST(AttributePaint, WhatWasNotSavedStaysAndADamagedFileIsNotPaintedOver) {
  AttributePaint paint;
  paint.open({}, std::nullopt);
  ASSERT_TRUE(paint.paint(3, 1, attribute_dab(1)));
  const PaintedAttributes mine = *paint.all();
  paint.refresh({}, std::nullopt);
  EXPECT_EQ(*paint.all(), mine);
  EXPECT_TRUE(paint.take_unsaved());
  EXPECT_FALSE(paint.take_unsaved());
  const std::uint64_t before = paint.edit();
  paint.refresh({}, std::nullopt);
  EXPECT_TRUE(paint.all()->empty());
  EXPECT_FALSE(paint.can_undo()) << "of what is no more";
  EXPECT_GT(paint.edit(), before);
  paint.refresh({}, Error{ErrorCode::bad_input, "damaged", "mend it", ""});
  EXPECT_FALSE(paint.paint(3, 1, attribute_dab(1)));
  EXPECT_TRUE(paint.view().unreadable.has_value());
}

}  // namespace
}  // namespace likeness::ui
