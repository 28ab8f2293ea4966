// Comparing names: see natural_order.h.
#include "core/base/natural_order.h"

#include <compare>
#include <cstddef>

namespace likeness {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

unsigned char folded(char c) { return static_cast<unsigned char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); }

// The run of digits at the front without its leading zeros; `text` goes on behind it.
std::string_view take_number(std::string_view& text) {
  std::size_t zeros = 0, end = 0;
  while (zeros < text.size() && text[zeros] == '0') ++zeros;
  for (end = zeros; end < text.size() && is_digit(text[end]);) ++end;
  const std::string_view digits = text.substr(zeros, end - zeros);
  text.remove_prefix(end);
  return digits;
}

}  // namespace

bool naturally_before(std::string_view a, std::string_view b) {
  std::string_view x = a, y = b;
  while (!x.empty() && !y.empty()) {
    if (is_digit(x.front()) && is_digit(y.front())) {
      const std::string_view m = take_number(x), n = take_number(y);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
      continue;
    }
    const auto c = folded(x.front()), d = folded(y.front());
    if (c != d) return c < d;
    x.remove_prefix(1), y.remove_prefix(1);
  }
  if (x.empty() != y.empty()) return x.empty();
  return a < b;
}

}  // namespace likeness
