// Rows of studies on disk.
#include "core/lab/study/finished_rows.h"

#include <cmath>

#include "core/base/files.h"
#include "core/base/json_text.h"

namespace likeness {

Result<void> write_finished(const std::filesystem::path& path, const std::string& content,
                            nlohmann::json row) {
  row["inputs"] = content;
  return write_text(path, json_text(row, 1) + "\n");
}

std::optional<nlohmann::json> read_finished(const std::filesystem::path& path, const std::string& content) {
  const auto text = read_text(path);
  if (!text) return std::nullopt;
  nlohmann::json row = try_parse_json(*text);
  if (!row.is_object() || !row.contains("inputs") || row["inputs"] != content) return std::nullopt;
  return row;
}

nlohmann::json finite_or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

std::optional<double> optional_number(const nlohmann::json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}

double number_or_nan(const nlohmann::json& value) {
  return optional_number(value).value_or(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace likeness
