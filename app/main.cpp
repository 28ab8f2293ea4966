// likeness: the command line. Exit codes: 0 done, 1 failed (reason and remedy on stderr), 2 usage, 130
// stopped.
#include <exception>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/commands.h"
#include "app/terminal.h"

int main(int argc, char** argv) {
  using namespace likeness::app;
  CLI::App program{"Likeness: from a phone video of a person to a head avatar that can be directed.",
                   "likeness"};
  program.set_version_flag("--version", LIKENESS_VERSION);
  program.require_subcommand(1);
  int exit_code = kExitDone;
  add_build_commands(program, exit_code);
  add_check_command(program, exit_code);
  add_track_command(program, exit_code);
  add_card_command(program, exit_code);
  add_care_commands(program, exit_code);
  add_eval_command(program, exit_code);
  add_render_command(program, exit_code);
  add_drive_command(program, exit_code);
  add_study_command(program, exit_code);
  add_bench_command(program, exit_code);
  add_record_command(program, exit_code);
  add_demo_command(program, exit_code);
  add_doctor_command(program, exit_code);
  stop_on_signals();  // from here on Ctrl-C ends work between two steps, with a message
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? kExitDone : kExitUsage;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr,
               "There is not enough memory for this.\nClose other programs, or use a smaller --size.\n");
    return kExitFailed;
  } catch (const std::exception& error) {
    fmt::print(
        stderr,
        "Likeness met an error it did not expect: {}\nPlease report it together with the clip's details.\n",
        error.what());
    return kExitFailed;
  }
  return exit_code;
}
