// A table of figures: what every measurement ends in. Printed in columns, as CSV or as JSON, of one type, so
// that a figure has the same name wherever it goes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/base/result.h"

namespace likeness {

struct TableColumn {
  std::string key;      // in files, with its unit: psnr_head_db
  std::string heading;  // printed over the column; empty: in files alone
  int digits = 2;       // behind the point, printed; files have all of them. Negative: -1 prints 1.6e-06
};

// A figure over several seeds.
struct Spread {
  double mean = 0, half_range = 0;
};
// Mean and half the range; nullopt of nothing, or where a value is missing or not finite.
std::optional<Spread> spread_of(std::span<const std::optional<double>> values);

// Words, a number, a number with its spread, a list of frames, or nothing: what could not be measured, and
// what is not finite.
class TableCell {
 public:
  using Value = std::variant<std::monostate, std::string, double, Spread, std::vector<int>>;

  TableCell() = default;
  TableCell(std::string words) : value_(std::move(words)) {}
  TableCell(const char* words) : value_(std::string(words)) {}
  TableCell(double number);
  TableCell(int number) : TableCell(double(number)) {}
  TableCell(std::uint64_t number) : TableCell(double(number)) {}
  TableCell(const std::optional<double>& number);
  TableCell(const std::optional<Spread>& spread);
  TableCell(std::vector<int> frames) : value_(std::move(frames)) {}
  TableCell(bool) = delete;  // say it in words

  const Value& value() const { return value_; }

 private:
  Value value_;
};

struct Table {
  std::string name;   // in files: cameras
  std::string title;  // printed above it; may be empty
  std::vector<TableColumn> columns;
  std::vector<std::vector<TableCell>> rows;  // a cell a column
  std::vector<std::string> notes;            // printed beneath it
  bool printed = true;                       // false: in files alone
};

// Columns as wide as what stands in them, words to the left and numbers to the right; "-" for nothing, and
// "1.50 ±0.20" for a spread. Several tables have an empty line between them.
std::string tables_text(std::span<const Table> tables);

// Comma separated, quoted where needed, nothing for nothing; a spread is two columns, KEY and KEY_half_range.
// Frames are parted by blanks. Several tables have an empty line between them.
std::string tables_csv(std::span<const Table> tables);

// {"cameras": [{"masks": "person", "found": 83}, ...], ...}: null for nothing, spreads as in CSV.
std::string tables_json(std::span<const Table> tables);

// NAME.csv for each table and tables.json, each whole or not at all.
Result<void> write_tables(const std::filesystem::path& folder, std::span<const Table> tables);

}  // namespace likeness
