// A text as a reader of files gets it.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace likeness {

inline std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace likeness
