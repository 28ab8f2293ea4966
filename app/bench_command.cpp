// likeness bench: how fast the field's kernels are, beside what the machine can do and how exact they are.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/backend_option.h"
#include "app/commands.h"
#include "app/device_bench.h"
#include "app/project_speed_report.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/device/load_device.h"
#include "core/lab/bench/field_speed.h"
#include "core/lab/bench/processor.h"
#include "core/lab/bench/project_speed.h"
#include "core/project/project.h"

namespace likeness::app {

namespace {

constexpr std::size_t kFieldTable = std::size_t{1} << 19;  // of a fine level of the standard field
constexpr double kQuiet = 0.9;

struct BenchArguments {
  CommonOptions common;
  BenchOptions options;
  std::filesystem::path project;  // empty: the field alone
};

struct FullReport {
  BenchReport field;
  std::optional<ProjectSpeed> project;
};

double gather_mps(const Ceilings& c) { return 1e-6 / gather_seconds(c, kFieldTable); }
double rmw_mps(const Ceilings& c) { return 1e-6 / read_modify_write_seconds(c, kFieldTable); }

// Why the figures should not be quoted; empty when nothing speaks against it.
std::string doubt(const BenchReport& report) {
  if (report.processor_share < kQuiet)
    return fmt::format("Other programs use this machine: a busy thread got {:.0f} % of a processor.",
                       100 * report.processor_share);
  const auto known = known_ceilings();
  const Ceilings& one = report.threads.front().ceilings;
  if (known && one.threads == 1 && share_of_known(one, *known) < kUsualShare)
    return fmt::format("The ceilings are {:.0f} % of those known of {}: throttled, shared or emulated.",
                       100 * share_of_known(one, *known), known->processor);
  return "";
}

// -- JSON

nlohmann::json to_json(const Ceilings& c) {
  nlohmann::json tables = nlohmann::json::array();
  for (const TableRate& t : c.tables)
    tables.push_back(
        {{"bytes", t.bytes}, {"gather_mps", t.gather_mps}, {"rmw_mps", t.read_modify_write_mps}});
  return {{"fma_gflops", c.fma_gflops},
          {"bf16_gflops", c.bf16_gflops > 0 ? nlohmann::json(c.bf16_gflops) : nlohmann::json(nullptr)},
          {"bandwidth_gbs", c.bandwidth_gbs},
          {"tables", tables},
          {"gather_mps", gather_mps(c)},
          {"rmw_mps", rmw_mps(c)}};
}

nlohmann::json to_json(const PassSpeed& s) {
  return {{"msamples_s", s.msamples_s},
          {"samples_s", 1e6 * s.msamples_s},
          {"ns_per_sample", s.ns_per_sample},
          {"gflops", s.gflops},
          {"floor_ns_per_sample", s.floor_ns_per_sample},
          {"fraction_of_floor", s.fraction_of_floor}};
}

const StepSpeed& speed_of(const BatchSpeed& b, FieldPrecision precision) {
  return precision == FieldPrecision::bf16 ? *b.bf16 : b.single;
}

// By number of threads: one figure of the largest batch.
nlohmann::json by_threads(const BenchReport& report, FieldPrecision precision, PassSpeed StepSpeed::*pass,
                          double PassSpeed::*figure) {
  nlohmann::json values = nlohmann::json::object();
  for (const ThreadSpeed& t : report.threads)
    values[std::to_string(t.ceilings.threads)] = speed_of(t.batches.back(), precision).*pass.*figure;
  return values;
}

// What there is of each precision: speeds of the largest batch by threads, and errors.
nlohmann::json precision_json(const BenchReport& report, FieldPrecision precision, const FieldError& e) {
  const auto figures = [&](PassSpeed StepSpeed::*pass, double PassSpeed::*figure) {
    return by_threads(report, precision, pass, figure);
  };
  return {{"forward_msamples_s", figures(&StepSpeed::inference, &PassSpeed::msamples_s)},
          {"train_msamples_s", figures(&StepSpeed::training, &PassSpeed::msamples_s)},
          {"forward_fraction_of_floor", figures(&StepSpeed::inference, &PassSpeed::fraction_of_floor)},
          {"train_fraction_of_floor", figures(&StepSpeed::training, &PassSpeed::fraction_of_floor)},
          {"rel_l2",
           {{"outputs", e.outputs},
            {"network_gradients", e.networks},
            {"table_gradients", e.tables},
            {"adam", e.adam},
            {"samples_left_out", e.left_out}}}};
}

nlohmann::json batches_json(const BenchReport& report) {
  nlohmann::json list = nlohmann::json::array();
  for (const ThreadSpeed& t : report.threads)
    for (const BatchSpeed& b : t.batches) {
      nlohmann::json bf16;
      if (b.bf16) bf16 = {{"forward", to_json(b.bf16->inference)}, {"train", to_json(b.bf16->training)}};
      list.push_back({{"threads", t.ceilings.threads},
                      {"samples", b.samples},
                      {"forward", to_json(b.single.inference)},
                      {"train", to_json(b.single.training)},
                      {"bf16", bf16}});
    }
  return list;
}

// One thread, largest batch.
nlohmann::json kernels_json(const BenchReport& report) {
  const BatchSpeed& b = report.threads.front().batches.back();
  nlohmann::json kernels = nlohmann::json::array();
  const auto add = [&](const char* name, double ns, double floor_ns, double error) {
    kernels.push_back(
        {{"name", name}, {"ns_per_sample", ns}, {"fraction_of_floor", floor_ns / ns}, {"rel_l2", error}});
  };
  const auto add_passes = [&](const char* inference, const char* passes, const StepSpeed& s,
                              const FieldError& e) {
    add(inference, s.inference.ns_per_sample, s.inference.floor_ns_per_sample, e.outputs);
    add(passes, s.passes_ns, s.training.floor_ns_per_sample, std::max(e.networks, e.tables));
  };
  add_passes("inference", "passes", b.single, report.error);
  add("adam", b.single.adam_ns, b.single.adam_floor_ns, report.error.adam);
  if (b.bf16) add_passes("inference_bf16", "passes_bf16", *b.bf16, *report.bf16_error);
  return kernels;
}

nlohmann::json to_json(const FullReport& full) {
  const BenchReport& report = full.field;
  const Processor processor = this_processor();
  nlohmann::json machine = to_json(report.threads.front().ceilings);
  machine["processor"] = processor.name;
  machine["instruction_set"] = processor.instruction_set;
  machine["processor_share"] = report.processor_share;
  nlohmann::json ceilings = nlohmann::json::object();
  for (const ThreadSpeed& t : report.threads)
    ceilings[std::to_string(t.ceilings.threads)] = to_json(t.ceilings);
  machine["by_threads"] = ceilings;
  nlohmann::json field = precision_json(report, FieldPrecision::exact, report.error);
  field["forward_flops"] = report.work.forward_flops, field["train_flops"] = report.work.training_flops;
  field["batches"] = batches_json(report);
  field["bf16"] = nullptr;
  if (report.bf16_error) field["bf16"] = precision_json(report, FieldPrecision::bf16, *report.bf16_error);
  const std::string why = doubt(report);
  return {{"machine", machine},
          {"counts", why.empty()},
          {"doubt", why.empty() ? nlohmann::json(nullptr) : nlohmann::json(why)},
          {"field", field},
          {"kernels", kernels_json(report)},
          {"project", full.project ? project_speed_json(*full.project) : nlohmann::json(nullptr)}};
}

// -- Text

void print_report(const FullReport& full) {
  const BenchReport& report = full.field;
  const Processor processor = this_processor();
  fmt::print("{}, {}\n\n{:>7} {:>12} {:>13} {:>12} {:>14} {:>14}\n", processor.name,
             processor.instruction_set, "threads", "FMA GFLOP/s", "bf16 GFLOP/s", "memory GB/s", "reads M/s",
             "updates M/s");
  for (const ThreadSpeed& t : report.threads)
    fmt::print("{:>7} {:>12.1f} {:>13.1f} {:>12.1f} {:>14.0f} {:>14.0f}\n", t.ceilings.threads,
               t.ceilings.fma_gflops, t.ceilings.bf16_gflops, t.ceilings.bandwidth_gbs,
               gather_mps(t.ceilings), rmw_mps(t.ceilings));
  fmt::print(
      "(8-byte entries at random places of 512 KB)\n\n{:>7} {:>8} {:<14} {:>12} {:>10} {:>9} {:>9} {:>9}\n",
      "threads", "batch", "pass", "samples/s", "ns/sample", "GFLOP/s", "floor ns", "of floor");
  for (const ThreadSpeed& t : report.threads)
    for (const BatchSpeed& b : t.batches) {
      const auto print = [&](const char* pass, const PassSpeed& s) {
        fmt::print("{:>7} {:>8} {:<14} {:>12.0f} {:>10.1f} {:>9.1f} {:>9.1f} {:>9.2f}\n", t.ceilings.threads,
                   b.samples, pass, 1e6 * s.msamples_s, s.ns_per_sample, s.gflops, s.floor_ns_per_sample,
                   s.fraction_of_floor);
      };
      print("forward", b.single.inference), print("training", b.single.training);
      if (b.bf16) print("forward bf16", b.bf16->inference), print("training bf16", b.bf16->training);
    }
  const auto print_error = [](const char* precision, const FieldError& e) {
    fmt::print(
        "relative L2 against double{}: outputs {:.1e}, gradients of networks {:.1e} and tables {:.1e}, Adam "
        "{:.1e}\n",
        precision, e.outputs, e.networks, e.tables, e.adam);
  };
  fmt::print("\n");
  print_error("", report.error);
  if (report.bf16_error) print_error(", bf16", *report.bf16_error);
  if (full.project) print_project_speed(*full.project);
  if (const std::string why = doubt(report); !why.empty())
    fmt::print("These figures do not count. {}\n", why);
}

// Of a GPU, whose batches are larger.
int run_cuda(const BenchArguments& arguments, bool batches_given) {
  DeviceBenchOptions options;
  if (batches_given) options.batches = arguments.options.batches;
  options.rounds = std::max(options.rounds, arguments.options.rounds);
  options.seed = std::uint32_t(arguments.common.seed) + 1;
  const ThreadLimit limit(arguments.common.threads);
  if (arguments.project.empty()) return run_device_bench(arguments.common, options, nullptr);
  const auto project = open_project(arguments.project);
  if (!project) return report_failure(project.error());
  return run_device_bench(arguments.common, options, &*project);
}

int run(BenchArguments arguments) {
  const int all = arguments.common.threads > 0 ? arguments.common.threads : hardware_threads();
  arguments.options.threads = {1};
  if (all > 1) arguments.options.threads.push_back(all);
  arguments.options.seed = std::uint32_t(arguments.common.seed) + 1;
  std::sort(arguments.options.batches.begin(), arguments.options.batches.end());
  const Result<FullReport> report = [&]() -> Result<FullReport> {
    std::optional<Project> project;  // a wrong folder is said before minutes are spent
    if (!arguments.project.empty()) {
      auto opened = open_project(arguments.project);
      if (!opened) return opened.error();
      project = std::move(*opened);
    }
    const ProgressLine line(arguments.common);
    const Progress progress = line.progress();
    const std::stop_token stop = stop_on_signals();
    auto field = measure_field(arguments.options, progress.stage(0, project ? 0.5 : 1, "field"), stop);
    if (!field) return field.error();
    FullReport full{std::move(*field), std::nullopt};
    if (!project) return full;
    const ThreadLimit limit(all);
    const auto speed = measure_project_speed(*project, {}, progress.stage(0.5, 1, "project"), stop);
    if (!speed) return speed.error();
    full.project = *speed;
    return full;
  }();
  if (!report) return report_failure(report.error());
  if (arguments.common.json) {
    print_json(to_json(*report));
  } else {
    print_report(*report);
  }
  return kExitDone;
}

}  // namespace

void add_bench_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<BenchArguments>();
  CLI::App* verb = program.add_subcommand(
      "bench", "How fast the field's kernels are, beside what the machine can do and how exact they are");
  verb->add_option("project", a->project,
                   "A project with an avatar: its pictures and its training are measured, too; not changed");
  verb->add_option("--batch", a->options.batches, "Samples of a batch; several are measured each")
      ->check(CLI::Range(64, 1 << 22));
  verb->add_option("--rounds", a->options.rounds,
                   "Repetitions, of which the best counts; more if others use the machine")
      ->check(CLI::Range(1, 1000));
  add_common_options_with_cuda(*verb, a->common);
  verb->callback([a, verb, &exit_code] {
    const bool cuda = a->common.backend == "cuda" || (a->common.backend == "auto" && open_cuda_device().ok());
    exit_code = cuda ? run_cuda(*a, verb->count("--batch") > 0) : run(*a);
  });
}

}  // namespace likeness::app
