// Content hashes that decide whether a stored result is stale (XXH3, 128 bit; not cryptographic).
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace likeness {

std::string hash_bytes(std::span<const std::byte> bytes);  // 32 hexadecimal digits
std::string hash_text(std::string_view text);
Result<std::string> hash_file(const std::filesystem::path& path);

}  // namespace likeness
