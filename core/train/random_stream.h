// A counter-based random stream: the same numbers for (seed, step, index) regardless of threads and of where
// a run was interrupted, on processor and device. Plain C++17.
#pragma once

#include <cstdint>

#include "core/base/host_device.h"

namespace likeness {

class RandomStream {
 public:
  LIKENESS_HOST_DEVICE RandomStream(std::uint64_t seed, std::uint64_t step, std::uint64_t index)
      : state_(mixed(mixed(mixed(seed + 0x51ed27) + step) + index)) {}

  LIKENESS_HOST_DEVICE std::uint64_t bits() { return mixed(state_ += kStride); }
  LIKENESS_HOST_DEVICE float uniform() { return float(bits() >> 40) * 0x1p-24f; }  // [0, 1)
  LIKENESS_HOST_DEVICE std::uint32_t below(std::uint32_t n) {                      // [0, n)
    return std::uint32_t((bits() >> 32) * n >> 32);
  }
  // Skips the next `count` numbers in one step.
  LIKENESS_HOST_DEVICE void skip(std::uint64_t count) { state_ += count * kStride; }

 private:
  static constexpr std::uint64_t kStride = 0x9e3779b97f4a7c15ull;
  LIKENESS_HOST_DEVICE static std::uint64_t mixed(std::uint64_t v) {  // finaliser of splitmix64
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
    return v ^ (v >> 31);
  }
  std::uint64_t state_;
};

}  // namespace likeness
