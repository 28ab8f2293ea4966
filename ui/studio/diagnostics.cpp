// See diagnostics.h.
#include "ui/studio/diagnostics.h"

#include <fmt/format.h>

#include "core/base/memory.h"
#include "core/base/parallel.h"
#include "core/network/installed_networks.h"
#include "ui/platform/settings.h"

namespace likeness::ui {

std::string diagnostics_text(const std::optional<Error>& error, const ProjectContents* contents) {
  std::string text =
      fmt::format("Likeness studio\nthreads {}\nmemory in use {} MiB, free {} MiB\n", current_thread_limit(),
                  memory_in_use() >> 20, available_memory().value_or(0) >> 20);
  for (const InstalledNetworkFile& network : installed_network_files()) {
    const auto found = find_installed_network(network.network);
    text += found ? fmt::format("network {}\n", found->string()) : found.error().what + "\n";
  }
  if (error)
    text += fmt::format("last error: {}\nremedy: {}\nwhere: {}\n", error->what, error->fix, error->where);
  if (!contents) return text;
  const Project& p = contents->project;
  text += fmt::format("picture size {} px, budget {} s, steps {}\n", p.options.import.size,
                      p.options.train.budget_s, p.options.train.steps);
  for (const Stage stage : kStages) {
    const StageRecord& record = p.record(stage);
    text += fmt::format("{}: {} {:.1f} s, {}\n", stage_name(stage),
                        contents->is_current(stage) ? "current" : "stale", record.seconds, record.message);
    for (const std::string& warning : record.warnings) text += "  note: " + warning + "\n";
  }
  return text;
}

}  // namespace likeness::ui
