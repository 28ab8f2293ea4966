// Claims about the history: undo restores exactly, within its memory.
#include "core/direct/performance_history.h"

#include <gtest/gtest.h>

#include "core/direct/edit_keys.h"

namespace likeness::test {
namespace {

TEST(PerformanceHistory, UndoAndRedoRestoreExactly) {
  PerformanceHistory history(Performance{});
  std::vector<Performance> states{history.present()};
  for (int i = 0; i < 5; ++i) {
    Performance next = history.present();
    set_key(next, "head yaw", {double(i), float(i)});
    states.push_back(next);
    history.record(next, "key " + std::to_string(i));
  }
  EXPECT_EQ(history.undo_name(), "key 4");
  for (int i = 4; i >= 0; --i) {
    ASSERT_TRUE(history.can_undo());
    history.undo();
    EXPECT_EQ(history.present(), states[std::size_t(i)]);
  }
  EXPECT_FALSE(history.can_undo());
  EXPECT_EQ(history.redo_name(), "key 0");
  history.redo();
  EXPECT_EQ(history.present(), states[1]);
  history.record(states[5], "another way");
  EXPECT_FALSE(history.can_redo());
  history.undo();
  EXPECT_EQ(history.present(), states[1]);
}

TEST(PerformanceHistory, AHeldSliderIsOneStep) {
  PerformanceHistory history(Performance{});
  for (int i = 0; i < 50; ++i) {
    Performance next = history.present();
    set_key(next, "action jawOpen", {0, float(i)});
    history.record(next, "jawOpen", 1);
  }
  EXPECT_FLOAT_EQ(value_at(history.present(), "action jawOpen", 0), 49);
  Performance next = history.present();
  set_key(next, "action jawOpen", {0, 0});
  history.record(next, "jawOpen", 2);
  history.undo();
  EXPECT_FLOAT_EQ(value_at(history.present(), "action jawOpen", 0), 49);
  history.undo();
  EXPECT_TRUE(history.present().channels.empty());
  EXPECT_FALSE(history.can_undo());
}

TEST(PerformanceHistory, ForgetsTheOldestWhenItTakesTooMuch) {
  Performance dense;
  for (int i = 0; i < 1000; ++i) dense.channels["head yaw"].push_back({i * 0.04, float(i)});
  constexpr std::size_t kBudget = 200'000;
  PerformanceHistory history(dense, kBudget);
  for (int i = 0; i < 100; ++i) {
    dense.channels["head yaw"][0].value = float(i);
    history.record(dense, "turn");
    EXPECT_LE(history.bytes(), kBudget);
  }
  int undone = 0;
  for (; history.can_undo(); ++undone) history.undo();
  EXPECT_GE(undone, 3);
  EXPECT_LT(undone, 20);
  EXPECT_FLOAT_EQ(history.present().channels.at("head yaw")[0].value, float(99 - undone));
  // One that is larger than the budget is still the present.
  PerformanceHistory tight(dense, 1);
  EXPECT_EQ(tight.present(), dense);
}

}  // namespace
}  // namespace likeness::test
