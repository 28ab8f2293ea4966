// likeness bench: how fast the field's kernels are, compared with what the machine can do, and how exact; for
// a project, what its pictures and its training cost, setting by setting, and how soon a live drive shows.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/backend_option.h"
#include "app/bench_tables.h"
#include "app/commands.h"
#include "app/device_bench.h"
#include "app/project_speed_report.h"
#include "app/tables.h"
#include "app/terminal.h"
#include "core/base/json_text.h"
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
  TableOptions output;
  BenchOptions options;
  std::filesystem::path project, clip;  // empty: the field alone; not driven live
  int frames = 12;                      // of the settings
  LiveStudyOptions live;
};

const std::vector<std::string> kBenchTables{"field", "project", "settings", "live"};

struct FullReport {
  std::optional<BenchReport> field;
  std::optional<ProjectSpeed> project;
  std::vector<Table> more;  // settings, live
};

double gather_mps(const Ceilings& c) { return 1e-6 / gather_seconds(c, kFieldTable); }
double rmw_mps(const Ceilings& c) { return 1e-6 / read_modify_write_seconds(c, kFieldTable); }

// Why the figures should not be quoted; empty: they can be.
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

// For one precision: speeds of the largest batch by threads, and errors.
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

nlohmann::json to_json(const BenchReport& report) {
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
          {"kernels", kernels_json(report)}};
}

nlohmann::json to_json(const FullReport& full) {
  nlohmann::json all = full.field ? to_json(*full.field) : nlohmann::json::object();
  if (full.field || full.project)
    all["project"] = full.project ? project_speed_json(*full.project) : nlohmann::json(nullptr);
  all.update(parse_json(tables_json(full.more)));
  return all;
}

// -- Tables

Table ceilings_table(const BenchReport& report) {
  const Processor processor = this_processor();
  Table table{.name = "ceilings", .title = fmt::format("{}, {}", processor.name, processor.instruction_set)};
  table.columns = {{"threads", "threads", 0},           {"fma_gflops", "FMA, GFLOP/s", 1},
                   {"bf16_gflops", "bf16, GFLOP/s", 1}, {"bandwidth_gbs", "memory, GB/s", 1},
                   {"gather_mps", "reads, M/s", 0},     {"rmw_mps", "updates, M/s", 0}};
  for (const ThreadSpeed& t : report.threads)
    table.rows.push_back({t.ceilings.threads, t.ceilings.fma_gflops, t.ceilings.bf16_gflops,
                          t.ceilings.bandwidth_gbs, gather_mps(t.ceilings), rmw_mps(t.ceilings)});
  table.notes = {"reads and updates of 8-byte entries at random places of 512 KB"};
  return table;
}

Table passes_table(const BenchReport& report) {
  Table table{.name = "passes"};
  table.columns = {{"threads", "threads", 0},
                   {"samples", "batch", 0},
                   {"pass", "pass"},
                   {"samples_per_s", "samples/s", 0},
                   {"ns_per_sample", "ns/sample", 1},
                   {"gflops", "GFLOP/s", 1},
                   {"floor_ns_per_sample", "floor, ns", 1},
                   {"fraction_of_floor", "of floor"}};
  for (const ThreadSpeed& t : report.threads)
    for (const BatchSpeed& b : t.batches) {
      const auto add = [&](const char* pass, const PassSpeed& s) {
        table.rows.push_back({t.ceilings.threads, double(b.samples), pass, 1e6 * s.msamples_s,
                              s.ns_per_sample, s.gflops, s.floor_ns_per_sample, s.fraction_of_floor});
      };
      add("forward", b.single.inference), add("training", b.single.training);
      if (b.bf16) add("forward bf16", b.bf16->inference), add("training bf16", b.bf16->training);
    }
  return table;
}

Table errors_table(const BenchReport& report) {
  Table table{.name = "errors", .title = "Relative L2 against double"};
  table.columns = {{"precision", "precision"},
                   {"outputs", "outputs", -1},
                   {"network_gradients", "gradients of networks", -1},
                   {"table_gradients", "of tables", -1},
                   {"adam", "Adam", -1}};
  const auto add = [&](const char* precision, const FieldError& e) {
    table.rows.push_back({precision, e.outputs, e.networks, e.tables, e.adam});
  };
  add("single", report.error);
  if (report.bf16_error) add("bf16", *report.bf16_error);
  return table;
}

std::vector<Table> bench_tables(const FullReport& full) {
  std::vector<Table> tables;
  if (full.field)
    tables = {ceilings_table(*full.field), passes_table(*full.field), errors_table(*full.field)};
  if (full.field)
    if (const std::string why = doubt(*full.field); !why.empty())
      tables.back().notes.push_back("These figures do not count. " + why);
  if (full.project) tables.push_back(project_speed_table(*full.project));
  tables.insert(tables.end(), full.more.begin(), full.more.end());
  return tables;
}

// -- Measuring

// Measures a GPU, whose batches are larger.
int run_cuda(const BenchArguments& arguments, bool batches_given) {
  DeviceBenchOptions options;
  if (batches_given) options.batches = arguments.options.batches;
  options.rounds = std::max(options.rounds, arguments.options.rounds);
  options.seed = std::uint32_t(arguments.common.seed) + 1;
  const ThreadLimit limit(arguments.common.threads);
  if (arguments.project.empty())
    return run_device_bench(arguments.common, arguments.output, options, nullptr);
  const auto project = open_project(arguments.project);
  if (!project) return report_failure(project.error());
  return run_device_bench(arguments.common, arguments.output, options, &*project);
}

