// What the command line shares between verbs: common options, a progress line, error printing, stopping by
// signal.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/standard_streams.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/render/render.h"
#include "core/train/mode.h"

namespace likeness::app {

struct CommonOptions {
  bool json = false;  // machine-readable result on stdout, no progress line
  int threads = 0;    // 0 = all
  std::string backend = "cpu";
  std::uint64_t seed = 0;
};
// --seed only where the verb has none yet.
void add_common_options(CLI::App& verb, CommonOptions& options);
void add_quality_option(CLI::App& verb, RenderQuality& quality);  // --quality final | preview
// --mode auto | static | concat | ...; auto: empty.
void add_mode_option(CLI::App& verb, std::optional<FieldMode>& mode);

// What a stop leaves behind: the stages of a project go on where they were, a file is whole or absent.
enum class StoppedWork { lost, kept };
// Prints what happened and the remedy to stderr; returns the exit code (130 for a stop, 1 otherwise).
int report_failure(const Error& error, StoppedWork stopped = StoppedWork::lost);
void print_json(const nlohmann::json& value);
// What could not be measured has no number in JSON: null.
nlohmann::json finite_or_null(double value);
nlohmann::json finite_or_null(const std::optional<double>& value);

// A progress line on stderr when that is a terminal: stage, percent, time left once the rate has settled; one
// line a stage otherwise. Nothing with --json.
class ProgressLine {
 public:
  explicit ProgressLine(const CommonOptions& options);
  ~ProgressLine();
  const Progress& progress() const { return progress_; }

 private:
  struct State;
  std::shared_ptr<State> state_;
  Progress progress_;
};

// Requested by the first SIGINT, SIGTERM or SIGHUP; another SIGINT or SIGTERM, not in the same moment, ends
// the process at once, without what it was writing.
std::stop_token stop_on_signals();

}  // namespace likeness::app
