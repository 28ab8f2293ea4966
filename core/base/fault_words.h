// What an exception says, in words for whoever uses the program.
#pragma once

#include <exception>
#include <new>
#include <string>
#include <system_error>

namespace likeness {

// A thread's stack is memory, too.
inline bool lacks_memory(const std::exception& fault) {
  const auto* refused = dynamic_cast<const std::system_error*>(&fault);
  return dynamic_cast<const std::bad_alloc*>(&fault) != nullptr ||
         (refused != nullptr && refused->code() == std::errc::resource_unavailable_try_again);
}

inline std::string fault_words(const std::exception& fault) {
  return lacks_memory(fault) ? "there is not enough memory" : fault.what();
}

}  // namespace likeness
