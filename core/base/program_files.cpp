// By Linux's link to the running program: see program_files.h.
#include "core/base/program_files.h"

#include <system_error>

namespace likeness {

std::filesystem::path program_file() {
  std::error_code unknown;
  return std::filesystem::read_symlink("/proc/self/exe", unknown);
}

std::optional<std::filesystem::path> bundled_file(const std::filesystem::path& inside,
                                                  const std::filesystem::path& program) {
  if (program.empty()) return std::nullopt;
  std::filesystem::path file = program.parent_path().parent_path() / inside;
  std::error_code unknown;
  return std::filesystem::is_regular_file(file, unknown) ? std::optional(std::move(file)) : std::nullopt;
}

}  // namespace likeness
