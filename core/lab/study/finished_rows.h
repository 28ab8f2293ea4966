// What a long study has finished, kept row by row, so that a second call goes on where the first stopped.
// Internal to core/lab/study.
#pragma once

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/result.h"

namespace likeness {

// content: hash of all that the row depends on, but the program.
Result<void> write_finished(const std::filesystem::path& path, const std::string& content,
                            nlohmann::json row);
// nullopt where there is none, where it cannot be read, or where it was made from other inputs.
std::optional<nlohmann::json> read_finished(const std::filesystem::path& path, const std::string& content);

// Numbers that need not be there: JSON has no NaN, so what is not a number is null.
nlohmann::json finite_or_null(const std::optional<double>& value);
std::optional<double> optional_number(const nlohmann::json& value);
double number_or_nan(const nlohmann::json& value);

}  // namespace likeness
