// Claims about undo: a drag is one step, and going back and forth loses nothing.
#include "ui/history.h"

#include <gtest/gtest.h>

namespace likeness::ui {
namespace {

TEST(History, ADragIsOneStep) {
  History<int> history(0);
  for (int i = 1; i <= 10; ++i) history.edit(i);
  history.commit();
  EXPECT_TRUE(history.can_undo());
  history.undo();
  EXPECT_EQ(history.value(), 0);
  EXPECT_FALSE(history.can_undo());
  history.redo();
  EXPECT_EQ(history.value(), 10);
}

TEST(History, BackAndForthPassesEveryStep) {
  History<int> history(0);
  for (const int value : {1, 2, 3}) history.edit(value), history.commit();
  for (const int value : {2, 1, 0, 0}) {
    history.undo();
    EXPECT_EQ(history.value(), value);
  }
  for (const int value : {1, 2, 3, 3}) {
    history.redo();
    EXPECT_EQ(history.value(), value);
  }
}

TEST(History, AnUnfinishedEditIsUndoneAsAStep) {
  History<int> history(0);
  history.edit(5);
  EXPECT_TRUE(history.can_undo());
  history.undo();
  EXPECT_EQ(history.value(), 0);
  history.redo();
  EXPECT_EQ(history.value(), 5);
}

TEST(History, ANewChangeForgetsWhatWasUndone) {
  History<int> history(0);
  history.edit(1), history.commit();
  history.undo();
  history.edit(2), history.commit();
  EXPECT_FALSE(history.can_redo());
  EXPECT_EQ(history.value(), 2);
}

TEST(History, NoChangeIsNoStep) {
  History<int> history(0);
  history.edit(1), history.edit(0), history.commit();
  EXPECT_FALSE(history.can_undo());
}

}  // namespace
}  // namespace likeness::ui
