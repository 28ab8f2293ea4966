// Reading files and other short work away from the window: work runs on one thread, in order; what it returns
// runs on the window's thread, at the next deliver().
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

namespace likeness::ui {

class Background {
 public:
  using Delivery = std::function<void()>;
  using Work = std::function<Delivery(std::stop_token)>;

  // wake: called from the thread when something can be delivered. broke: told on the window's thread of work
  // that ended in an exception, with its words.
  Background(std::function<void(const std::string&)> broke, std::function<void()> wake);

  // key: earlier work of the same key that has not begun is dropped; empty: keep all.
  void run(std::string key, Work work);
  // Ready once all that waits now has run, or never will: to be waited for, not to be asked.
  std::shared_future<void> after_waiting();
  void deliver();  // on the window's thread
  bool busy() const;

 private:
  struct Item {
    std::string key;
    Work work;
  };
  void loop(std::stop_token stop);

  std::function<void(const std::string&)> broke_;
  std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Item> queue_;
  std::vector<Delivery> done_;
  bool working_ = false;
  std::jthread thread_;  // last: stops before the rest goes
};

}  // namespace likeness::ui
