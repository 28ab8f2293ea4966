// Tables as text, CSV and JSON: see table.h.
#include "core/base/table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/base/files.h"

namespace likeness {
namespace {

// Letters, not bytes: of UTF-8 all but those that continue one.
std::size_t width_of(std::string_view text) {
  return std::size_t(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string number_text(double number, int digits) {
  return digits < 0 ? fmt::format("{:.{}e}", number, -digits) : fmt::format("{:.{}f}", number, digits);
}

std::string printed(const TableCell& cell, int digits) {
  struct Visitor {
    int digits;
    std::string operator()(std::monostate) const { return "-"; }
    std::string operator()(const std::string& words) const { return words; }
    std::string operator()(double number) const { return number_text(number, digits); }
    std::string operator()(const Spread& s) const {
      return number_text(s.mean, digits) + " ±" + number_text(s.half_range, digits);
    }
    std::string operator()(const std::vector<int>& frames) const {
      return frames.empty() ? "none" : fmt::format("{}", fmt::join(frames, " "));
    }
  };
  return std::visit(Visitor{digits}, cell.value());
}

bool is_words(const TableCell& cell) { return std::holds_alternative<std::string>(cell.value()); }

std::string text_of(const Table& table) {
  struct Column {
    std::size_t at = 0, width = 0;
    bool words = false;
  };
  std::vector<Column> columns;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const TableColumn& column = table.columns[c];
    if (column.heading.empty()) continue;
    Column own{c, width_of(column.heading)};
    for (const auto& row : table.rows) {
      own.width = std::max(own.width, width_of(printed(row[c], column.digits)));
      own.words |= is_words(row[c]);
    }
    columns.push_back(own);
  }
  const auto line = [&](const auto& words_of) {
    std::string text;
    for (const Column& column : columns) {
      const std::string words = words_of(column.at);
      const std::string blanks(column.width - width_of(words), ' ');
      text += (&column == columns.data() ? "" : "  ") + (column.words ? words + blanks : blanks + words);
    }
    return text.erase(text.find_last_not_of(' ') + 1) + "\n";
  };
  std::string text = table.title.empty() ? "" : table.title + "\n";
  text += line([&](std::size_t c) { return table.columns[c].heading; });
  for (const auto& row : table.rows)
    text += line([&](std::size_t c) { return printed(row[c], table.columns[c].digits); });
  for (const std::string& note : table.notes) text += note + "\n";
  return text;
}

// Whether a column stands in two: some row has a spread in it.
bool is_spread(const Table& table, std::size_t column) {
  return std::ranges::any_of(
      table.rows, [&](const auto& row) { return std::holds_alternative<Spread>(row[column].value()); });
}

std::string quoted(const std::string& words) {
  if (words.find_first_of(",\"\n\r") == std::string::npos) return words;
  std::string out = "\"";
  for (const char c : words) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string csv_of(const TableCell& cell, bool two) {
  struct Visitor {
    bool two;
    std::string one(const std::string& text) const { return two ? text + "," : text; }
    std::string operator()(std::monostate) const { return one(""); }
    std::string operator()(const std::string& words) const { return one(quoted(words)); }
    std::string operator()(double number) const { return one(fmt::format("{}", number)); }
    std::string operator()(const Spread& s) const { return fmt::format("{},{}", s.mean, s.half_range); }
    std::string operator()(const std::vector<int>& frames) const {
      return one(fmt::format("{}", fmt::join(frames, " ")));
    }
  };
  return std::visit(Visitor{two}, cell.value());
}

std::string csv_of(const Table& table) {
  std::string csv;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const std::string key = quoted(table.columns[c].key);
    csv += (c > 0 ? "," : "") + key;
    if (is_spread(table, c)) csv += "," + key + "_half_range";
  }
  csv += "\n";
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size(); ++c)
      csv += (c > 0 ? "," : "") + csv_of(row[c], is_spread(table, c));
    csv += "\n";
  }
  return csv;
}

std::string quoted_json(std::string_view words) {
  std::string out = "\"";
  for (const char c : words) {
    if (c == '"' || c == '\\')
      out += std::string("\\") + c;
    else if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", int(c));
    else
      out += c;
  }
  return out + "\"";
}

std::string json_of(const std::string& key, const TableCell& cell) {
  struct Visitor {
    const std::string& key;
    std::string one(const std::string& value) const { return quoted_json(key) + ": " + value; }
    std::string operator()(std::monostate) const { return one("null"); }
    std::string operator()(const std::string& words) const { return one(quoted_json(words)); }
    std::string operator()(double number) const { return one(fmt::format("{}", number)); }
    std::string operator()(const Spread& s) const {
      return fmt::format("{}, {}: {}", one(fmt::format("{}", s.mean)), quoted_json(key + "_half_range"),
                         s.half_range);
    }
    std::string operator()(const std::vector<int>& frames) const {
      return one(fmt::format("[{}]", fmt::join(frames, ", ")));
    }
  };
  return std::visit(Visitor{key}, cell.value());
}

std::string json_of(const Table& table) {
  std::string json = quoted_json(table.name) + ": [";
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    json += r > 0 ? ",\n    {" : "\n    {";
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      json += (c > 0 ? ", " : "") + json_of(table.columns[c].key, table.rows[r][c]);
    json += "}";
  }
  return json + (table.rows.empty() ? "]" : "\n  ]");
}

}  // namespace

std::optional<Spread> spread_of(std::span<const std::optional<double>> values) {
  if (values.empty()) return std::nullopt;
  double sum = 0, low = INFINITY, high = -INFINITY;
  for (const std::optional<double>& value : values) {
    if (!value || !std::isfinite(*value)) return std::nullopt;
    sum += *value, low = std::min(low, *value), high = std::max(high, *value);
  }
  return Spread{sum / double(values.size()), (high - low) / 2};
}

TableCell::TableCell(double number) {
  if (std::isfinite(number)) value_ = number;
}
TableCell::TableCell(const std::optional<double>& number) {
  if (number && std::isfinite(*number)) value_ = *number;
}
TableCell::TableCell(const std::optional<Spread>& spread) {
  if (spread) value_ = *spread;
}

std::string tables_text(std::span<const Table> tables) {
  std::string text;
  for (const Table& table : tables)
    if (table.printed) text += (text.empty() ? "" : "\n") + text_of(table);
  return text;
}

std::string tables_csv(std::span<const Table> tables) {
  std::string csv;
  for (const Table& table : tables) csv += (csv.empty() ? "" : "\n") + csv_of(table);
  return csv;
}

std::string tables_json(std::span<const Table> tables) {
  std::string json = "{";
  for (const Table& table : tables) json += (json.size() > 1 ? ",\n  " : "\n  ") + json_of(table);
  return json + "\n}\n";
}

Result<void> write_tables(const std::filesystem::path& folder, std::span<const Table> tables) {
  for (const Table& table : tables)
    if (auto written = write_text(folder / (table.name + ".csv"), csv_of(table)); !written) return written;
  return write_text(folder / "tables.json", tables_json(tables));
}

}  // namespace likeness
