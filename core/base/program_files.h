// Files installed with the running program: a bundle holds what a system's packages would provide. Both are
// laid out as PREFIX/bin/PROGRAM, PREFIX/lib/likeness and PREFIX/share/likeness.
#pragma once

#include <filesystem>
#include <optional>

namespace likeness {

// The file of the running program, links followed; empty where the system does not say.
std::filesystem::path program_file();

// The file `inside` the program's PREFIX, e.g. share/likeness/NAME; nullopt if it does not exist.
std::optional<std::filesystem::path> bundled_file(const std::filesystem::path& inside,
                                                  const std::filesystem::path& program = program_file());

}  // namespace likeness
