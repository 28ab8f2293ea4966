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
  std::optional<double> from_s, to_s;
  std::optional<int> remove;
};

// What became of a further clip.
std::string state_words(const Project& clip) {
  if (clip.record(Stage::matte).state == StageState::done) return clip.record(Stage::fit).message;
  for (const Stage stage : kStages)
    if (clip.record(stage).state == StageState::failed) return clip.record(stage).message;
  return "Not read yet.";
}

// The seconds of it that are read; to_s is null where they go to its end.
nlohmann::json row_of(int number, const ProjectOptions& options, const std::string& message) {
  const auto& [from_s, to_s] = options.import.seconds;
  return {{"number", number},
          {"video", options.shared.video.string()},
          {"from_s", from_s},
          {"to_s", to_s > 0 ? nlohmann::json(to_s) : nlohmann::json()},
          {"message", message}};
}

nlohmann::json list(const Project& project) {
  nlohmann::json clips = nlohmann::json::array();
  clips.push_back(row_of(1, project.options, project.record(Stage::fit).message));
  for (const int number : project.further_clips) {
    const auto clip = open_further_clip(project, number);
    clips.push_back(clip ? row_of(number, clip->options, state_words(*clip))
                         : row_of(number, {}, clip.error().what));
  }
  return clips;
}

// As the options say, which the clip itself decides about.
Result<ClipSeconds> asked_seconds(const ClipsArguments& arguments) {
  const ClipSeconds seconds{arguments.from_s.value_or(0), arguments.to_s.value_or(0)};
  if (arguments.to_s && !(seconds.to_s > seconds.from_s))
    return Error{ErrorCode::bad_input,
                 fmt::format("Second {:.6g} is not after second {:.6g}.", seconds.to_s, seconds.from_s),
                 "Choose a --to that is later than --from.", "--to"};
  return seconds;
}

int run_clips(const ClipsArguments& arguments) {
  const auto seconds = asked_seconds(arguments);
  if (!seconds) return report_failure(seconds.error());
  auto project = open_project(arguments.project);
  if (!project) return report_failure(project.error());
  if (arguments.remove)
    if (const auto removed = remove_further_clip(*project, *arguments.remove); !removed)
      return report_failure(removed.error());
  if (!arguments.add.empty()) {
    const auto number = add_further_clip(*project, arguments.add, arguments.camera, *seconds);
    if (!number) return report_failure(number.error());
  }
  const nlohmann::json clips = list(*project);
  if (arguments.common.json) {
    print_json({{"project", project->folder.string()}, {"clips", clips}});
    return kExitDone;
  }
  for (const nlohmann::json& clip : clips) {
    const nlohmann::json& to = clip.at("to_s");
    const std::string words =
        seconds_words({clip.at("from_s").get<double>(), to.is_null() ? 0 : to.get<double>()});
    fmt::print("{:>3}  {}{}{}  {}\n", clip.at("number").get<int>(), clip.at("video").get<std::string>(),
               words.empty() ? "" : " ", words, clip.at("message").get<std::string>());
  }
  if (arguments.remove || !arguments.add.empty())
    tell("To make the avatar from these clips: likeness train {}\n", project->folder.string());
  return kExitDone;
}

}  // namespace

void add_clips_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<ClipsArguments>();
  CLI::App* clips = program.add_subcommand(
      "clips", "The clips of a project; further ones of the same person show what the first did not");
  clips->add_option("project", a->project, "Project folder")->required();
  CLI::Option* add = clips->add_option("--add", a->add, "Another clip of the same person");
  clips->add_option("--from", a->from_s, "Second of that clip to begin with; default: its start")->needs(add);
  clips->add_option("--to", a->to_s, "Second of that clip to end with; default: its end")->needs(add);
  add_camera_kind_option(*clips, a->camera)->needs(add);
  add_resting_flag(*clips, a->camera)->needs(add);
  clips->add_option("--remove", a->remove, "Remove the clip with this number, and what was made of it")
      ->check(CLI::Range(kFirstFurtherClip, 1'000'000));
  add_common_options(*clips, a->common);
  clips->callback([a, &exit_code] { exit_code = run_clips(*a); });
}

}  // namespace likeness::app
