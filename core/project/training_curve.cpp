// training_curve.json: see training_curve.h.
#include "core/project/training_curve.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"

namespace likeness {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kCurveVersion = 1;
constexpr std::size_t kMaxPoints = 1000;

double rounded(double value, double unit) { return std::round(value / unit) * unit; }

}  // namespace

void thin_if_long(std::vector<TrainStatus>& points) {
  if (points.size() <= kMaxPoints) return;
  std::vector<TrainStatus> kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (i % 2 == 0 || i + 1 == points.size()) kept.push_back(points[i]);
  points = std::move(kept);
}

void add_point(TrainingCurve& curve, const TrainStatus& point) {
  std::erase_if(curve.training, [&](const TrainStatus& earlier) { return earlier.step >= point.step; });
  // A training that starts from its first steps is a new one: earlier held-out scores are not its own.
  if (curve.training.empty()) curve.held_out.clear();
  std::erase_if(curve.held_out, [&](const HeldOutScore& s) { return s.training_s > point.seconds + 60; });
  curve.training.push_back(point);
  thin_if_long(curve.training);
}

void add_score(TrainingCurve& curve, const HeldOutScore& score) {
  std::erase_if(curve.held_out, [&](const HeldOutScore& s) { return s.training_s >= score.training_s; });
  curve.held_out.push_back(score);
}

fs::path training_curve_path(const Project& project) { return project.folder / "training_curve.json"; }

Result<void> write_training_curve(const fs::path& path, const TrainingCurve& curve) {
  json training = json::array(), held_out = json::array();
  for (const TrainStatus& p : curve.training)
    training.push_back({p.step, rounded(p.seconds, 0.01), rounded(p.train_psnr_db, 0.001),
                        std::round(p.rays_per_s), p.loss});
  for (const HeldOutScore& s : curve.held_out)
    held_out.push_back({rounded(s.training_s, 0.01), rounded(s.psnr_db, 0.001)});
  const json file{{"version", kCurveVersion},
                  {"training_columns", {"step", "seconds", "psnr_db", "rays_per_s", "loss"}},
                  {"training", training},
                  {"held_out_columns", {"seconds", "psnr_db"}},
                  {"held_out", held_out}};
  return write_text(path, json_text(file) + "\n");
}

Result<TrainingCurve> read_training_curve(const fs::path& path) {
  const auto text = read_text(path);
  if (!text) return text.error();
  const auto damaged = [&](const std::string& why) {
    return Error{ErrorCode::bad_input, fmt::format("{} cannot be read: {}.", path.string(), why),
                 "Delete this file: it only draws the curve of the last training.", path.string()};
  };
  try {
    const json j = parse_json(*text);
    if (whole_number_in(j.at("version")) > kCurveVersion) return damaged("it was made by a newer Likeness");
    TrainingCurve curve;
    for (const json& p : j.at("training"))
      curve.training.push_back({p.at(0).get<std::uint64_t>(), p.at(1).get<double>(), p.at(4).get<double>(),
                                p.at(2).get<double>(), p.at(3).get<double>()});
    for (const json& s : j.at("held_out"))
      curve.held_out.push_back({s.at(0).get<double>(), s.at(1).get<double>()});
    for (std::size_t i = 1; i < curve.training.size(); ++i)
      if (curve.training[i].step <= curve.training[i - 1].step) return damaged("its steps do not ascend");
    return curve;
  } catch (const json::exception& e) {
    return damaged(e.what());
  }
}

}  // namespace likeness
