// Tables, plots and the page: see modes_report.h.
#include "core/study/modes_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/base64.h"
#include "core/base/files.h"
#include "core/image/files.h"
#include "core/study/finished_rows.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSecondsPlot = "psnr_over_seconds.png";
constexpr const char* kSpeedPlot = "psnr_over_speed.png";

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
    {"ssim", "SSIM", 4, [](const ModelScore& s) { return s.ssim; }},
    {"gmsd", "GMSD", 4, [](const ModelScore& s) { return s.gmsd; }},
    {"lmk_error_px", "landmarks, px", 2,
     [](const ModelScore& s) { return std::optional(s.landmark_error_px); }},
    {"frame_ms", "ms a frame", 0, [](const ModelScore& s) { return std::optional(s.frame_ms); }},
    {"train_seconds", "training, s", 0, [](const ModelScore& s) { return std::optional(s.train_seconds); }},
    {"steps", "steps", 0, [](const ModelScore& s) { return std::optional(double(s.steps)); }},
    {"parameters", "parameters", 0, [](const ModelScore& s) { return std::optional(double(s.parameters)); }},
};

// Mean over the seeds and, of several, half their range; a dash where one lacks it.
std::string cell(const ModelRow& row, const Column& column) {
  double sum = 0, low = INFINITY, high = -INFINITY;
  for (const ModelScore& s : row.scores) {
    const auto value = column.figure(s);
    if (!value || !std::isfinite(*value)) return "-";
    sum += *value, low = std::min(low, *value), high = std::max(high, *value);
  }
  if (row.scores.empty()) return "-";
  std::string text = fmt::format("{:.{}f}", sum / double(row.scores.size()), column.digits);
  if (high > low) text += fmt::format(" &plusmn;{:.{}f}", (high - low) / 2, column.digits);
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

std::string table(const ModesStudy& study) {
  std::string html = "<table>\n<tr><th>model</th>";
  for (const Column& column : kColumns) html += fmt::format("<th>{}</th>", column.heading);
  html += "</tr>\n";
  for (const ModelRow& row : study.rows) {
    html += fmt::format("<tr><th>{}</th>", escaped(model_name(row.kind)));
    for (const Column& column : kColumns) html += fmt::format("<td>{}</td>", cell(row, column));
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

// A column a shown frame, a row a model.
Result<std::string> gallery(const ModesStudy& study, const fs::path& folder) {
  std::string html = "<table class=\"pictures\">\n<tr><th></th>";
  for (const int frame : study.shown) html += fmt::format("<th>frame {}</th>", frame);
  html += "</tr>\n";
  const auto add = [&](const std::string& name, const std::vector<std::string>& files) -> Result<void> {
    html += fmt::format("<tr><th>{}</th>", escaped(name));
    for (const std::string& file : files) {
      const auto picture = inlined(folder / file, name);
      if (!picture) return picture.error();
      html += "<td>" + *picture + "</td>";
    }
    html += "</tr>\n";
    return {};
  };
  if (const auto added = add("truth", study.truths); !added) return added.error();
  for (const ModelRow& row : study.rows)
    if (const auto added = add(model_name(row.kind), row.pictures); !added) return added.error();
  return html + "</table>\n";
}

constexpr const char* kStyle =
    "body{font:15px/1.5 sans-serif;max-width:1200px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;margin:1em 0}th,td{padding:.25em .6em;border-bottom:1px solid #ddd;"
    "text-align:right}tr>th:first-child{text-align:left;white-space:nowrap}.pictures td{border:0;padding:2px}"
    ".pictures img{width:256px;display:block}img{max-width:100%}";

}  // namespace

std::string modes_csv(const ModesStudy& study) {
  std::string csv = "mode,encoder,seed";
  for (const Column& column : kColumns) csv += fmt::format(",{}", column.name);
  csv += "\n";
  for (const ModelRow& row : study.rows)
    for (const ModelScore& s : row.scores) {
      csv += fmt::format("{},{},{}", mode_name(row.kind.mode), kEncoders[int(row.kind.encoder)], s.seed);
      for (const Column& column : kColumns) {
        const auto value = column.figure(s);
        csv += value && std::isfinite(*value) ? fmt::format(",{}", *value) : ",";
      }
      csv += "\n";
    }
  return csv;
}

std::string modes_json(const ModesStudy& study) {
  nlohmann::json rows = nlohmann::json::array();
  for (const ModelRow& row : study.rows) {
    nlohmann::json scores = nlohmann::json::array();
    for (const ModelScore& s : row.scores) {
      nlohmann::json score = {{"seed", s.seed}, {"marks", nlohmann::json::array()}};
      for (const Column& column : kColumns) score[column.name] = finite_or_null(column.figure(s));
      for (const ModelMark& m : s.marks)
        score["marks"].push_back({{"seconds", m.seconds},
                                  {"step", m.step},
                                  {"psnr_db", finite_or_null(m.psnr_db)},
                                  {"psnr_head_db", finite_or_null(m.psnr_head_db)}});
      scores.push_back(std::move(score));
    }
    rows.push_back({{"mode", mode_name(row.kind.mode)},
                    {"encoder", kEncoders[int(row.kind.encoder)]},
                    {"scores", std::move(scores)}});
  }
  const nlohmann::json all = {{"clip", study.clip},       {"size", study.size},
                              {"frames", study.frames},   {"training_frames", study.training_frames},
                              {"threads", study.threads}, {"rows", std::move(rows)}};
  return all.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

Plot quality_over_seconds(const ModesStudy& study) {
  Plot plot{"Held-out head against training time", "seconds of training", "PSNR of the head, dB", true, {}};
  for (const ModelRow& row : study.rows) {
    PlotSeries& series = plot.series.emplace_back(PlotSeries{model_name(row.kind), {}});
    if (row.scores.empty()) continue;
    for (const ModelMark& m : row.scores.front().marks) series.points.emplace_back(m.seconds, m.psnr_head_db);
  }
  return plot;
}

Plot quality_over_speed(const ModesStudy& study) {
  Plot plot{"Held-out head against speed", "frames a second", "PSNR of the head, dB", true, {}};
  for (const ModelRow& row : study.rows) {
    PlotSeries& series = plot.series.emplace_back(PlotSeries{model_name(row.kind), {}});
    if (row.scores.empty()) continue;
    Vec2d mean(0, 0);
    for (const ModelScore& s : row.scores)
      mean += Vec2d(s.frame_ms, s.psnr_head_db) / double(row.scores.size());
    series.points.emplace_back(1000 / std::max(mean.x(), 1e-6), mean.y());
  }
  return plot;
}

Result<std::string> modes_page(const ModesStudy& study, const fs::path& folder) {
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>Models side by side: {0}"
      "</title><style>{1}</style></head>\n<body>\n<h1>Models side by side: {0}</h1>\n"
      "<p>{2} training pictures of {3} px, {4} threads. Every model draws its rays alike from the same "
      "pictures and track and is measured on the same {5} held-out frames. <em>grid</em>: hash grid; "
      "<em>mlp</em>: positional "
      "encoding and perceptrons of 8 x 256 with a coarse and a fine pass. <em>concat</em> is like NeRFace, "
      "<em>hyper</em> slices a hyper-space by the expression, <em>warp</em> is like RigNeRF.</p>\n",
      escaped(study.clip), kStyle, study.training_frames, study.size, study.threads, study.frames.size());
  html += table(study);
  for (const char* name : {kSecondsPlot, kSpeedPlot}) {
    const auto picture = inlined(folder / name, name);
    if (!picture) return picture.error();
    html += "<p>" + *picture + "</p>\n";
  }
  html +=
      "<p>The first seed; the training's clock stood still at its marks, which are means over at most four "
      "of the frames.</p>\n<h2>Frames never seen</h2>\n";
  const auto pictures = gallery(study, folder);
  if (!pictures) return pictures.error();
  return html + *pictures + "</body>\n</html>\n";
}

Result<void> write_modes_report(const ModesStudy& study, const fs::path& folder) {
  if (auto written = write_image(folder / kSecondsPlot, draw_plot(quality_over_seconds(study))); !written)
    return written;
  if (auto written = write_image(folder / kSpeedPlot, draw_plot(quality_over_speed(study))); !written)
    return written;
  const auto page = modes_page(study, folder);
  if (!page) return page.error();
  if (auto written = write_text(folder / "results.csv", modes_csv(study)); !written) return written;
  if (auto written = write_text(folder / "results.json", modes_json(study)); !written) return written;
  return write_text(folder / "report.html", *page);
}

}  // namespace likeness
