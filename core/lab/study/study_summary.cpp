// results.json, read back: see study_summary.h.
#include "core/lab/study/study_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/lab/study/finished_rows.h"

namespace likeness {
namespace {

struct Mean {
  double sum = 0, low = INFINITY, high = -INFINITY;
  int count = 0;
  void add(const std::optional<double>& value) {
    if (value && std::isfinite(*value))
      sum += *value, low = std::min(low, *value), high = std::max(high, *value), ++count;
  }
  std::optional<double> value() const { return count > 0 ? std::optional(sum / count) : std::nullopt; }
};

SummaryRow row_of(const nlohmann::json& j) {
  SummaryRow row;
  j.at("name").get_to(row.name), j.at("about").get_to(row.about);
  row.failed = j.value("failed", "");
  Mean full, head, face, train, speed;
  for (const nlohmann::json& score : j.at("scores")) {
    ++row.seeds;
    const auto number = [&](const char* name) {
      return score.contains(name) ? optional_number(score.at(name)) : std::nullopt;
    };
    full.add(number("psnr_db")), head.add(number("psnr_head_db")), face.add(number("psnr_face_db"));
    train.add(number("train_seconds")), speed.add(number("frames_per_second"));
  }
  row.psnr_db = full.value(), row.head_db = head.value(), row.face_db = face.value();
  if (head.count > 1) row.head_spread_db = (head.high - head.low) / 2;
  row.train_seconds = train.value().value_or(0), row.frames_per_second = speed.value().value_or(0);
  return row;
}

}  // namespace

Result<StudySummary> read_study_summary(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "results.json";
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    return Error{ErrorCode::not_found, fmt::format("There is no finished comparison in {}.", folder.string()),
                 "Start one, or continue the one that was stopped.", folder.string()};
  const auto text = read_text(path);
  if (!text) return text.error();
  try {
    const nlohmann::json j = parse_json(*text);
    StudySummary summary;
    if (j.at("format") != "likeness-model-study") throw std::runtime_error("another format");
    j.at("clip").get_to(summary.clip), j.at("size").get_to(summary.size),
        j.at("seconds").get_to(summary.seconds);
    summary.frames = int(j.at("frames").size());
    summary.page = folder / "report.html";
    std::map<std::string, SummaryRow> rows;
    for (const nlohmann::json& row : j.at("rows")) rows[row.at("name").get<std::string>()] = row_of(row);
    for (const nlohmann::json& t : j.at("tables")) {
      SummaryTable& table = summary.tables.emplace_back();
      t.at("name").get_to(table.name), t.at("title").get_to(table.title);
      for (const nlohmann::json& name : t.at("models"))
        if (const auto row = rows.find(name.get<std::string>()); row != rows.end())
          table.rows.push_back(row->second);
    }
    if (j.contains("plots"))
      for (const nlohmann::json& p : j.at("plots"))
        summary.plots.push_back({folder / std::filesystem::path(p.at("file").get<std::string>()).filename(),
                                 p.at("title").get<std::string>(), p.at("caption").get<std::string>()});
    return summary;
  } catch (const std::exception& failure) {
    return Error{ErrorCode::bad_input, fmt::format("{} cannot be read: {}.", path.string(), failure.what()),
                 "Delete it and start the comparison again; what was trained is kept.", path.string()};
  }
}

}  // namespace likeness
