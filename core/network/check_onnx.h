// Whether an ONNX file says nothing that OpenCV's importer divides by or takes memory for without a look.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace likeness {

// In words, what is wrong: lengths that go beyond the file, convolutions of no group, strides of nothing,
// weights larger than the file or in another one. Empty: nothing. It does not say that the network makes
// sense.
std::string onnx_fault(std::span<const std::byte> file);

}  // namespace likeness
