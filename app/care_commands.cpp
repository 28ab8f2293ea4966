// likeness relink: a project's clip at its new place. likeness repair: a damaged project.json made again.
// likeness delete: everything made of a person.
#include <memory>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/project/care.h"
#include "core/project/damaged_project.h"

namespace likeness::app {

namespace {

struct CareArguments {
  CommonOptions common;
  std::filesystem::path project, clip;
  bool yes = false, keep_exports = false;
};

int run_relink(const CareArguments& arguments) {
  const auto project = relink_clip(arguments.project, arguments.clip);
  if (!project) return report_failure(project.error());
  if (arguments.common.json) {
    print_json({{"project", project->folder.string()}, {"video", project->options.shared.video.string()}});
  } else {
    tell("The project's clip is now {}.\n", project->options.shared.video.string());
  }
  return kExitDone;
}

int run_repair(const CareArguments& arguments) {
  const bool damaged = find_damaged_project(arguments.project).has_value();
  const auto project = repair_project(arguments.project);
  if (!project) return report_failure(project.error());
  if (arguments.common.json) {
    print_json({{"project", project->folder.string()},
                {"repaired", damaged},
                {"video", project->options.shared.video.string()}});
  } else if (!damaged) {
    tell("The project is whole: nothing was changed.\n");
  } else {
    tell(
        "The project is repaired. Its clip: {}.\nOther choices are the defaults again: look through "
        "them before the next run.\n",
        project->options.shared.video.empty() ? "not known; name it with likeness relink"
                                              : project->options.shared.video.string());
  }
  return kExitDone;
}

int run_delete(const CareArguments& arguments) {
  if (!arguments.yes) {
    const auto project = open_project(arguments.project, Links::ignored);
    if (!project && !find_damaged_project(arguments.project)) return report_failure(project.error());
    return report_failure(
        {ErrorCode::bad_input,
         fmt::format(
             "This removes frames, masks, tracks, checkpoints, performances{} and the avatar in {}, for "
             "good. The clip stays.",
             arguments.keep_exports ? "" : ", exports", arguments.project.string()),
         "Run it again with --yes if that is what you want.", ""});
  }
  const auto deleted = delete_person(arguments.project, arguments.keep_exports);
  if (!deleted) return report_failure(deleted.error());
  if (arguments.common.json) {
    nlohmann::json clips = nlohmann::json::array();
    for (const std::filesystem::path& clip : deleted->clips) clips.push_back(clip.string());
    print_json({{"bytes", deleted->bytes},
                {"folder_gone", deleted->folder_gone},
                {"kept", deleted->kept},
                {"clips", clips}});
    return kExitDone;
  }
  tell("{}\n", deletion_words(*deleted));
  return kExitDone;
}

}  // namespace

void add_care_commands(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<CareArguments>();
  CLI::App* relink = program.add_subcommand("relink", "Say where a project's clip is after it moved");
  relink->add_option("project", a->project, "Project folder")->required();
  relink->add_option("clip", a->clip, "The same clip at its new place")->required();
  add_common_options(*relink, a->common);
  relink->callback([a, &exit_code] { exit_code = run_relink(*a); });

  CLI::App* repair = program.add_subcommand(
      "repair", "Make a project's damaged project.json again from what is in its folder");
  repair->add_option("project", a->project, "Project folder")->required();
  add_common_options(*repair, a->common);
  repair->callback([a, &exit_code] { exit_code = run_repair(*a); });

  CLI::App* remove = program.add_subcommand("delete", "Delete a person: all that was made of their clip");
  remove->add_option("project", a->project, "Project folder")->required();
  remove->add_flag("--yes", a->yes, "Really; without it nothing is removed");
  remove->add_flag("--keep-exports", a->keep_exports, "Keep the films, pictures and meshes in exports/");
  add_common_options(*remove, a->common);
  remove->callback([a, &exit_code] { exit_code = run_delete(*a); });
}

}  // namespace likeness::app
