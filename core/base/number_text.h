// Decimal numbers in text files, whatever the locale.
#pragma once

#include <string_view>

namespace likeness {

// Takes a number from the beginning of `text`, as std::from_chars does. What is too small for a double is 0,
// what is too large infinite. False: there is none, and `text` stays.
bool take_number(std::string_view& text, double& value);

}  // namespace likeness