bool is_asked_of_the_gpu(const BenchArguments& a) {
  return (is_asked(a.output, "field") || is_asked(a.output, "project")) &&
         (a.common.backend == "cuda" || (a.common.backend == "auto" && open_cuda_device().ok()));
}

Result<void> check_arguments(const BenchArguments& a) {
  const bool live = is_asked(a.output, "live");
  if (live == a.clip.empty())
    return Error{
        ErrorCode::bad_input,
        live ? "No clip is given to drive the avatar." : "A clip is only for driving an avatar live.",
        "likeness bench PROJECT --tables live --clip CLIP", ""};
  if (live && a.common.backend == "cuda")
    return Error{ErrorCode::bad_input, "An avatar is driven live on the processor.", "Leave out --backend.",
                 ""};
  if (is_asked_of_the_gpu(a) && (live || is_asked(a.output, "settings")))
    return Error{ErrorCode::bad_input, "A GPU's field and pictures are measured separately.",
                 "Ask for the other tables in a second call.", ""};
  if (!a.project.empty()) return {};
  for (const std::string& name : a.output.tables)
    if (name != "field")
      return Error{ErrorCode::bad_input, fmt::format("There is no project for the table {}.", name),
                   fmt::format("likeness bench PROJECT --tables {}", name), ""};
  return {};
}

Result<FullReport> measure(const BenchArguments& a, int all) {
  const std::vector<std::string>& tables = a.output.tables;
  std::optional<Project> project;  // opened first: a wrong folder is reported before minutes are spent
  if (!a.project.empty()) {
    auto opened = open_project(a.project);
    if (!opened) return opened.error();
    project = std::move(*opened);
  }
  const ProgressLine line(quiet_if_csv(a.common, a.output));
  const std::stop_token stop = stop_on_signals();
  FullReport full;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const double n = double(tables.size());
    const Progress progress = line.progress().stage(double(i) / n, double(i + 1) / n, tables[i]);
    if (tables[i] == "field") {
      auto field = measure_field(a.options, progress, stop);
      if (!field) return field.error();
      full.field = std::move(*field);
      continue;
    }
    const ThreadLimit limit(all);
    if (tables[i] == "project") {
      const auto speed = measure_project_speed(*project, {}, progress, stop);
      if (!speed) return speed.error();
      full.project = *speed;
      continue;
    }
    const auto table = [&]() -> Result<Table> {
      if (tables[i] == "live") return live_table(a.project, a.clip, a.live, progress, stop);
      auto place = chosen_place(a.common);
      if (!place) return place.error();
      return settings_table(*project, a.frames, place->backend, progress, stop);
    }();
    if (!table) return table.error();
    full.more.push_back(*table);
  }
  return full;
}

int run(BenchArguments arguments) {
  const int all = arguments.common.threads > 0 ? arguments.common.threads : hardware_threads();
  arguments.options.threads = {1};
  if (all > 1) arguments.options.threads.push_back(all);
  arguments.options.seed = std::uint32_t(arguments.common.seed) + 1;
  std::sort(arguments.options.batches.begin(), arguments.options.batches.end());
  const auto report = measure(arguments, all);
  if (!report) return report_failure(report.error());
  const ThreadLimit limit(all);
  const nlohmann::json json = to_json(*report);
  return report_tables(arguments.common, arguments.output, bench_tables(*report), &json);
}

// The default tables: the field; with a project its pictures and training, too; with a clip live driving
// only.
void choose_tables(BenchArguments& a) {
  if (!a.output.tables.empty()) return;
  if (!a.clip.empty())
    a.output.tables = {"live"};
  else if (a.project.empty())
    a.output.tables = {"field"};
  else
    a.output.tables = {"field", "project"};
}

}  // namespace

void add_bench_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<BenchArguments>();
  CLI::App* verb = program.add_subcommand(
      "bench",
      "How fast the field's kernels are, compared with what the machine can do, and how exact; and what a "
      "project's pictures cost");
  verb->add_option("project", a->project,
                   "A project with an avatar: its pictures and its training are measured, too; not changed");
  add_tables_option(*verb, a->output, kBenchTables,
                    "default: field and, of a project, project; settings: what the renderer's settings cost "
                    "and lose; live: how soon the avatar follows a clip fed in real time");
  verb->add_option("--frames", a->frames, "Held-out frames of the settings, evenly chosen; 0: all")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  verb->add_option("--clip", a->clip, "The clip that drives the avatar live");
  add_quality_option(*verb, a->live.quality);
  verb->add_option("--landmark-model", a->live.track.predictor,
                   "For driving live: network, dlib, or a dlib 68-point shape predictor");
  verb->add_option("--batch", a->options.batches, "Samples of a batch; several are measured each")
      ->check(CLI::Range(64, 1 << 22));
  verb->add_option("--rounds", a->options.rounds,
                   "Repetitions, of which the best counts; more if others use the machine")
      ->check(CLI::Range(1, 1000));
  add_common_options_with_cuda(*verb, a->common);
  add_table_options(*verb, a->output);
  verb->callback([a, verb, &exit_code] {
    choose_tables(*a);
    if (const auto fine = check_arguments(*a); !fine)
      exit_code = report_failure(fine.error());
    else
      exit_code = is_asked_of_the_gpu(*a) ? run_cuda(*a, verb->count("--batch") > 0) : run(*a);
  });
}

}  // namespace likeness::app
