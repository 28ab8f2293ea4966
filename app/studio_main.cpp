// likeness-studio: the window. Exit codes as for the command line: 0 done, 1 failed, 2 usage.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "app/manual.h"
#include "app/names_like_options.h"
#include "app/standard_streams.h"
#include "core/base/parallel.h"
#include "core/device/load_device.h"
#include "ui/run_window.h"

namespace {

likeness::app::ManualText manual_text() {
  return {.version = LIKENESS_VERSION,
          .summary = "a window that leads from a phone video to a directed head avatar",
          .description =
              {"The studio leads in seven steps from a clip to an avatar that can be directed and exported. "
               "Every setting has a value that works; F1 lists the keys.",
               "It draws with OpenGL 3.3, on the processor if there is no graphics card, and computes as "
               "likeness(1) does: nothing leaves the computer."},
          .exit_codes = {{"0", "The window was closed."},
                         {"1", "Failed: what happened, and what to do, is on standard error."},
                         {"2", "The command line was not understood."}},
          .files = {{"~/Likeness", "New projects and recorded clips; --projects names another."},
                    {"~/.config/likeness/studio.json", "The window's settings."}},
          .see_also = {"likeness(1)"}};
}

// The device opened here only shows that there is one; each thread that computes opens its own.
likeness::Result<likeness::ui::ComputePlace> compute_place(const std::string& backend) {
  using namespace likeness;
  ui::ComputePlace place;
  if (backend == "cpu") return place;
  place.fall_back = backend == "auto";
  if (const auto device = open_cuda_device(); !device)
    return place.fall_back ? Result<ui::ComputePlace>(place) : device.error();
  place.open = []() -> Result<std::shared_ptr<Backend>> {
    auto device = open_cuda_device();
    if (!device) return device.error();
    return device_backend(std::move(*device));
  };
  return place;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace likeness;
  app::open_standard_streams();
  CLI::App program{"Likeness studio: from a phone video to a head avatar, in a window.", "likeness-studio"};
  program.set_version_flag("--version", LIKENESS_VERSION);
  app::add_manual_flag(program, manual_text());
  ui::StudioOptions options;
  options.settings = ui::settings_path();
  std::filesystem::path to_open;
  int threads = 0;
  program.add_option("open", to_open,
                     "A clip or a project to open: its folder, or the project.json or avatar.bin in it");
  program.add_option("--projects", options.projects,
                     "Folder of new projects; default: as chosen in the window, at first ~/Likeness");
  program.add_option("--threads", threads, "Threads to compute with; 0: all");
  std::string backend = "cpu";
  program
      .add_option("--backend", backend,
                  "Where to train and to render what is directed: cpu, cuda (an NVIDIA GPU), or auto: the "
                  "GPU if it can be used, otherwise or if it fails the processor")
      ->check(CLI::IsMember({"cpu", "cuda", "auto"}));
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (program.exit(error) == 0) return 0;
    app::tell_names_like_options(argc, argv);
    return 2;
  }
  if (options.projects.empty()) options.projects = ui::read_settings(options.settings).projects;
  if (options.projects.empty()) options.projects = ui::projects_folder();
  if (options.projects.empty()) {
    app::tell(
        "There is no home folder for you here, in which new projects would go.\nSet HOME, or name a folder: "
        "likeness-studio --projects FOLDER\n");
    return 1;
  }
  const ThreadLimit limit(threads);
  auto place = compute_place(backend);
  if (!place) {
    app::tell("{}\n{}\n", place.error().what, place.error().fix);
    return 1;
  }
  options.compute = std::move(*place);
  Result<void> outcome;
  if (const auto guarded = ui::guard_window([&] { outcome = ui::run_window(options, to_open); }); !guarded)
    outcome = guarded;
  if (outcome) return 0;
  app::tell("{}\n{}\n", outcome.error().what, outcome.error().fix);
  return 1;
}
