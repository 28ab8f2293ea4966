// Names in the order in which people number them: 1, 2, 10 rather than 1, 10, 2.
#pragma once

#include <string_view>

namespace likeness {

// Runs of digits compare as numbers, letters of ASCII whatever their case, all else by its bytes; names that
// differ only in case or in leading zeros compare by their bytes.
bool naturally_before(std::string_view a, std::string_view b);

}  // namespace likeness
