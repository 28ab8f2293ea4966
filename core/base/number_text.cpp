// See number_text.h.
#include "core/base/number_text.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

namespace likeness {

namespace {

// Of a number that no double can hold: whether it is too large rather than too small.
bool is_large(std::string_view number) {
  const std::size_t e = number.find_first_of("eE");
  const std::string_view digits = number.substr(0, e);
  const std::size_t first = digits.find_first_of("123456789");
  if (first == std::string_view::npos) return false;
  constexpr double kBeyondAll = 1e9;
  double exponent = 0;
  if (e != std::string_view::npos) {
    std::string_view text = number.substr(e + 1);
    if (text.starts_with('+')) text.remove_prefix(1);
    int whole = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), whole);
    exponent = read.ec == std::errc() ? whole : text.starts_with('-') ? -kBeyondAll : kBeyondAll;
  }
  const double point = double(std::min(digits.find('.'), digits.size()));
  return point - double(first) + exponent > 0;
}

}  // namespace

bool take_number(std::string_view& text, double& value) {
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() && failure != std::errc::result_out_of_range) return false;
  const std::string_view number = text.substr(0, std::size_t(end - text.data()));
  if (failure == std::errc::result_out_of_range) {
    value = is_large(number) ? std::numeric_limits<double>::infinity() : 0;
    if (number.starts_with('-')) value = -value;
  }
  text.remove_prefix(number.size());
  return true;
}

}  // namespace likeness
