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

// indent: spaces a level; -1: all in one line. What is not UTF-8 in a string becomes U+FFFD (paths:
// path_text.h).
std::string json_text(const nlohmann::json& value, int indent = -1);

}  // namespace likeness
