// Command-line plumbing: see terminal.h.
#include "app/terminal.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <thread>

#include <fmt/format.h>

#include "core/base/json_text.h"
#include "core/base/unfinished.h"
#include "core/project/option_table.h"

namespace likeness::app {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kLogEvery(30);

int signal_pipe[2] = {-1, -1};

// A fourth one ends the process where it stands. A terminal that closes says so twice, the shell and the
// system.
extern "C" void on_signal(int number) {
  static volatile sig_atomic_t seen = 0;
  if (number == SIGHUP && seen > 0) return;
  if (seen > 1) ::signal(number, SIG_DFL);
  seen = seen + 1;
  const auto byte = static_cast<unsigned char>(number);  // async-signal-safe: wakes the waiting thread
  [[maybe_unused]] const auto written = ::write(signal_pipe[1], &byte, 1);
}

int next_signal() {
  unsigned char number = 0;
  while (::read(signal_pipe[0], &number, 1) < 0 && errno == EINTR) {
  }
  return number;
}

// With the second one nothing is finished, but nothing half-written stays either.
void await_signals(std::stop_source& source) {
  // timeout and its like send theirs to the process and to its group: that is one.
  constexpr std::chrono::milliseconds kSame(300);
  next_signal();
  source.request_stop();
  const Clock::time_point first = Clock::now();
  int last = next_signal();
  while (Clock::now() - first < kSame) last = next_signal();
  remove_unfinished();
  ::signal(last, SIG_DFL);
  ::kill(::getpid(), last);
}

std::string duration_text(double seconds) {
  const int s = int(seconds + 0.5);
  if (s < 90) return fmt::format("{} s", s);
  if (s < 5400) return fmt::format("{} min", (s + 30) / 60);
  return fmt::format("{} h {} min", s / 3600, s % 3600 / 60);
}

}  // namespace

void add_quality_option(CLI::App& verb, RenderQuality& quality) {
  verb.add_option("--quality", quality, "final, or preview: faster and a little softer")
      ->transform(CLI::CheckedTransformer(std::map<std::string, RenderQuality>{
          {kRenderQualities[0], RenderQuality::final}, {kRenderQualities[1], RenderQuality::preview}}));
}

void add_mode_option(CLI::App& verb, std::optional<FieldMode>& mode) {
  std::vector<std::string> names{"auto"};
  for (const FieldMode known : kFieldModes) names.emplace_back(mode_name(known));
  verb.add_option_function<std::string>(
          "--mode", [&mode](const std::string& name) { mode = mode_named(name); }, option_row("mode").help)
      ->check(CLI::IsMember(std::move(names)));
}

void add_common_options(CLI::App& verb, CommonOptions& options) {
  verb.add_flag("--json", options.json, "Print the result as JSON on stdout");
  verb.add_option("--threads", options.threads, "Threads to use (0: all)")->check(CLI::Range(0, 1024));
  const auto processor_only = [](const std::string& value) {
    return value == "cpu"
               ? std::string()
               : "this verb computes on the processor (cpu); build, train, render, drive, eval and "
                 "bench can use cuda";
  };
  verb.add_option("--backend", options.backend, "Where to compute")
      ->check(CLI::Validator(processor_only, "{cpu}"));
  const OptionRow& seed = option_row("seed");
  if (verb.get_option_no_throw(seed.flag) == nullptr) verb.add_option(seed.flag, options.seed, seed.help);
}

int report_failure(const Error& error, StoppedWork stopped) {
  const bool lost = error.code == ErrorCode::cancelled && stopped == StoppedWork::lost;
  const std::string& fix = lost ? "The same command starts over from the beginning." : error.fix;
  tell("{}\n", error.what);
  if (!fix.empty()) tell("{}\n", fix);
  return error.code == ErrorCode::cancelled ? kExitStopped : kExitFailed;
}

void print_json(const nlohmann::json& value) {
  // A path need not be valid UTF-8; the odd byte is replaced rather than refused.
  fmt::print("{}\n", json_text(value, 2));
}

nlohmann::json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}
nlohmann::json finite_or_null(const std::optional<double>& value) {
  return value ? finite_or_null(*value) : nlohmann::json(nullptr);
}

struct ProgressLine::State {
  bool terminal = false;
  Clock::time_point start = Clock::now(), drawn{};
  double start_fraction = -1;
  std::string stage;
  std::set<std::string> said;  // stages and texts, without numbers

  // Into a file: each stage, what is said in it once for all numbers it is said with, and where it is, twice
  // a minute.
  void log(const ProgressReport& report, Clock::time_point now) {
    if (report.stage != stage && !report.stage.empty()) tell("{} ...\n", report.stage);
    stage = report.stage;
    std::string kind = report.text;
    std::erase_if(kind, [](unsigned char c) { return std::isdigit(c) != 0; });
    const bool is_new = !kind.empty() && said.insert(stage + "\n" + kind).second;
    if (drawn == Clock::time_point{}) drawn = now;
    if (!is_new && now - drawn < kLogEvery) return;
    drawn = now;
    tell("{:3.0f} %  {}  {}\n", 100 * report.fraction, stage, visible(report.text));
  }

  void show(const ProgressReport& report) {
    const auto now = Clock::now();
    if (start_fraction < 0 || report.stage != stage) {
      // The rate of one stage says nothing about another's.
      start = now;
      start_fraction = report.fraction;
    }
    if (!terminal) return log(report, now);
    const bool same_stage = report.stage == stage;
    stage = report.stage;
    if (same_stage && now - drawn < std::chrono::milliseconds(100)) return;
    drawn = now;
    const double elapsed = std::chrono::duration<double>(now - start).count(),
                 gained = report.fraction - start_fraction;
    std::string left;
    if (elapsed > 5 && gained > 0.005)
      left = "  about " + duration_text(elapsed / gained * (1 - report.fraction)) + " left";
    tell_text(
        fmt::format("\r\033[K{:3.0f} %  {}  {}{}", 100 * report.fraction, stage, visible(report.text), left));
  }
};

ProgressLine::ProgressLine(const CommonOptions& options) : state_(std::make_shared<State>()) {
  if (options.json) return;
  state_->terminal = ::isatty(STDERR_FILENO) != 0;
  progress_ = Progress([state = state_](const ProgressReport& report) { state->show(report); });
}

ProgressLine::~ProgressLine() {
  if (state_->terminal) clear_line();
}

std::stop_token stop_on_signals() {
  static std::stop_source source;
  static const bool installed = [] {
    if (::pipe2(signal_pipe, O_CLOEXEC) != 0) return false;
    std::thread([] { await_signals(source); }).detach();
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
    // A terminal that was closed; nohup ignores it.
    struct sigaction hung_up {};
    if (::sigaction(SIGHUP, nullptr, &hung_up) == 0 && hung_up.sa_handler != SIG_IGN)
      ::sigaction(SIGHUP, &action, nullptr);
    return true;
  }();
  (void)installed;
  return source.get_token();
}

}  // namespace likeness::app
