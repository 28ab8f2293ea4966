// SHA-256 (FIPS 180-4): the hash by which files that others made are pinned. For staleness: hash.h, which is
// faster.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace likeness {

std::string sha256(std::span<const std::byte> bytes);  // 64 hexadecimal digits, as sha256sum prints them

}  // namespace likeness
