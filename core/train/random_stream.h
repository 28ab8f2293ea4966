// A counter-based random stream: the same numbers for (seed, step, index) whatever the threads do and
// wherever a run was interrupted.
#pragma once

#include <cstdint>

namespace likeness {

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t step, std::uint64_t index)
      : state_(mixed(mixed(mixed(seed + 0x51ed27) + step) + index)) {}

  std::uint64_t bits() { return mixed(state_ += 0x9e3779b97f4a7c15ull); }
  float uniform() { return float(bits() >> 40) * 0x1p-24f; }                                // [0, 1)
  std::uint32_t below(std::uint32_t n) { return std::uint32_t((bits() >> 32) * n >> 32); }  // [0, n)

 private:
  static std::uint64_t mixed(std::uint64_t v) {  // finaliser of splitmix64
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
    return v ^ (v >> 31);
  }
  std::uint64_t state_;
};

}  // namespace likeness
