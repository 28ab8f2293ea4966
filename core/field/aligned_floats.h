// Memory for the kernels. Internal to core/field.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#include "core/field/huge_pages.h"

namespace likeness {

// Floats on a 64-byte boundary, uninitialised; keeps its memory when less is requested, and grows by at least
// an eighth, since batches of training differ a little and fresh memory is slow to touch.
class AlignedFloats {
 public:
  float* reserve(std::size_t count) {
    if (count > capacity_) {
      count = std::max(count, capacity_ + capacity_ / 8);
      data_.reset();
      data_.reset(static_cast<float*>(::operator new (count * sizeof(float), std::align_val_t{64})));
      advise_huge_pages(data_.get(), count * sizeof(float));
      capacity_ = count;
    }
    return data_.get();
  }
  float* data() const { return data_.get(); }

 private:
  struct Free {
    void operator()(float* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::unique_ptr<float, Free> data_;
  std::size_t capacity_ = 0;
};

}  // namespace likeness
