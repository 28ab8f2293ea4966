// See background.h.
#include "ui/studio/background.h"

#include <exception>
#include <memory>
#include <utility>

#include "core/base/fault_words.h"

namespace likeness::ui {

Background::Background(std::function<void(const std::string&)> broke, std::function<void()> wake)
    : broke_(std::move(broke)),
      wake_(std::move(wake)),
      thread_([this](std::stop_token stop) { loop(stop); }) {}

void Background::run(std::string key, Work work) {
  {
    const std::lock_guard lock(mutex_);
    if (!key.empty()) std::erase_if(queue_, [&](const Item& item) { return item.key == key; });
    queue_.push_back({std::move(key), std::move(work)});
  }
  changed_.notify_one();
}

std::shared_future<void> Background::after_waiting() {
  auto reached = std::make_shared<std::promise<void>>();
  std::shared_future<void> ready = reached->get_future().share();
  run("", [reached = std::move(reached)](std::stop_token) -> Delivery {
    reached->set_value();
    return {};
  });
  return ready;
}

void Background::deliver() {
  std::vector<Delivery> ready;
  {
    const std::lock_guard lock(mutex_);
    ready = std::exchange(done_, {});
  }
  for (const Delivery& delivery : ready)
    if (delivery) delivery();
}

bool Background::busy() const {
  const std::lock_guard lock(mutex_);
  return working_ || !queue_.empty() || !done_.empty();
}

void Background::loop(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !queue_.empty(); })) {
    Item item = std::move(queue_.front());
    queue_.pop_front();
    working_ = true;
    lock.unlock();
    Delivery delivery;
    try {
      delivery = item.work(stop);
    } catch (const std::exception& e) {
      delivery = [this, what = fault_words(e)] { broke_(what); };
    }
    item.work = nullptr;  // what it holds may be large, so free it before locking
    lock.lock();
    working_ = false;
    done_.push_back(std::move(delivery));
    wake_();
  }
}

}  // namespace likeness::ui
