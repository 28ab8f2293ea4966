// likeness study cameras: the camera stage beside known cameras.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/files.h"
#include "core/base/parallel.h"
#include "core/lab/truth/camera_truth.h"
#include "core/matte/matte.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct CameraStudyArguments {
  CommonOptions common;
  fs::path folder, landmark_model;
  std::vector<std::string> masks;
};

nlohmann::json to_json(const CameraRow& row) {
  nlohmann::json j{{"masks", row.masks},
                   {"outcome", row.outcome},
                   {"seconds", row.seconds},
                   {"processor_seconds", row.processor_seconds}};
  if (!row.errors) return j;
  const CameraErrors& e = *row.errors;
  j.update({{"wanted", e.wanted},
            {"found", e.found},
            {"position_median_percent", e.position_median_percent},
            {"position_max_percent", e.position_max_percent},
            {"turn_median_deg", e.turn_median_deg},
            {"turn_max_deg", e.turn_max_deg},
            {"shared_turn_deg", e.shared_turn_deg},
            {"own_turn_median_deg", e.own_turn_median_deg},
            {"focal_percent", e.focal_percent}});
  return j;
}

void print_rows(const std::vector<CameraRow>& rows) {
  fmt::print("{:<8} {:>9} {:>10} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "masks", "found", "position",
             "worst", "turn", "worst", "shared", "own", "focal", "cpu");
  for (const CameraRow& row : rows) {
    if (row.errors) {
      const CameraErrors& e = *row.errors;
      fmt::print(
          "{:<8} {:>4}/{:<4} {:>8.3f} % {:>6.2f} % {:>7.3f}° {:>7.3f}° {:>7.3f}° {:>7.3f}° {:>+6.2f} % "
          "{:>6.0f} s\n",
          row.masks, e.found, e.wanted, e.position_median_percent, e.position_max_percent, e.turn_median_deg,
          e.turn_max_deg, e.shared_turn_deg, e.own_turn_median_deg, e.focal_percent, row.processor_seconds);
    } else {
      fmt::print("{:<8} no path {:>76.0f} s\n", row.masks, row.processor_seconds);
    }
  }
  fmt::print(
      "median and worst camera after one similarity; position of the path's extent; shared: the turn that "
      "all\n"
      "cameras have in common, own: the median without it\n");
  for (const CameraRow& row : rows) fmt::print("{}: {}\n", row.masks, row.outcome);
}

// A folder of its own, removed when the study ends.
class WorkFolder {
 public:
  WorkFolder() {
    std::error_code ignored;
    std::string name = (fs::temp_directory_path(ignored) / "likeness_cameras_XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

int run(const CameraStudyArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  const auto truth = read_camera_truth(arguments.folder);
  if (!truth) return report_failure(truth.error());
  std::vector<NamedMask> masks;
  for (const std::string& name : arguments.masks) {
    NamedMask mask{name, {}};
    if (name == "person") {
      auto person = coarse_person_mask(arguments.landmark_model,
                                       truth->photographs ? Pictures::single : Pictures::in_sequence);
      if (!person) return report_failure(person.error());
      mask.person = std::move(*person);
    }
    masks.push_back(std::move(mask));
  }
  const WorkFolder work;
  if (work.path().empty())
    return report_failure(file_error(fs::temp_directory_path(), "create a folder in", errno));
  AlignOptions options;
  options.seed = int(arguments.common.seed);
  std::optional<Result<std::vector<CameraRow>>> rows;
  {
    const ProgressLine line(arguments.common);
    rows = study_cameras(*truth, masks, work.path(), options, line.progress(), stop_on_signals());
  }
  if (!*rows) return report_failure(rows->error());
  if (!arguments.common.json) {
    print_rows(**rows);
    return kExitDone;
  }
  nlohmann::json list = nlohmann::json::array();
  for (const CameraRow& row : **rows) list.push_back(to_json(row));
  print_json({{"rows", list}});
  return kExitDone;
}

}  // namespace

void add_camera_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<CameraStudyArguments>();
  a->masks = {"person"};
  CLI::App* verb = study.add_subcommand("cameras", "The camera stage beside known cameras");
  verb->add_option("folder", a->folder,
                   "A folder of `likeness demo`, or photographs with their transforms.json")
      ->required();
  verb->add_option("--masks", a->masks,
                   "What is kept out of the solve, a row for each: person, none; default: person")
      ->check(CLI::IsMember({"person", "none"}));
  verb->add_option("--landmark-model", a->landmark_model,
                   "A dlib 68-point shape predictor; default: the system's");
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
