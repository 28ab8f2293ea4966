// Tables, plots and the page: see model_report.h.
#include "core/lab/study/model_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/base64.h"
#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/image/files.h"
#include "core/lab/study/finished_rows.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

using Figure = std::optional<double> (*)(const ModelScore&);
struct Column {
  const char *name, *heading;  // of the files, of the page
  int digits;
  Figure figure;
};
constexpr Column kColumns[] = {
    {"psnr_db", "PSNR full, dB", 2, [](const ModelScore& s) { return s.psnr_db; }},
    {"psnr_person_db", "person", 2, [](const ModelScore& s) { return std::optional(s.psnr_person_db); }},
    {"psnr_head_db", "head", 2, [](const ModelScore& s) { return std::optional(s.psnr_head_db); }},
    {"psnr_face_db", "face", 2, [](const ModelScore& s) { return std::optional(s.psnr_face_db); }},
    {"mse", "MSE", 5, [](const ModelScore& s) { return s.mse; }},
    {"face_mse", "FaceMSE", 5, [](const ModelScore& s) { return std::optional(s.face_mse); }},
    {"ssim", "SSIM", 4, [](const ModelScore& s) { return s.ssim; }},
    {"gmsd", "GMSD", 4, [](const ModelScore& s) { return s.gmsd; }},
    {"lpips", "LPIPS", 4, [](const ModelScore& s) { return s.lpips; }},
    {"lmk_error_px", "landmarks, px", 2,
     [](const ModelScore& s) { return std::optional(s.landmark_error_px); }},
    {"lmk_mouth_px", "mouth", 2, [](const ModelScore& s) { return std::optional(s.mouth_error_px); }},
    {"lmk_eyes_px", "eyes", 2, [](const ModelScore& s) { return s.eyes_error_px; }},
    {"psnr_refit_db", "refitted full, dB", 2, [](const ModelScore& s) { return s.psnr_refit_db; }},
    {"psnr_refit_head_db", "refitted head", 2, [](const ModelScore& s) { return s.psnr_refit_head_db; }},
    {"psnr_refit_face_db", "refitted face", 2, [](const ModelScore& s) { return s.psnr_refit_face_db; }},
    {"train_seconds", "training, s", 0, [](const ModelScore& s) { return std::optional(s.train_seconds); }},
    {"steps", "steps", 0, [](const ModelScore& s) { return std::optional(double(s.steps)); }},
    {"frames_per_second", "frames/s", 2,
     [](const ModelScore& s) { return std::optional(1 / std::max(s.frame_seconds, 1e-9)); }},
    {"frames_per_joule", "frames/J", 3,
     [](const ModelScore& s) {
       return s.frame_joules ? std::optional(1 / std::max(*s.frame_joules, 1e-9)) : std::nullopt;
     }},
    {"samples_per_ray", "samples per ray", 1, [](const ModelScore& s) { return s.samples_per_ray; }},
    {"parameters", "parameters", 0, [](const ModelScore& s) { return std::optional(double(s.parameters)); }},
};

bool has_column(const ModelStudy& study, const Column& column) {
  return std::ranges::any_of(study.rows, [&](const ModelRow& row) {
    return std::ranges::any_of(row.scores, [&](const ModelScore& s) { return column.figure(s).has_value(); });
  });
}

std::optional<Spread> over_seeds(const ModelRow& row, const Column& column) {
  std::vector<std::optional<double>> values;
  for (const ModelScore& s : row.scores) values.push_back(column.figure(s));
  return spread_of(values);
}

