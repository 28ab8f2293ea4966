// likeness demo: write the built-in capture with its ground truth, or its true detail maps; or list the
// people and lights it can have.
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/truth/true_detail.h"
#include "core/synth/cast.h"
#include "core/synth/demo_camera.h"
#include "core/synth/demo_capture.h"

namespace likeness::app {

namespace {

struct DemoArguments {
  CommonOptions common;
  std::filesystem::path folder;
  std::filesystem::path displacement, out;  // a project fitted to the demo, and where its true maps go
  DemoOptions options;
  double hand_shift_mm = 1000 * DemoOptions().hand_shift_m;
  int height = 0;  // 0: as wide
  bool list = false;
};

int list_cast(bool json) {
  const auto& people = demo_people();
  const auto& lights = demo_lights();
  if (json) {
    nlohmann::json cast = {{"people", nlohmann::json::array()}, {"lights", lights}};
    for (const DemoPerson& p : people)
      cast["people"].push_back({{"name", p.name}, {"description", p.description}});
    print_json(cast);
    return kExitDone;
  }
  for (std::size_t i = 0; i < people.size(); ++i)
    fmt::print("--person {}  {}: {}\n", i, people[i].name, people[i].description);
  for (std::size_t i = 0; i < lights.size(); ++i) fmt::print("--light {}   {}\n", i, lights[i]);
  return kExitDone;
}

// The detail maps that a perfect estimator would give for an existing demo, for fit --displacement.
int write_maps(const DemoArguments& a) {
  const auto project = open_project(a.displacement);
  if (!project) return report_failure(project.error());
  std::optional<Result<TrueDetailReport>> report;
  {
    const ProgressLine line(a.common);
    report = write_true_detail(*project, a.folder, a.out, {.person = a.options.person}, line.progress(),
                               stop_on_signals());
  }
  if (!*report) return report_failure(report->error());
  const TrueDetailReport& r = **report;
  if (a.common.json)
    print_json({{"frames", r.frames}, {"rms_mm", r.rms_mm}, {"varying_mm", r.varying_mm}});
  else
    fmt::print("{} maps; the true face lies {:.2f} mm rms off the tracked one, {:.2f} of it varying\n",
               r.frames, r.rms_mm, r.varying_mm);
  return kExitDone;
}

int run(DemoArguments arguments) {
  if (arguments.list) return list_cast(arguments.common.json);
  const ThreadLimit limit(arguments.common.threads);
  if (!arguments.displacement.empty()) return write_maps(arguments);
  arguments.options.seed = int(arguments.common.seed);
  Result<void> outcome;
  {
    const ProgressLine line(arguments.common);
    outcome = write_demo_capture(arguments.folder, arguments.options, line.progress(), stop_on_signals());
  }
  if (!outcome) return report_failure(outcome.error());
  const std::string video = (arguments.folder / "demo.mp4").string();
  if (arguments.common.json) {
    print_json({{"video", video}, {"frames", arguments.options.frames}});
  } else {
    tell("Wrote {}. Next: likeness build {} --project demo.likeness\n", video, video);
  }
  return kExitDone;
}

// The faults of a phone's films.
void add_fault_options(CLI::App& verb, DemoArguments& a) {
  DemoOptions& o = a.options;
  std::map<std::string, DemoCamera> cameras;
  for (std::size_t i = 0; i < demo_camera_names().size(); ++i)
    cameras[demo_camera_names()[i]] = DemoCamera(i);
  verb.add_option("--camera", o.camera,
                  fmt::format("How it is filmed: {}; default: guided, as people are asked to film",
                              fmt::join(demo_camera_names(), ", ")))
      ->transform(CLI::CheckedTransformer(cameras));
  verb.add_option("--hand-turn", o.hand_turn_deg,
                  "handheld, zoom: the hand turns the camera by at most this, °")
      ->check(CLI::Range(0.0, kMostHandTurn_deg))
      ->capture_default_str();
  verb.add_option("--hand-shift", a.hand_shift_mm,
                  "handheld, zoom: and displaces it by at most this, mm; 0: it only turns")
      ->check(CLI::Range(0.0, 1000 * kMostHandShift_m))
      ->capture_default_str();
  verb.add_option("--cuts", o.cuts, "Hard cuts, of different kinds")->check(CLI::Range(0, 100));
  verb.add_option("--hair", o.hair, "own, or loose: long, before and behind the shoulders")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, DemoHair>{{"own", DemoHair::own}, {"loose", DemoHair::loose}}));
  verb.add_option("--wall", o.wall,
                  "Instead of the room: plain, a wall without texture; textured, with plaster")
      ->transform(CLI::CheckedTransformer(std::map<std::string, DemoWall>{
          {"furnished", DemoWall::furnished}, {"plain", DemoWall::plain}, {"textured", DemoWall::textured}}));
  verb.add_flag("--still-torso", o.still_torso, "The torso does not move");
  verb.add_flag("--drift", o.drift, "Exposure, white balance and focus wander");
  verb.add_flag("--motion-blur", o.motion_blur, "What moves quickly is blurred");
  verb.add_flag("--lens-tag", o.lens_tag, "The film says its focal length, as phones do");
  verb.add_option("--height", a.height, "Height of the picture, px; default: as wide, a square")
      ->check(CLI::Range(96, 2048));
}

}  // namespace

