// Claims about the queue of exports: one after the other, each ended by itself, none keeping the next
// waiting.
#include "ui/studio/export_queue.h"

#include <gtest/gtest.h>

#include <atomic>

namespace likeness::ui {
namespace {

Result<std::string> writes(const Progress&, std::stop_token) { return std::string("written"); }

Result<std::string> fails(const Progress&, std::stop_token) {
  return Error{ErrorCode::no_space, "The disk is full.", "Free some.", ""};
}

Result<std::string> lasts(const Progress&, std::stop_token stop) {
  while (!stop.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return cancelled_error();
}

void run_out(ExportQueue& queue) {
  while (queue.is_working()) {
    queue.tick();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  queue.tick();  // takes in how the last one ended
}

JobState state(const ExportQueue& queue, int number) {
  for (const ExportItem& item : queue.items())
    if (item.number == number) return item.status.state;
  ADD_FAILURE() << "no item " << number;
  return JobState::none;
}

TEST(ExportQueue, AFailureDoesNotKeepTheNextFromItsTurn) {
  ExportQueue queue([] {});
  queue.add("a.png", writes);
  queue.add("b.mp4", fails);
  queue.add("c.glb", writes);
  run_out(queue);
  EXPECT_EQ(state(queue, 1), JobState::done);
  EXPECT_EQ(state(queue, 2), JobState::failed);
  EXPECT_EQ(state(queue, 3), JobState::done);
  EXPECT_EQ(queue.last_written(), "c.glb");
  EXPECT_EQ(queue.items()[1].status.error->fix, "Free some.");
}

TEST(ExportQueue, OneIsStoppedAndTheOthersGoOn) {
  ExportQueue queue([] {});
  queue.add("a.mp4", lasts);
  queue.add("b.mp4", writes);
  queue.add("c.mp4", writes);
  EXPECT_TRUE(queue.holds("c.mp4"));
  EXPECT_EQ(state(queue, 1), JobState::running);
  EXPECT_EQ(state(queue, 2), JobState::none);
  queue.stop(2);  // before its turn
  queue.stop(1);
  run_out(queue);
  EXPECT_EQ(state(queue, 1), JobState::stopped);
  EXPECT_EQ(state(queue, 2), JobState::stopped);
  EXPECT_EQ(state(queue, 3), JobState::done);
}

TEST(ExportQueue, AFailedOneIsTriedAgainAndAWrittenOneIsNot) {
  std::atomic<bool> full = true;
  ExportQueue queue([] {});
  queue.add("a.mp4", [&](const Progress& p, std::stop_token s) { return full ? fails(p, s) : writes(p, s); });
  queue.add("b.mp4", writes);
  run_out(queue);
  full = false;
  queue.retry(1);
  queue.retry(2);
  EXPECT_TRUE(queue.is_working());
  run_out(queue);
  EXPECT_EQ(state(queue, 1), JobState::done);
  EXPECT_EQ(queue.items().back().number, 1);
  queue.forget(1);
  EXPECT_EQ(queue.items().size(), 1u);
}

TEST(ExportQueue, AFailureIsReportedUntilItsItemIsRemoved) {
  ExportQueue queue([] {});
  queue.add("a.png", writes);
  queue.add("b.mp4", fails);
  run_out(queue);
  queue.forget(1);
  EXPECT_EQ(queue.status().state, JobState::failed);
  queue.forget(2);
  EXPECT_EQ(queue.status().state, JobState::none);
  EXPECT_FALSE(queue.status().error.has_value());
}

TEST(ExportQueue, NothingIsLeftOfAClearedOne) {
  ExportQueue queue([] {});
  queue.add("a.mp4", lasts);
  queue.add("b.mp4", writes);
  const auto running = queue.clear();
  ASSERT_NE(running, nullptr);
  EXPECT_TRUE(queue.items().empty());
  queue.tick();
  EXPECT_FALSE(queue.is_working());
}

}  // namespace
}  // namespace likeness::ui
