// Claims about background work: results come to the window's thread, in order, and newer asks replace older.
#include "ui/studio/background.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace likeness::ui {
namespace {

TEST(Background, DeliversOnTheCallersThreadInOrder) {
  Background background([](const std::string&) {}, [] {});
  std::vector<int> delivered;
  const auto here = std::this_thread::get_id();
  for (int i = 0; i < 3; ++i)
    background.run("", [&, i](std::stop_token) -> Background::Delivery {
      EXPECT_NE(std::this_thread::get_id(), here);
      return [&, i] {
        EXPECT_EQ(std::this_thread::get_id(), here);
        delivered.push_back(i);
      };
    });
  while (background.busy()) background.deliver();
  EXPECT_EQ(delivered, (std::vector{0, 1, 2}));
}

TEST(Background, ANewerRequestOfTheSameKindReplacesTheWaitingOne) {
  Background background([](const std::string&) {}, [] {});
  std::atomic<bool> go = false;
  std::vector<int> delivered;
  const auto ask = [&](std::string key, int value) {
    background.run(std::move(key), [&, value](std::stop_token) -> Background::Delivery {
      while (!go) std::this_thread::yield();
      return [&, value] { delivered.push_back(value); };
    });
  };
  ask("", 0);  // keeps the thread, so that the others wait
  for (int i = 1; i <= 5; ++i) ask("frame", i);
  ask("other", 6);
  go = true;
  while (background.busy()) background.deliver();
  EXPECT_EQ(delivered.back(), 6);
  EXPECT_LE(delivered.size(), 3u);
  EXPECT_EQ(delivered[delivered.size() - 2], 5);
}

TEST(Background, ItsEndCanBeWaitedForElsewhere) {
  std::shared_future<void> never;
  {
    Background background([](const std::string&) {}, [] {});
    std::atomic<bool> go = false, written = false;
    background.run("stroke", [&](std::stop_token) -> Background::Delivery {
      while (!go) std::this_thread::yield();
      written = true;
      return {};
    });
    const auto ready = background.after_waiting();
    EXPECT_EQ(ready.wait_for(std::chrono::milliseconds(20)), std::future_status::timeout);
    go = true;
    ready.wait();
    EXPECT_TRUE(written);
    background.run("", [](std::stop_token stop) -> Background::Delivery {
      while (!stop.stop_requested()) std::this_thread::yield();
      return {};
    });
    never = background.after_waiting();
  }
  never.wait();  // nobody waits for work that will not be done
}

TEST(Background, WorkThatThrowsIsReportedAndTheNextIsDone) {
  std::string broke;
  bool done = false;
  Background background([&](const std::string& what) { broke = what; }, [] {});
  background.run("", [](std::stop_token) -> Background::Delivery { throw std::runtime_error("no memory"); });
  background.run("", [&](std::stop_token) { return Background::Delivery([&] { done = true; }); });
  while (background.busy()) {
    background.deliver();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(broke, "no memory");
  EXPECT_TRUE(done);
}

}  // namespace
}  // namespace likeness::ui
