// How much memory a program may still take.
#pragma once

#include <cstdint>
#include <optional>

namespace likeness {

// Bytes free for new allocations without swapping: what the system has, and no more than the program's
// control group and its address-space limit allow. nullopt where the system does not say.
std::optional<std::uint64_t> available_memory();

}  // namespace likeness
