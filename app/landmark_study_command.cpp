// likeness study landmarks: what the landmark loss measures, beside a detector.
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/study/landmark_study.h"
#include "core/train/landmark_patches.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct LandmarkStudyArguments {
  CommonOptions common;
  fs::path project;
  int frames = 24;
};

nlohmann::json to_json(const OffsetAgreement& agreement) { return finite_or_null(agreement.correlation()); }

nlohmann::json to_json(const LandmarkStudy& study) {
  nlohmann::json rows = nlohmann::json::array();
  for (const LandmarkRow& row : study.rows)
    rows.push_back({{"landmark", row.landmark},
                    {"learnt_correlation", row.learnt_correlation},
                    {"spread", row.spread},
                    {"accepted", row.accepted},
                    {"shifted_truth", to_json(row.truth)},
                    {"shifted_truth_map", to_json(row.truth_map)},
                    {"shifted_truth_dlib", to_json(row.truth_dlib)},
                    {"shifted_render", to_json(row.shifted)},
                    {"shifted_render_map", to_json(row.shifted_map)},
                    {"render", to_json(row.render)}});
  return {{"frames", study.frames},
          {"stride_px", study.stride},
          {"interocular_px", study.interocular_px},
          {"rows", rows}};
}

// Accepted landmarks [first, last] together.
void print_part(const LandmarkStudy& study, const char* name, int first, int last) {
  OffsetAgreement truth, truth_map, truth_dlib, shifted, shifted_map, render;
  int accepted = 0, all = 0, hold = 0;
  double learnt = 0;
  for (const LandmarkRow& row : study.rows) {
    if (row.landmark < first || row.landmark > last) continue;
    ++all;
    if (!row.accepted) continue;
    ++accepted;
    learnt += row.learnt_correlation;
    hold += row.shifted.correlation() >= kMinCorrelation;
    truth.add(row.truth), truth_map.add(row.truth_map), truth_dlib.add(row.truth_dlib);
    shifted.add(row.shifted), shifted_map.add(row.shifted_map), render.add(row.render);
  }
  fmt::print("{:<6} {:>3} of {:<3}", name, accepted, all);
  const double mean = learnt / std::max(1, accepted);
  for (const double value : {mean, truth_map.correlation(), truth_dlib.correlation(), truth.correlation(),
                             shifted_map.correlation(), shifted.correlation(), render.correlation()})
    fmt::print(" {:>8.3f}", value);
  fmt::print(" {:>5} of {:<3}\n", hold, accepted);
}

void print(const LandmarkStudy& study) {
  fmt::print(
      "{:<6} {:>10} {:>8} {:>26} {:>17} {:>8} {:>11}\n{:<6} {:>10} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} "
      "{:>11}\n",
      "", "", "", "shifted truth", "shifted render", "render", "render", "", "accepted", "made up", "map",
      "dlib", "both", "map", "both", "both", fmt::format(">= {}", kMinCorrelation));
  print_part(study, "brows", 17, 26);
  print_part(study, "nose", 27, 35);
  print_part(study, "eyes", 36, 47);
  print_part(study, "mouth", 48, 67);
  print_part(study, "all", kFirstPatchLandmark, 67);
  fmt::print(
      "Correlations of offsets on {} held-out frames: by map or dlib with a known shift, and (both) with "
      "each "
      "other; last, how many landmarks reach the limit on shifted renders. Made up: of the maps on training "
      "views kept out. Patches of {} x {} pixels, {} apart; the eyes' outer corners are {:.0f} px apart.\n",
      study.frames, kPatchSide, kPatchSide, study.stride, study.interocular_px);
}

int run(const LandmarkStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  std::optional<Result<LandmarkStudy>> study;
  {
    const ProgressLine line(a.common);
    study = study_landmarks(*project, a.frames, line.progress(), stop_on_signals());
  }
  if (!*study) return report_failure(study->error());
  if (a.common.json)
    print_json(to_json(**study));
  else
    print(**study);
  return kExitDone;
}

}  // namespace

void add_landmark_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<LandmarkStudyArguments>();
  CLI::App* verb =
      study.add_subcommand("landmarks", "What the landmark loss measures, beside a landmark detector");
  verb->add_option("project", a->project, "A project with a trained avatar")->required();
  verb->add_option("--frames", a->frames, "Held-out frames, evenly chosen; 0: all")
      ->check(CLI::Range(0, 1'000'000));
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
