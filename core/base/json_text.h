// JSON from text and back. nlohmann's parser and serialiser, compiled here once: they cost a compiler two
// seconds in every file that calls them by itself.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace likeness {

// Throws nlohmann::json::parse_error where the text is not JSON.
nlohmann::json parse_json(std::string_view text);
// The same without exceptions: is_discarded() where the text is not JSON.
nlohmann::json try_parse_json(std::string_view text);

// indent: spaces a level; -1: all in one line. Throws nlohmann::json::type_error where a string is not UTF-8.
std::string json_text(const nlohmann::json& value, int indent = -1);
// For strings from outside, such as file names: what is not UTF-8 becomes U+FFFD.
std::string json_text_replacing(const nlohmann::json& value, int indent = -1);

}  // namespace likeness
