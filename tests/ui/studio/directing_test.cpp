// Claims about directing: a drag is one step of undo, keys are chosen, moved and pasted, and the playhead
// keeps to its pictures.
#include "ui/studio/directing.h"

#include <gtest/gtest.h>

namespace likeness::ui {
namespace {

using std::chrono::milliseconds;

// Two channels of two keys, at 0 and 2 s; 4 s long.
Directing two_channels() {
  Performance performance;
  for (const char* channel : {"head yaw", "action jawOpen"}) {
    set_key(performance, channel, {0, 0});
    set_key(performance, channel, {2, 1});
  }
  Directing directing;
  directing.open(performance);
  return directing;
}

// A slider that is dragged over these values and let go.
void drag(Directing& directing, std::initializer_list<float> values) {
  for (const float value : values) {
    DirectingRequests requests;
    Performance edited = *directing.performance();
    set_value(edited, "head roll", value, directing.value_edit());
    requests.edit(std::move(edited), "Tilt");
    directing.apply(requests);
  }
  DirectingRequests let_go;
  let_go.finished = true;
  directing.apply(let_go);
}

TEST(Directing, ADragIsOneStepAndTheNextOneAnother) {
  Directing directing;
  EXPECT_TRUE(directing.view().undo_name.empty());
  drag(directing, {1, 2, 3});
  drag(directing, {4, 5});
  EXPECT_EQ(directing.view().undo_name, "Tilt");
  directing.undo();
  EXPECT_EQ(value_at(*directing.performance(), "head roll", 0), 3);
  directing.undo();
  EXPECT_EQ(*directing.performance(), Performance{});
  directing.undo();
  directing.redo();
  directing.redo();
  EXPECT_EQ(value_at(*directing.performance(), "head roll", 0), 5);
}

TEST(Directing, ChangesAreUnsavedUntilTheyAreSaved) {
  Directing directing;
  EXPECT_FALSE(directing.unsaved_since());
  drag(directing, {1});
  EXPECT_TRUE(directing.unsaved_since());
  directing.was_saved();
  directing.undo();
  EXPECT_TRUE(directing.unsaved_since());
}

TEST(Directing, ChosenKeysAreMovedCopiedEasedAndDeleted) {
  Directing directing = two_channels();
  directing.go_to(2);
  directing.select_here();
  EXPECT_EQ(directing.view().selected->size(), 2u);
  directing.move_selected(5);
  EXPECT_NE(find_key(*directing.performance(), {"head yaw", 2.2}), nullptr);
  EXPECT_NE(find_key(*directing.performance(), directing.view().selected->front()), nullptr);
  directing.copy_selected();
  directing.go_to(3);
  directing.paste();
  EXPECT_NE(find_key(*directing.performance(), {"action jawOpen", 3}), nullptr);
  EXPECT_EQ(directing.view().selected->size(), 2u);
  directing.next_easing();
  EXPECT_EQ(find_key(*directing.performance(), {"head yaw", 3})->easing, Easing::hold);
  directing.delete_selected();
  EXPECT_EQ(find_key(*directing.performance(), {"head yaw", 3}), nullptr);
  EXPECT_TRUE(directing.view().selected->empty());
  for (int i = 0; i < 4; ++i) directing.undo();
  EXPECT_NE(find_key(*directing.performance(), {"head yaw", 2}), nullptr);
  EXPECT_EQ(all_keys(*directing.performance()).size(), 4u);
}

TEST(Directing, UndoForgetsChosenKeysThatAreGone) {
  Directing directing = two_channels();
  directing.go_to(1);
  directing.add_keys();
  EXPECT_EQ(directing.view().selected->size(), 2u);
  directing.undo();
  EXPECT_TRUE(directing.view().selected->empty());
}

TEST(Directing, ThePlayheadKeepsToPicturesAndFindsKeys) {
  Directing directing = two_channels();
  directing.go_to(0.03);
  EXPECT_NEAR(directing.playhead_s(), 0.04, 1e-9);
  directing.step_frames(-3);
  EXPECT_EQ(directing.playhead_s(), 0);
  directing.go_to_key(1);
  EXPECT_NEAR(directing.playhead_s(), 2, 1e-9);
  directing.go_to_key(1);
  EXPECT_NEAR(directing.playhead_s(), 3.96, 1e-9);  // the last picture
  directing.go_to_key(-1);
  EXPECT_NEAR(directing.playhead_s(), 2, 1e-9);
}

TEST(Directing, PlayingFollowsTheClockAndRepeats) {
  Directing directing = two_channels();
  const auto start = Directing::Clock::now();
  directing.toggle_playing(start);
  EXPECT_TRUE(directing.advance(start + milliseconds(1000)));
  EXPECT_NEAR(directing.playhead_s(), 1, 1e-9);
  directing.advance(start + milliseconds(5000));
  EXPECT_NEAR(directing.playhead_s(), 1, 1e-9);
  directing.toggle_looping();
  directing.advance(start + milliseconds(5000));
  EXPECT_FALSE(directing.playing());
  EXPECT_NEAR(directing.playhead_s(), 3.96, 1e-9);
  // From the end it starts anew.
  directing.toggle_playing(start);
  directing.advance(start + milliseconds(40));
  EXPECT_NEAR(directing.playhead_s(), 0.04, 1e-9);
}

TEST(Directing, APoseIsCopiedToAnotherMoment) {
  Directing directing = two_channels();
  directing.go_to(2);
  directing.copy_pose();
  directing.go_to(3.2);
  Performance edited = *directing.performance();
  set_key(edited, "head yaw", {3, 9});
  directing.edit(edited, "");
  directing.paste_pose();
  EXPECT_EQ(value_at(*directing.performance(), "head yaw", 3.2), 1);
  EXPECT_EQ(value_at(*directing.performance(), "head yaw", 3), 9);
}

}  // namespace
}  // namespace likeness::ui