void add_demo_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<DemoArguments>();
  CLI::App* verb = program.add_subcommand("demo", "Write the built-in demo capture with its ground truth");
  CLI::Option* folder = verb->add_option("folder", a->folder, "Where to write it");
  CLI::Option* list = verb->add_flag("--list", a->list, "Name the people and lights, write nothing");
  verb->add_option("--person", a->options.person, "Who plays; see --list")
      ->check(CLI::Range(0, int(demo_people().size()) - 1));
  verb->add_option("--light", a->options.light, "In which light; see --list")
      ->check(CLI::Range(0, int(demo_lights().size()) - 1));
  verb->add_option("--size", a->options.width,
                   "Width of the picture, px, and its height, if that is not given")
      ->check(CLI::Range(96, 2048));
  verb->add_option("--frames", a->options.frames, "Number of frames")->check(CLI::Range(8, 10000));
  verb->add_option("--moving-share", a->options.moving_share, "Share of the frames in which the camera moves")
      ->check(CLI::Range(0.0, 1.0));
  verb->add_flag("--restless-head", a->options.restless_head,
                 "The head turns already while the camera moves, as nobody should film");
  verb->add_flag("--habit", a->options.habit,
                 "Now and then the person puffs one cheek, which no expression of a head model carries");
  verb->add_option("--head-within", a->options.head_within_deg,
                   "The head turns at most this far from its rest, °")
      ->check(CLI::Range(0.1, kWidestTurn_deg))
      ->capture_default_str();
  verb->add_option("--action-share", a->options.action_share,
                   "At most this share of each action of the face is performed, lids included")
      ->check(CLI::Range(0.01, 1.0))
      ->capture_default_str();
  add_fault_options(*verb, *a);
  verb->add_option("--samples", a->options.samples_per_pixel, "Rays per pixel")->check(CLI::Range(1, 64));
  CLI::Option* maps = verb->add_option(
      "--displacement", a->displacement,
      "A project fitted to the demo in the folder: writes its true detail maps, for fit --displacement");
  CLI::Option* out = verb->add_option("--out", a->out, "Folder for these maps");
  maps->needs(out), out->needs(maps);
  add_common_options(*verb, a->common);
  verb->callback([a, folder, list, &exit_code] {
    if (list->count() == 0 && folder->count() == 0) throw CLI::RequiredError("folder");
    a->options.height = a->height > 0 ? a->height : a->options.width;
    a->options.hand_shift_m = a->hand_shift_mm / 1000;
    exit_code = run(*a);
  });
}

}  // namespace likeness::app
