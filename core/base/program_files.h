// Files that lie beside the running program: a bundle brings what a system's packages would.
// Both are laid out as PREFIX/bin/PROGRAM, PREFIX/lib/likeness and PREFIX/share/likeness.
#pragma once

#include <filesystem>
#include <optional>

namespace likeness {

// The file of the program that runs, links followed; empty where the system does not tell.
std::filesystem::path program_file();

// The file `inside` the program's PREFIX, e.g. share/likeness/NAME; nothing where there is none.
std::optional<std::filesystem::path> bundled_file(const std::filesystem::path& inside,
                                                  const std::filesystem::path& program = program_file());

}  // namespace likeness
