// What a program's control groups leave it of memory, of version 1 and 2.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace likeness {

// The least that is left along the program's own path of groups, bytes: a group is held by its parents'
// limits, too. nullopt: none of them limits it. root: where /proc and the groups lie.
std::optional<std::uint64_t> group_memory_left(const std::filesystem::path& root = "/");

}  // namespace likeness