// Mean over the seeds and, if there are several, half their range; a dash if there is none.
std::string cell(const ModelRow& row, const Column& column) {
  const auto spread = over_seeds(row, column);
  if (!spread) return "-";
  std::string text = fmt::format("{:.{}f}", spread->mean, column.digits);
  if (spread->half_range > 0) text += fmt::format(" &plusmn;{:.{}f}", spread->half_range, column.digits);
  return text;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

Result<std::string> inlined(const fs::path& picture, std::string_view about) {
  const auto bytes = read_file(picture);
  if (!bytes) return bytes.error();
  return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", escaped(about), base64(*bytes));
}

std::string rows_of(const ModelStudy& study, const StudyTable& table) {
  std::string html = "<table>\n<tr><th>model</th><th class=\"about\"></th>";
  for (const Column& column : kColumns)
    if (has_column(study, column)) html += fmt::format("<th>{}</th>", column.heading);
  html += "</tr>\n";
  for (const std::string& name : table.models) {
    const auto row = std::ranges::find(study.rows, name, [](const ModelRow& r) { return r.spec.name; });
    if (row == study.rows.end()) continue;
    if (!row->failed.empty()) {
      html += fmt::format("<tr><th>{}</th><td class=\"about\">{}. Not trained: {}</td></tr>\n", escaped(name),
                          escaped(row->spec.about), escaped(row->failed));
      continue;
    }
    html +=
        fmt::format("<tr><th>{}</th><td class=\"about\">{}</td>", escaped(name), escaped(row->spec.about));
    for (const Column& column : kColumns)
      if (has_column(study, column)) html += fmt::format("<td>{}</td>", cell(*row, column));
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string parts_of(const ModelStudy& study) {
  if (study.parts.empty()) return "";
  std::string html = "<h2>What a build makes of this capture</h2>\n<table>\n";
  for (const AvatarPart& part : study.parts)
    html += fmt::format("<tr><th>{}</th><td class=\"about\">{}</td><td class=\"about\">{}</td></tr>\n",
                        escaped(part_title(part.name)), escaped(part.value), escaped(part.reason));
  return html + "</table>\n";
}

std::string ratios_of(const ModelStudy& study) {
  const auto r = study_ratios(study);
  if (!r) return "";
  std::string html = fmt::format(
      "<ul>\n<li>Held-out head: {:.2f} dB, the baseline {:.2f} dB after {:.0f} times the time.</li>\n"
      "<li>{:+.2f} dB ahead of it when both have had {:.0f} s.</li>\n",
      r->ours_db, r->baseline_db, r->times_longer, r->equal_time_db, r->equal_seconds);
  html += r->sooner.empty() ? std::string("<li>The baseline's long training is not reached.</li>\n")
                            : fmt::format(
                                  "<li>{} reaches the baseline's long training in a {:.0f}th of its "
                                  "time.</li>\n",
                                  escaped(r->sooner), r->times_sooner);
  html += fmt::format("<li>A picture of {} px takes a {:.0f}th of the baseline's time", study.size,
                      r->times_faster);
  if (r->times_faster_full)
    html += fmt::format(", one of {} px a {:.0f}th", study.full_size, *r->times_faster_full);
  return html + ".</li>\n</ul>\n";
}

std::string qualities_of(const ModelRow& row) {
  const ModelScore& s = row.scores.front();
  std::string html;
  if (!s.qualities.empty()) {
    html +=
        "<table>\n<tr><th>setting</th><th>PSNR full, dB</th><th>head</th><th>face</th><th>frames/s</th>"
        "<th>fields, MB</th></tr>\n";
    for (const PictureCost& q : s.qualities)
      html += fmt::format(
          "<tr><th>{}</th><td>{}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.1f}</td></tr>\n",
          escaped(q.name), q.psnr_db ? fmt::format("{:.2f}", *q.psnr_db) : "-", q.psnr_head_db,
          q.psnr_face_db, 1 / std::max(q.frame_seconds, 1e-9), double(q.bytes) / 1e6);
    html += "</table>\n";
  }
  return html;
}

std::string sizes_of(const ModelStudy& study) {
  std::string html;
  for (const ModelRow& row : study.rows)
    for (const SizeCost& z : row.scores.empty() ? std::vector<SizeCost>() : row.scores.front().sizes)
      html += fmt::format("<tr><th>{}</th><td>{}</td><td>{:.3f}</td></tr>\n", escaped(row.spec.name), z.size,
                          z.frame_seconds);
  if (html.empty()) return html;
  return "<table>\n<tr><th>model</th><th>px</th><th>processor s per picture</th></tr>\n" + html +
         "</table>\n";
}

// A column for each shown frame, a row for each model.
Result<std::string> gallery(const ModelStudy& study, const fs::path& folder) {
  std::string html = "<table class=\"pictures\">\n<tr><th></th>";
  for (const int frame : study.shown) html += fmt::format("<th>frame {}</th>", frame);
  html += "</tr>\n";
  const auto add = [&](const std::string& name, const std::vector<std::string>& files) -> Result<void> {
    html += fmt::format("<tr><th>{}</th>", escaped(name));
    for (const std::string& file : files) {
      if (file.empty()) {  // the model's own track lost this frame
        html += "<td></td>";
        continue;
      }
      const auto picture = inlined(folder / file, name);
      if (!picture) return picture.error();
      html += "<td>" + *picture + "</td>";
    }
    html += "</tr>\n";
    return {};
  };
  if (const auto added = add("truth", study.truths); !added) return added.error();
  for (const ModelRow& row : study.rows)
    if (row.failed.empty())
      if (const auto added = add(row.spec.name, row.pictures); !added) return added.error();
  return html + "</table>\n";
}

constexpr const char* kStyle =
    "body{font:15px/1.5 sans-serif;max-width:1500px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;margin:1em 0}th,td{padding:.25em .6em;border-bottom:1px solid #ddd;"
    "text-align:right}tr>th:first-child,.about{text-align:left}tr>th:first-child{white-space:nowrap}"
    ".pictures td{border:0;padding:2px}.pictures img{width:256px;display:block}img{max-width:100%}";

double mean_of(const ModelRow& row, double ModelScore::*figure) {
  double sum = 0;
  for (const ModelScore& s : row.scores) sum += s.*figure / double(row.scores.size());
  return sum;
}

// Learning curves of the models that are trained for the full time, and of the long trainings.
Plot over_training(const ModelStudy& study, bool steps) {
  Plot plot{steps ? "Held-out head against steps" : "Held-out head against training time",
            steps ? "steps" : "processor seconds of training",
            "PSNR of the head, dB",
            true,
            {}};
  for (const ModelRow& row : study.rows) {
    if (row.scores.empty() || row.scores.front().marks.size() < 2) continue;
    if (row.spec.share != 1 && row.spec.name != kLongBaseline && row.spec.name != "ours-long") continue;
    PlotSeries& series = plot.series.emplace_back(PlotSeries{row.spec.name, {}});
    for (const ModelMark& m : row.scores.front().marks)
      series.points.emplace_back(steps ? double(m.step) : m.seconds, m.psnr_head_db);
  }
  return plot;
}

Plot over_speed(const ModelStudy& study) {
  Plot plot{"Held-out head against speed", "frames per processor second", "PSNR of the head, dB", true, {}};
  for (const ModelRow& row : study.rows) {
    if (row.scores.empty() || row.spec.share < 1) continue;
    PlotSeries& series = plot.series.emplace_back(PlotSeries{row.spec.name, {}});
    series.points.emplace_back(1 / std::max(mean_of(row, &ModelScore::frame_seconds), 1e-9),
                               mean_of(row, &ModelScore::psnr_head_db));
  }
  return plot;
}

// The settings of one model; those that no other is both faster and better than are joined by a line.
Plot pareto(const std::vector<PictureCost>& qualities) {
  Plot plot{"A picture's quality against its speed",
            "frames per processor second",
            "PSNR of the head, dB",
            true,
            {}};
  std::vector<PictureCost> by_speed = qualities;
  std::ranges::sort(by_speed, {}, &PictureCost::frame_seconds);
  PlotSeries front{"front", {}};
  double best = -INFINITY;
  for (const PictureCost& q : by_speed) {
    if (!(q.psnr_head_db > best)) continue;
    best = q.psnr_head_db;
    front.points.emplace_back(1 / std::max(q.frame_seconds, 1e-9), q.psnr_head_db);
  }
  plot.series.push_back(std::move(front));
  for (const PictureCost& q : qualities)
    plot.series.push_back({q.name, {Vec2d(1 / std::max(q.frame_seconds, 1e-9), q.psnr_head_db)}});
  return plot;
}

Plot over_size(const ModelStudy& study) {
  Plot plot{"What a picture costs", "px", "frames per processor second", true, {}};
  for (const ModelRow& row : study.rows) {
    if (row.scores.empty() || row.scores.front().sizes.empty()) continue;
    PlotSeries& series = plot.series.emplace_back(PlotSeries{row.spec.name, {}});
    for (const SizeCost& z : row.scores.front().sizes)
      series.points.emplace_back(z.size, 1 / std::max(z.frame_seconds, 1e-9));
  }
  return plot;
}

nlohmann::json to_json(const ModelRow& row) {
  nlohmann::json scores = nlohmann::json::array();
  for (const ModelScore& s : row.scores) {
    nlohmann::json score = {{"seed", s.seed},
                            {"marks", nlohmann::json::array()},
                            {"qualities", nlohmann::json::array()},
                            {"sizes", nlohmann::json::array()}};
    for (const Column& column : kColumns) score[column.name] = finite_or_null(column.figure(s));
    score["steps"] = s.steps;
    for (const ModelMark& m : s.marks)
      score["marks"].push_back({{"seconds", m.seconds},
                                {"step", m.step},
                                {"psnr_db", finite_or_null(m.psnr_db)},
                                {"psnr_head_db", finite_or_null(m.psnr_head_db)}});
    for (const PictureCost& q : s.qualities)
      score["qualities"].push_back({{"name", q.name},
                                    {"psnr_db", finite_or_null(q.psnr_db)},
                                    {"psnr_head_db", finite_or_null(q.psnr_head_db)},
                                    {"psnr_face_db", finite_or_null(q.psnr_face_db)},
                                    {"frame_seconds", q.frame_seconds},
                                    {"bytes", q.bytes}});
    for (const SizeCost& z : s.sizes)
      score["sizes"].push_back({{"size", z.size}, {"frame_seconds", z.frame_seconds}});
    scores.push_back(std::move(score));
  }
  return {{"name", row.spec.name},
          {"about", row.spec.about},
          {"kind", kModelKinds[int(row.spec.kind)]},
          {"mode", mode_name(row.spec.mode)},
          {"failed", row.failed},
          {"scores", std::move(scores)}};
}

}  // namespace

std::vector<Table> models_tables(const ModelStudy& study) {
  std::vector<Table> tables;
  for (const StudyTable& shown : study.tables) {
    Table& table = tables.emplace_back(Table{.name = shown.name, .title = shown.title});
    table.columns = {{"model", "model"}, {"about", ""}, {"seeds", "seeds", 0}};
    for (const Column& column : kColumns)
      if (has_column(study, column)) table.columns.push_back({column.name, column.heading, column.digits});
    for (const std::string& name : shown.models) {
      const auto row = std::ranges::find(study.rows, name, [](const ModelRow& r) { return r.spec.name; });
      if (row == study.rows.end()) continue;
      std::vector<TableCell>& cells = table.rows.emplace_back();
      cells = {name, row->spec.about, int(row->scores.size())};
      for (const Column& column : kColumns) {
        if (!has_column(study, column)) continue;
        const auto spread = over_seeds(*row, column);
        cells.push_back(row->scores.size() == 1 && spread ? TableCell(spread->mean) : TableCell(spread));
      }
      if (!row->failed.empty()) table.notes.push_back(fmt::format("{} not trained: {}", name, row->failed));
    }
  }
  const ModelRow* ours = find_row(study, kDefaultModel);
  if (ours != nullptr && !ours->scores.front().qualities.empty()) {
    Table& table = tables.emplace_back(Table{.name = "qualities", .title = "Pictures of the default model"});
    table.columns = {
        {"setting", "setting"},   {"psnr_db", "PSNR full, dB"},          {"psnr_head_db", "head"},
        {"psnr_face_db", "face"}, {"frame_seconds", "s per picture", 4}, {"megabytes", "MB", 1}};
    for (const PictureCost& q : ours->scores.front().qualities)
      table.rows.push_back(
          {q.name, q.psnr_db, q.psnr_head_db, q.psnr_face_db, q.frame_seconds, double(q.bytes) / 1e6});
  }
  Table sizes{.name = "sizes",
              .title = "Pictures of other sizes",
              .columns = {{"model", "model"}, {"size_px", "px", 0}, {"frame_seconds", "s per picture", 3}}};
  for (const ModelRow& row : study.rows)
    for (const SizeCost& z : row.scores.empty() ? std::vector<SizeCost>() : row.scores.front().sizes)
      sizes.rows.push_back({row.spec.name, z.size, z.frame_seconds});
  if (!sizes.rows.empty()) tables.push_back(std::move(sizes));
  return tables;
}

Table trainings_table(const ModelStudy& study) {
  Table table{.name = "results",
              .columns = {{"model", "model"}, {"kind", "kind"}, {"mode", "mode"}, {"seed", "seed", 0}},
              .printed = false};
  for (const Column& column : kColumns) table.columns.push_back({column.name, column.heading, column.digits});
  for (const ModelRow& row : study.rows)
    for (const ModelScore& s : row.scores) {
      std::vector<TableCell>& cells = table.rows.emplace_back();
      cells = {row.spec.name, kModelKinds[int(row.spec.kind)], std::string(mode_name(row.spec.mode)), s.seed};
      for (const Column& column : kColumns) cells.push_back(column.figure(s));
    }
  return table;
}

std::string models_csv(const ModelStudy& study) {
  const Table table = trainings_table(study);
  return tables_csv({&table, 1});
}

std::string models_json(const ModelStudy& study) {
  nlohmann::json rows = nlohmann::json::array(), tables = nlohmann::json::array();
  for (const ModelRow& row : study.rows) rows.push_back(to_json(row));
  for (const StudyTable& table : study.tables)
    tables.push_back({{"name", table.name}, {"title", table.title}, {"models", table.models}});
  nlohmann::json parts = nlohmann::json::array();
  for (const AvatarPart& part : study.parts)
    parts.push_back({{"part", part.name}, {"on", part.on}, {"value", part.value}, {"reason", part.reason}});
  nlohmann::json plots = nlohmann::json::array();
  for (const StudyPlot& plot : study_plots(study))
    plots.push_back({{"file", plot.file}, {"title", plot.plot.title}, {"caption", plot.caption}});
  nlohmann::json all = {{"format", "likeness-model-study"},
                        {"version", 1},
                        {"clip", study.clip},
                        {"size", study.size},
                        {"full_size", study.full_size},
                        {"frames", study.frames},
                        {"training_frames", study.training_frames},
                        {"threads", study.threads},
                        {"seconds", study.seconds},
                        {"parts", std::move(parts)},
                        {"plots", std::move(plots)},
                        {"tables", std::move(tables)},
                        {"rows", std::move(rows)}};
  if (const auto r = study_ratios(study))
    all["ratios"] = {{"baseline_head_db", finite_or_null(r->baseline_db)},
                     {"head_db", finite_or_null(r->ours_db)},
                     {"equal_time_db", finite_or_null(r->equal_time_db)},
                     {"sooner", r->sooner},
                     {"times_sooner", r->times_sooner},
                     {"times_faster", r->times_faster},
                     {"times_faster_full", finite_or_null(r->times_faster_full)}};
  return json_text(all, 1) + "\n";
}

Result<StudySteps> read_study_steps(const fs::path& results) {
  const auto text = read_text(results);
  if (!text) return text.error();
  try {
    const nlohmann::json j = parse_json(*text);
    if (j.at("format") != "likeness-model-study") throw std::runtime_error("another format");
    StudySteps steps;
    for (const nlohmann::json& row : j.at("rows"))
      for (const nlohmann::json& score : row.at("scores")) {
        const auto taken = score.at("steps").get<std::uint64_t>();
        if (taken > 0)
          steps[{row.at("name").get<std::string>(), score.at("seed").get<std::uint64_t>()}] = taken;
      }
    return steps;
  } catch (const std::exception& failure) {
    return Error{ErrorCode::bad_input,
                 fmt::format("{} is not a study of models: {}.", results.string(), failure.what()),
                 "Give the results.json of a finished `likeness study PROJECT`.", results.string()};
  }
}

std::vector<StudyPlot> study_plots(const ModelStudy& study) {
  std::vector<StudyPlot> plots;
  const auto add = [&](const char* file, const char* caption, Plot plot) {
    if (std::ranges::any_of(plot.series, [](const PlotSeries& s) { return !s.points.empty(); }))
      plots.push_back({file, caption, std::move(plot)});
  };
  add("psnr_over_seconds.png",
      "The first seed; the marks are means over at most four of the frames, and the training's clock stood "
      "still while they were taken.",
      over_training(study, false));
  add("psnr_over_steps.png", "The same by steps.", over_training(study, true));
  add("psnr_over_speed.png", "Means of the seeds, at the end.", over_speed(study));
  if (const ModelRow* ours = find_row(study, kDefaultModel);
      ours != nullptr && !ours->scores.front().qualities.empty())
    add("qualities.png",
        "One avatar, rendered under several settings; no setting is both faster and better "
        "than those of the front.",
        pareto(ours->scores.front().qualities));
  add("cost_over_size.png", "By the side of the picture.", over_size(study));
  return plots;
}

Result<std::string> models_page(const ModelStudy& study, const fs::path& folder) {
  const std::string time =
      study.seconds > 0 ? fmt::format("{:g} processor seconds per training{}", study.seconds,
                                      study.some_by_steps ? ", except those that were given steps" : "")
                        : "trained by steps";
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>Models side by side: {0}"
      "</title><style>{1}</style></head>\n<body>\n<h1>Models side by side: {0}</h1>\n"
      "<p>{2} training pictures of {3} px, {4} threads, {5}. Every model draws its rays from the same "
      "pictures and track and is measured on the same {6} held-out frames, as tracked. Seconds are processor "
      "seconds, of all threads together; several seeds: the mean and half the range.</p>\n",
      escaped(study.clip), kStyle, study.training_frames, study.size, study.threads, time,
      study.frames.size());
  html += parts_of(study);
  for (const StudyTable& table : study.tables) {
    html += fmt::format("<h2>{}</h2>\n<p>{}</p>\n", escaped(table.title), escaped(table.about));
    html += rows_of(study, table);
    if (table.name == "time") html += ratios_of(study);
  }
  html += "<h2>Speed against quality</h2>\n";
  if (const ModelRow* ours = find_row(study, kDefaultModel)) html += qualities_of(*ours);
  html += sizes_of(study);
  for (const StudyPlot& plot : study_plots(study)) {
    const auto picture = inlined(folder / plot.file, plot.plot.title);
    if (!picture) return picture.error();
    html += fmt::format("<p>{}</p>\n<p>{}</p>\n", *picture, escaped(plot.caption));
  }
  html += "<h2>Frames never seen</h2>\n";
  const auto pictures = gallery(study, folder);
  if (!pictures) return pictures.error();
  return html + *pictures + "</body>\n</html>\n";
}

Result<void> write_model_report(const ModelStudy& study, const fs::path& folder) {
  for (const StudyPlot& plot : study_plots(study))
    if (auto written = write_image(folder / plot.file, draw_plot(plot.plot)); !written) return written;
  const auto page = models_page(study, folder);
  if (!page) return page.error();
  if (auto written = write_text(folder / "results.csv", models_csv(study)); !written) return written;
  if (auto written = write_text(folder / "results.json", models_json(study)); !written) return written;
  return write_text(folder / "report.html", *page);
}

}  // namespace likeness
