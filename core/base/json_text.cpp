#include "core/base/json_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include <fmt/format.h>

namespace likeness {

namespace {

// How deep arrays and objects lie in each other, of text that need not be JSON.
int depth_of(std::string_view text) {
  int depth = 0, deepest = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') quoted = !quoted;
    if (quoted && c == '\\') ++i;
    if (quoted) continue;
    if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
    if (c == ']' || c == '}') --depth;
  }
  return deepest;
}

// What keeps a text from being parsed; empty: nothing does.
std::string too_much(std::string_view text) {
  if (text.size() > kLargestJson)
    return fmt::format("it has {} MB, and at most {} are read", text.size() >> 20, kLargestJson >> 20);
  if (depth_of(text) > kDeepestJson) return fmt::format("it is nested deeper than {} levels", kDeepestJson);
  return {};
}

}  // namespace

nlohmann::json parse_json(std::string_view text) {
  if (const std::string wrong = too_much(text); !wrong.empty())
    throw nlohmann::json::parse_error::create(101, 0, wrong, nullptr);
  return nlohmann::json::parse(text);
}

nlohmann::json try_parse_json(std::string_view text) {
  if (!too_much(text).empty()) return nlohmann::json::value_t::discarded;
  return nlohmann::json::parse(text, nullptr, false);
}

double number_in(const nlohmann::json& value, double low, double high) {
  const double number = value.get<double>();
  if (!(number >= low && number <= high))
    throw nlohmann::json::out_of_range::create(
        401, fmt::format("the number {} is not from {} to {}", number, low, high), nullptr);
  return number;
}

int whole_number_in(const nlohmann::json& value, int low, int high) {
  return int(number_in(value, double(low), double(high)));
}

std::vector<float> numbers_in(const nlohmann::json& list, double low, double high) {
  std::vector<float> numbers;
  numbers.reserve(list.get_ref<const nlohmann::json::array_t&>().size());
  for (const nlohmann::json& value : list) numbers.push_back(float(number_in(value, low, high)));
  return numbers;
}

std::vector<int> whole_numbers_in(const nlohmann::json& list, int low, int high) {
  std::vector<int> numbers;
  numbers.reserve(list.get_ref<const nlohmann::json::array_t&>().size());
  for (const nlohmann::json& value : list) numbers.push_back(whole_number_in(value, low, high));
  return numbers;
}

std::string json_text(const nlohmann::json& value, int indent) {
  return value.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace likeness
