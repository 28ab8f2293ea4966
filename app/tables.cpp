// See tables.h.
#include "app/tables.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/json_text.h"

namespace likeness::app {

void add_table_options(CLI::App& verb, TableOptions& options) {
  verb.add_flag("--csv", options.csv, "Print the tables as CSV on stdout")
      ->excludes(verb.get_option("--json"));
  if (verb.get_option_no_throw("--out") == nullptr)
    verb.add_option("--out", options.out, "Folder for the tables: TABLE.csv each, and tables.json");
}

void add_tables_option(CLI::App& verb, TableOptions& options, const std::vector<std::string>& known,
                       const std::string& about) {
  verb.add_option("--tables", options.tables, fmt::format("Of: {}; {}", fmt::join(known, ", "), about))
      ->check(CLI::IsMember(known));
}

bool is_asked(const TableOptions& options, const std::string& table) {
  return std::ranges::find(options.tables, table) != options.tables.end();
}

CommonOptions quiet_if_csv(CommonOptions common, const TableOptions& options) {
  common.json |= options.csv;
  return common;
}

int report_tables(const CommonOptions& common, const TableOptions& options, std::span<const Table> tables,
                  const nlohmann::json* json) {
  if (!options.out.empty())
    if (const auto written = write_tables(options.out, tables); !written)
      return report_failure(written.error());
  if (options.csv)
    fmt::print("{}", tables_csv(tables));
  else if (common.json)
    print_json(json != nullptr ? *json : parse_json(tables_json(tables)));
  else
    fmt::print("{}", tables_text(tables));
  return kExitDone;
}

}  // namespace likeness::app
