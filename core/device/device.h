// A compute device as the rest of the program sees it: memory, copies and kernels that return a Result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/result.h"
#include "core/device/device_api.h"
#include "core/device/kernel_ids.h"

namespace likeness {

// What happened and what to do about it. `doing`: the work in progress, e.g. "training".
Error device_error(DeviceStatus status, const DeviceFacts& facts, const std::string& said,
                   const std::string& doing);

class Device {
 public:
  static Result<std::shared_ptr<Device>> open(const DeviceApi& api);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceFacts& facts() const { return facts_; }
  Result<void*> allocate(std::size_t bytes);
  void release(void* memory);
  Result<void> copy_in(void* to, const void* from, std::size_t bytes);
  Result<void> copy_out(void* to, const void* from, std::size_t bytes);
  Result<void> clear(void* memory, std::size_t bytes);
  template <class Args>
  Result<void> launch(Kernel kernel, const Args& args, std::size_t items) {
    static_assert(std::is_trivially_copyable_v<Args>);
    return items == 0 ? Result<void>() : launch_bytes(kernel, &args, sizeof(args), items);
  }
  Result<void> record();
  Result<void*> end_record();
  Result<void> replay(void* recording);
  void forget(void* recording);
  Result<void> wait();
  Result<void> mark(int number);
  Result<double> between(int first, int second);  // s

 private:
  Device(const DeviceApi& api, void* context, const DeviceFacts& facts)
      : api_(api), context_(context), facts_(facts) {}
  Result<void> launch_bytes(Kernel kernel, const void* args, std::size_t bytes, std::size_t items);
  Result<void> checked(DeviceStatus status);

  const DeviceApi& api_;
  void* context_;
  DeviceFacts facts_;
};

// An array in the device's memory.
template <class T>
class DeviceArray {
 public:
  DeviceArray() = default;
  static Result<DeviceArray> make(std::shared_ptr<Device> device, std::size_t count) {
    DeviceArray array;
    if (count > 0) {
      auto memory = device->allocate(count * sizeof(T));
      if (!memory) return memory.error();
      array.data_ = static_cast<T*>(*memory);
    }
    array.count_ = count;
    array.device_ = std::move(device);
    return array;
  }
  ~DeviceArray() { reset(); }
  DeviceArray(DeviceArray&& other) noexcept { *this = std::move(other); }
  DeviceArray& operator=(DeviceArray&& other) noexcept {
    if (this == &other) return *this;
    reset();
    device_ = std::move(other.device_), data_ = other.data_, count_ = other.count_;
    other.data_ = nullptr, other.count_ = 0;
    return *this;
  }
  T* data() const { return data_; }
  std::size_t size() const { return count_; }

 private:
  void reset() {
    if (data_) device_->release(data_);
    data_ = nullptr;
  }
  std::shared_ptr<Device> device_;
  T* data_ = nullptr;
  std::size_t count_ = 0;
};

}  // namespace likeness
