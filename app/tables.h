// What the verbs that measure have in common: their tables printed, as JSON or CSV, or written to a folder.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "app/terminal.h"
#include "core/base/table.h"

namespace likeness::app {

struct TableOptions {
  bool csv = false;                 // on standard output, no progress line
  std::filesystem::path out;        // folder for TABLE.csv and tables.json; empty: none
  std::vector<std::string> tables;  // asked for, by name; empty: the verb's own choice
};

// --json (of the common options) or --csv, and --out unless the verb has one of its own.
void add_table_options(CLI::App& verb, TableOptions& options);
// --tables, of these.
void add_tables_option(CLI::App& verb, TableOptions& options, const std::vector<std::string>& known,
                       const std::string& about);
bool is_asked(const TableOptions& options, const std::string& table);

// A progress line only where nothing but the result may be printed.
CommonOptions quiet_if_csv(CommonOptions common, const TableOptions& options);

// Prints and writes them; the exit code. json: instead of the tables' own, where a verb has more to say.
int report_tables(const CommonOptions& common, const TableOptions& options, std::span<const Table> tables,
                  const nlohmann::json* json = nullptr);

}  // namespace likeness::app
