// likeness clips: lists the clips of a project; adds and removes further ones of the same person.
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/project_options.h"
#include "app/terminal.h"
#include "core/project/care.h"
#include "core/project/further_clips.h"

namespace likeness::app {

namespace {

struct ClipsArguments {
  CommonOptions common;
  std::filesystem::path project, add;
  std::optional<CameraKind> camera;
  std::optional<int> remove;
};

// What became of a further clip.
std::string state_words(const Project& clip) {
  if (clip.record(Stage::matte).state == StageState::done) return clip.record(Stage::fit).message;
  for (const Stage stage : kStages)
    if (clip.record(stage).state == StageState::failed) return clip.record(stage).message;
  return "Not read yet.";
}

nlohmann::json list(const Project& project) {
  nlohmann::json clips = nlohmann::json::array();
  clips.push_back({{"number", 1},
                   {"video", project.options.shared.video.string()},
                   {"message", project.record(Stage::fit).message}});
  for (const int number : project.further_clips) {
    const auto clip = open_further_clip(project, number);
    clips.push_back({{"number", number},
                     {"video", clip ? clip->options.shared.video.string() : ""},
                     {"message", clip ? state_words(*clip) : clip.error().what}});
  }
  return clips;
}

int run_clips(const ClipsArguments& arguments) {
  auto project = open_project(arguments.project);
  if (!project) return report_failure(project.error());
  if (arguments.remove)
    if (const auto removed = remove_further_clip(*project, *arguments.remove); !removed)
      return report_failure(removed.error());
  if (!arguments.add.empty()) {
    const auto number = add_further_clip(*project, arguments.add, arguments.camera);
    if (!number) return report_failure(number.error());
  }
  const nlohmann::json clips = list(*project);
  if (arguments.common.json) {
    print_json({{"project", project->folder.string()}, {"clips", clips}});
    return kExitDone;
  }
  for (const nlohmann::json& clip : clips)
    fmt::print("{:>3}  {}  {}\n", clip.at("number").get<int>(), clip.at("video").get<std::string>(),
               clip.at("message").get<std::string>());
  if (arguments.remove || !arguments.add.empty())
    fmt::print(stderr, "To make the avatar from these clips: likeness train {}\n", project->folder.string());
  return kExitDone;
}

}  // namespace

void add_clips_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<ClipsArguments>();
  CLI::App* clips = program.add_subcommand(
      "clips", "The clips of a project; further ones of the same person show what the first did not");
  clips->add_option("project", a->project, "Project folder")->required();
  CLI::Option* add = clips->add_option("--add", a->add, "Another clip of the same person");
  add_camera_kind_option(*clips, a->camera)->needs(add);
  add_resting_flag(*clips, a->camera)->needs(add);
  clips->add_option("--remove", a->remove, "Remove the clip with this number, and what was made of it")
      ->check(CLI::Range(kFirstFurtherClip, 1'000'000));
  add_common_options(*clips, a->common);
  clips->callback([a, &exit_code] { exit_code = run_clips(*a); });
}

}  // namespace likeness::app
