// Bytes as text (RFC 4648, with padding), for files inside files.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace likeness {

std::string base64(std::span<const std::byte> bytes);

}  // namespace likeness
