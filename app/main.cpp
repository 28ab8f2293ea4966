// likeness: the command line. Exit codes: 0 done, 1 failed (reason and remedy on stderr), 2 usage, 130
// stopped.
#include <cstdio>
#include <exception>
#include <iostream>
#include <sstream>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/commands.h"
#include "app/manual.h"
#include "app/names_like_options.h"
#include "app/standard_streams.h"
#include "app/terminal.h"
#include "core/base/fault_words.h"

namespace {

likeness::app::ManualText manual_text() {
  return {
      .version = LIKENESS_VERSION,
      .summary = "from a phone video of a person to a head avatar that can be directed",
      .description =
          {"Likeness turns one phone video of a person into a head avatar that can be directed: seen "
           "from any side, its head turned, its expression changed, and exported as video. It "
           "computes on this machine and sends nothing anywhere.",
           "A project is a folder NAME.likeness. A stopped or killed build continues with the same "
           "command; a stage whose inputs did not change is not run again."},
      .exit_codes = {{"0", "Done."},
                     {"1", "Failed: what happened, and what to do, is on standard error."},
                     {"2", "The command line was not understood."},
                     {"130", "Stopped on request; what is done of a project is kept."}},
      .files = {{"/usr/share/dlib/shape_predictor_68_face_landmarks.dat",
                 "The landmark model that is used where the face network is missing."}},
      .examples = {{"likeness check clip.mp4", "Will this clip make an avatar?"},
                   {"likeness build clip.mp4 --project me.likeness", "Make the avatar."},
                   {"likeness render me.likeness --camera orbit --out orbit.mp4", "Film it from all sides."},
                   {"likeness doctor", "What is installed, what is missing, what to do."}},
      .see_also = {"likeness-studio(1)"}};
}

// --parse-only by itself: command lines from standard input, their words separated by tabs. Prints those that
// are not understood, and why.
int judge_command_lines(CLI::App& program) {
  int exit_code = likeness::app::kExitDone;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream cells("--parse-only\t" + line);
    std::vector<std::string> words;  // last first, as the parser takes them
    for (std::string word; std::getline(cells, word, '\t');) words.insert(words.begin(), word);
    try {
      program.parse(std::move(words));
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) continue;
      fmt::print("{}\n{}\n", line, error.what());
      exit_code = likeness::app::kExitUsage;
    }
  }
  return exit_code;
}

int run(int argc, char** argv) {
  using namespace likeness::app;
  CLI::App program{"Likeness: from a phone video of a person to a head avatar that can be directed.",
                   "likeness"};
  program.set_version_flag("--version", LIKENESS_VERSION);
  add_manual_flag(program, manual_text());
  program.require_subcommand(1);
  // Not listed in the help: ends once the command line is understood, before anything is done. With it tests
  // check the commands in the pages.
  bool parse_only = false;
  program.add_flag("--parse-only", parse_only)->group("");
  program.parse_complete_callback([&parse_only] {
    if (parse_only) throw CLI::Success();
  });
  int exit_code = kExitDone;
  add_build_commands(program, exit_code);
  add_check_command(program, exit_code);
  add_track_command(program, exit_code);
  add_attribute_command(program, exit_code);
  add_card_command(program, exit_code);
  add_clips_command(program, exit_code);
  add_care_commands(program, exit_code);
  add_eval_command(program, exit_code);
  add_render_command(program, exit_code);
  add_drive_command(program, exit_code);
  add_study_command(program, exit_code);
  add_bench_command(program, exit_code);
  add_record_command(program, exit_code);
  add_demo_command(program, exit_code);
  add_doctor_command(program, exit_code);
  if (argc == 2 && std::string_view(argv[1]) == "--parse-only")
    return after_output(judge_command_lines(program));
  stop_on_signals();  // from here on Ctrl-C ends work between two steps, with a message
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (program.exit(error) == 0) return after_output(kExitDone);
    tell_names_like_options(argc, argv);
    return after_output(kExitUsage);
  }
  return after_output(exit_code);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace likeness::app;
  open_standard_streams();
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    if (likeness::lacks_memory(error)) {
      tell(
          "There is not enough memory for this.\n"
          "Close other programs, use a smaller --size, or raise this program's limit (ulimit -v).\n");
      return kExitFailed;
    }
    if (std::ferror(stdout) != 0) return after_output(kExitDone);
    tell("Likeness met an unexpected error: {}\nPlease report it together with the clip's details.\n",
         error.what());
  }
  return kExitFailed;
}
