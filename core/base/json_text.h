// JSON from text and back. nlohmann's parser and serialiser, compiled here once: they cost a compiler two
// seconds in every file that calls them by itself.
#pragma once

#include <cstddef>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace likeness {

// What is handed on, compared or written again goes down as deep as the text does: no file of ours is deeper
// than ten, and a stack holds some thousands.
inline constexpr int kDeepestJson = 64;
inline constexpr std::size_t kLargestJson = std::size_t{1} << 31;  // bytes; an hour's track has a third of it

// Throws nlohmann::json::parse_error where the text is not JSON, too deep or too large.
nlohmann::json parse_json(std::string_view text);
// The same without exceptions: is_discarded() where it would throw.
nlohmann::json try_parse_json(std::string_view text);

// A number of a file. Throw nlohmann::json::exception where it is none, or not from low to high.
double number_in(const nlohmann::json& value, double low, double high);
int whole_number_in(const nlohmann::json& value, int low = std::numeric_limits<int>::min(),
                    int high = std::numeric_limits<int>::max());
// The same for each number of a list. nlohmann's own get<int>() makes 1 of 2^32 + 1.
std::vector<float> numbers_in(const nlohmann::json& list, double low = std::numeric_limits<float>::lowest(),
                              double high = std::numeric_limits<float>::max());
std::vector<int> whole_numbers_in(const nlohmann::json& list, int low = std::numeric_limits<int>::min(),
                                  int high = std::numeric_limits<int>::max());

// indent: spaces a level; -1: all in one line. What is not UTF-8 in a string becomes U+FFFD (paths:
// path_text.h).
std::string json_text(const nlohmann::json& value, int indent = -1);

}  // namespace likeness
