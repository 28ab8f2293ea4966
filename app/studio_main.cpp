// likeness-studio: the window. Exit codes as the command line's: 0 done, 1 failed, 2 usage.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "core/base/parallel.h"
#include "ui/run_window.h"

int main(int argc, char** argv) {
  using namespace likeness;
  CLI::App program{"Likeness studio: from a phone video to a head avatar, in a window.", "likeness-studio"};
  program.set_version_flag("--version", LIKENESS_VERSION);
  ui::StudioOptions options;
  options.settings = ui::settings_path();
  options.projects = ui::projects_folder();
  std::filesystem::path to_open;
  int threads = 0;
  program.add_option("open", to_open, "A clip or a project folder to open");
  program.add_option("--projects", options.projects, "Folder of new projects");
  program.add_option("--threads", threads, "Threads to compute with; 0: all");
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : 2;
  }
  const ThreadLimit limit(threads);
  const auto outcome = ui::run_window(options, to_open);
  if (outcome) return 0;
  fmt::print(stderr, "{}\n{}\n", outcome.error().what, outcome.error().fix);
  return 1;
}
