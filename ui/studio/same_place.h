// Whether two paths lead to the same file or folder.
#pragma once

#include <filesystem>

namespace likeness::ui {

inline bool same_place(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code ignored;
  return a == b ||
         std::filesystem::weakly_canonical(a, ignored) == std::filesystem::weakly_canonical(b, ignored);
}

}  // namespace likeness::ui
