// Backs large arrays with 2 MB pages where the system offers them: random look-ups in tables of a few
// megabytes otherwise miss the TLB (4 % of training time). Internal to core/field.
#pragma once

#include <cstddef>
#include <vector>

namespace likeness {

// To be called before the memory is first written. Never fails: without such pages nothing changes.
void advise_huge_pages(void* memory, std::size_t bytes);

inline std::vector<float> large_array(std::size_t count) {
  std::vector<float> array;
  array.reserve(count);
  advise_huge_pages(array.data(), count * sizeof(float));
  array.assign(count, 0.0f);
  return array;
}

}  // namespace likeness
