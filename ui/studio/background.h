// Reading files and other short work away from the window: work runs on one thread, in order; what it returns
// runs on the window's thread, at the next deliver().
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

namespace likeness::ui {

class Background {
 public:
  using Delivery = std::function<void()>;
  using Work = std::function<Delivery(std::stop_token)>;

  // wake: called from the thread when something can be delivered. broke: called on the window's thread when
  // work ended in an exception, with its words.
  Background(std::function<void(const std::string&)> broke, std::function<void()> wake);

  // key: earlier work of the same key that has not begun is dropped; empty: keep all.
  void run(std::string key, Work work);
  // Ready once all that waits now has run, or never will. For wait() alone: get() would throw in the second
  // case.
  std::shared_future<void> after_waiting();
  void deliver();  // on the window's thread
  // Ends what has a stop() and waits for its thread: work ends between two pictures or two fits, which is too
  // long for the window's thread.
  template <class J>
  void retire(std::unique_ptr<J> job) {
    if (!job) return;
    job->stop();
    run("", [ending = std::shared_ptr<J>(std::move(job))](std::stop_token) mutable {
      ending.reset();
      return Delivery();
    });
  }
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
