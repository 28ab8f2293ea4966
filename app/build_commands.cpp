// likeness build|import|align|fit|train: run a project's stages, all or up to one.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>

#include <fmt/format.h>

#include "app/backend_option.h"
#include "app/commands.h"
#include "app/parts.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/camera/align.h"
#include "core/capture/capture.h"
#include "core/capture/split.h"
#include "core/head/detail_maps.h"
#include "core/head/read_person.h"
#include "core/matte/matte.h"
#include "core/project/build_forecast.h"
#include "core/project/care.h"
#include "core/project/further_clips.h"
#include "core/project/project_head_model.h"
#include "core/project/refits.h"
#include "core/project/run_stages.h"
#include "core/project/staleness.h"
#include "core/render/avatar.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct BuildArguments {
  CommonOptions common;
  fs::path input, project, out;
  ProjectOptions options;
  std::string identity;            // a file, or "none"
  std::string displacement;        // a folder, or "none"
  std::string leave_out;           // "12,40-60", or "none"
  std::vector<std::string> refit;  // each like that
  bool forecast = false;
  FieldPrecision precision = FieldPrecision::bf16;
};

// "12,40-60" -> 12 to 12 and 40 to 60; "none": nothing. option: how the user wrote it, for the remedy.
Result<std::vector<RefitSpan>> parse_spans(const std::string& text, std::string_view option) {
  const Error wrong{ErrorCode::bad_input, fmt::format("\"{}\" is no list of frames.", text),
                    fmt::format("Write numbers and spans, e.g. {} 12,40-60, or none.", option), ""};
  std::vector<RefitSpan> spans;
  if (text == "none") return spans;
  constexpr int kMostFrames = 1'000'000;
  const char *at = text.data(), *end = at + text.size();
  const auto number = [&](int& value) {
    const auto [rest, failure] = std::from_chars(at, end, value);
    at = rest;
    return failure == std::errc{} && value >= 0 && value < kMostFrames;
  };
  while (at != end) {
    RefitSpan span;
    if (!number(span.first)) return wrong;
    span.last = span.first;
    if (at != end && *at == '-' && (++at, !number(span.last) || span.last < span.first)) return wrong;
    spans.push_back(span);
    if (at != end && (*at++ != ',' || at == end)) return wrong;
  }
  if (spans.empty()) return wrong;
  return spans;
}

Result<std::vector<int>> parse_frames(const std::string& text, std::string_view option) {
  const auto spans = parse_spans(text, option);
  if (!spans) return spans.error();
  std::vector<int> frames;
  for (const RefitSpan& span : merged_spans(*spans))
    for (int frame = span.first; frame <= span.last; ++frame) frames.push_back(frame);
  return frames;
}

// The project's spans with those named on the command line; the word none takes back all before it.
Result<std::vector<RefitSpan>> asked_refits(std::vector<RefitSpan> spans,
                                            const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    const auto more = parse_spans(text, "--refit");
    if (!more) return more.error();
    if (more->empty()) spans.clear();
    spans.insert(spans.end(), more->begin(), more->end());
  }
  return merged_spans(std::move(spans));
}

// A shape that does not fit the head model is told before anything is changed.
Result<void> check_identity(const ProjectOptions& options) {
  if (options.fit.identity.empty()) return {};
  const auto model = project_head_model(options);
  if (!model) return model.error();
  const auto person = read_person(options.fit.identity, *model);
  return person ? Result<void>() : Result<void>(person.error());
}

// The same of detail maps.
Result<void> check_displacement(const ProjectOptions& options) {
  if (options.fit.displacement.empty()) return {};
  const auto model = project_head_model(options);
  if (!model) return model.error();
  const auto maps = read_detail_maps(options.fit.displacement, *model);
  return maps ? Result<void>() : Result<void>(maps.error());
}

// What a build would take, before anything is done.
int run_forecast(const BuildArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  const auto clip = probe_video(arguments.input);
  if (!clip) return report_failure(clip.error());
  const auto model = project_head_model(arguments.options);
  if (!model) return report_failure(model.error());
  const int threads = current_thread_limit();
  const BuildForecast forecast = forecast_build(*clip, arguments.options, *model, threads);
  const Resources free = free_resources(arguments.project);
  const auto fits = check_forecast(forecast, free, folder_bytes(arguments.project));
  const auto smaller = smaller_size(*clip, arguments.options, *model, threads, free);
  if (arguments.common.json) {
    nlohmann::json stages = nlohmann::json::object();
    for (const Stage stage : kStages)
      stages[std::string(stage_name(stage))] = forecast.seconds[std::size_t(stage)];
    print_json({{"frames", forecast.frames},
                {"disk_bytes", forecast.disk},
                {"memory_bytes", forecast.memory},
                {"seconds", forecast.total_seconds()},
                {"seconds_more_if_the_camera_moves", forecast.seconds_if_moving},
                {"stages", stages},
                {"fits", fits.ok()},
                {"smaller_size", smaller ? nlohmann::json(*smaller) : nlohmann::json()}});
    return kExitDone;
  }
  fmt::print("The build takes {}.\nIf the camera moves, about {:.0f} min more.\n", forecast_words(forecast),
             std::max(1.0, std::ceil(forecast.seconds_if_moving / 60)));
  if (!fits) fmt::print("{}\n{}\n", fits.error().what, fits.error().fix);
  if (smaller) fmt::print("It would fit with --size {}.\n", *smaller);
  return kExitDone;
}

nlohmann::json summary(const Project& project) {
  nlohmann::json stages = nlohmann::json::object();
  for (const Stage stage : kStages) {
    const StageRecord& record = project.record(stage);
    stages[std::string(stage_name(stage))] = {{"done", is_current(project, stage)},
                                              {"seconds", record.seconds},
                                              {"message", record.message},
                                              {"warnings", record.warnings}};
  }
  nlohmann::json summary{{"project", project.folder.string()}, {"stages", stages}};
  if (is_current(project, Stage::train))
    if (const auto avatar = read_avatar(avatar_path(project))) summary["parts"] = parts_json(avatar->parts);
  return summary;
}

int run(Project& project, Stage last, const CommonOptions& common, const ChosenBackend& backend) {
  const ThreadLimit limit(common.threads);
  RunObserver observer;
  if (!common.json) {
    observer.parts = [](const std::vector<AvatarPart>& parts) {
      fmt::print(stderr, "\r\033[K  parts of this avatar, and why\n");
      print_parts(stderr, parts);
    };
    observer.stage_changed = [](Stage stage, const StageRecord& record) {
      if (record.state != StageState::done) return;
      fmt::print(stderr, "\r\033[K{:>7}  {} ({:.0f} s)\n", stage_name(stage), record.message, record.seconds);
      for (const std::string& warning : record.warnings) fmt::print(stderr, "         note: {}\n", warning);
    };
    observer.further_changed = [](Stage stage, int number, const Project& clip) {
      const StageRecord& record = clip.record(stage);
      if (record.state != StageState::done) return;
      fmt::print(stderr, "\r\033[K{:>7}  {}: {} ({:.0f} s)\n", stage_name(stage),
                 further_clip_name(clip, number), record.message, record.seconds);
      for (const std::string& warning : record.warnings) fmt::print(stderr, "         note: {}\n", warning);
    };
  }
  Result<void> outcome;
  {
    const ProgressLine line(common);
    outcome = run_stages(project, last, line.progress(), observer, stop_on_signals(),
                         {backend.backend, backend.fall_back, backend.precision});
  }
  if (!outcome) return report_failure(outcome.error(), StoppedWork::kept);
  if (common.json) {
    print_json(summary(project));
  } else if (last == Stage::train) {
    fmt::print(stderr, "Done. Next: likeness render {} --out avatar.mp4 --camera orbit\n",
               project.folder.string());
  }
  return kExitDone;
}

// Whether this is the project's clip, perhaps moved or copied since: what was decided of it still holds.
bool is_clip_of(const Project& project, const fs::path& video) {
  std::error_code other;
  if (fs::equivalent(project.options.shared.video, video, other)) return true;
  const auto capture = read_capture(capture_path(project));
  const auto hash = hash_video(video);
  return capture && hash && capture->video_hash == *hash;
}

// A first build that fails on its clip leaves no folder behind: there is nothing in it to keep.
int run_new(const BuildArguments& arguments, Stage last) {
  const auto backend = chosen_backend(arguments.common, arguments.precision);
  if (!backend) return report_failure(backend.error());
  std::error_code unknown;
  const bool existed = fs::exists(arguments.project, unknown) || unknown;
  ProjectOptions options = arguments.options;
  options.shared.video = arguments.input;
  options.shared.seed = arguments.common.seed;
  if (const auto earlier = open_project(arguments.project);
      earlier && is_clip_of(*earlier, options.shared.video))
    options.train.left_out = earlier->options.train.left_out,
    options.fit.refits = earlier->options.fit.refits, options.fit.identity = earlier->options.fit.identity,
    options.fit.displacement = earlier->options.fit.displacement;
  if (!arguments.identity.empty())
    options.fit.identity = arguments.identity == "none" ? "" : arguments.identity;
  if (!arguments.displacement.empty())
    options.fit.displacement = arguments.displacement == "none" ? "" : arguments.displacement;
  if (const auto fine = check_identity(options); !fine) return report_failure(fine.error());
  if (const auto fine = check_displacement(options); !fine) return report_failure(fine.error());
  auto project = open_or_create_project(arguments.project, options);
  if (!project) return report_failure(project.error());
  const int code = run(*project, last, arguments.common, *backend);
  if (code == kExitFailed && !existed && project->record(Stage::import).state == StageState::failed) {
    std::error_code ignored;
    fs::remove_all(arguments.project, ignored);
  }
  return code;
}

// Options named on the command line replace the project's, the others stay.
int run_existing(const BuildArguments& arguments, Stage last, const CLI::App& verb) {
  const auto given = [&](const char* name) {
    const CLI::Option* option = verb.get_option_no_throw(name);
    return option != nullptr && option->count() > 0;
  };
  auto opened = open_project(arguments.input);
  if (!opened) return report_failure(opened.error());
  ProjectOptions options = opened->options;
  if (given("--budget")) {
    options.train.budget_s = arguments.options.train.budget_s, options.train.full_budget_s = 0,
    options.train.steps = 0;
  }
  if (given("--steps")) options.train.steps = arguments.options.train.steps;
  if (given("--checkpoint-every"))
    options.train.checkpoint_every_s = arguments.options.train.checkpoint_every_s;
  if (given("--mode")) options.train.mode = arguments.options.train.mode;
  if (given("--landmark-loss")) options.train.landmark_loss = arguments.options.train.landmark_loss;
  if (given("--lens")) options.align.lens_mm = arguments.options.align.lens_mm;
  if (given("--seed")) options.shared.seed = arguments.common.seed;
  if (given("--head-model")) options.shared.head_model = arguments.options.shared.head_model;
  if (given("--identity")) options.fit.identity = arguments.identity == "none" ? "" : arguments.identity;
  if (given("--identity") || given("--head-model"))
    if (const auto fine = check_identity(options); !fine) return report_failure(fine.error());
  if (given("--displacement"))
    options.fit.displacement = arguments.displacement == "none" ? "" : arguments.displacement;
  if (given("--displacement") || given("--head-model"))
    if (const auto fine = check_displacement(options); !fine) return report_failure(fine.error());
  if (given("--leave-out")) {
    auto frames = parse_frames(arguments.leave_out, "--leave-out");
    if (!frames) return report_failure(frames.error());
    const auto capture = read_capture(capture_path(*opened));
    if (!capture) return report_failure(capture.error());
    if (const auto fine = check_left_out(*capture, *frames); !fine) return report_failure(fine.error());
    options.train.left_out = std::move(*frames);
  }
  if (given("--refit")) {
    auto spans = asked_refits(options.fit.refits, arguments.refit);
    if (!spans) return report_failure(spans.error());
    if (const auto fine = check_project_refits(*opened, *spans); !fine) return report_failure(fine.error());
    options.fit.refits = std::move(*spans);
    last = Stage::fit;  // seconds; what follows is for the next train
  }
  const auto backend = chosen_backend(arguments.common, arguments.precision);
  if (!backend) return report_failure(backend.error());
  auto project = open_or_create_project(arguments.input, options);
  if (!project) return report_failure(project.error());
  // The window's "finish now" was for the avatar that it made; one of other inputs gets all of the budget.
  if (project->options.train.full_budget_s > 0 && !is_current(*project, Stage::train)) {
    restore_budget(options);
    project = open_or_create_project(arguments.input, options);
    if (!project) return report_failure(project.error());
  }
  const bool nothing_new = given("--refit") && is_current(*project, Stage::fit);
  const int code = run(*project, last, arguments.common, *backend);
  if (code == kExitDone && nothing_new && !arguments.common.json)
    fmt::print(stderr, "Nothing is to be done: {}\n", project->record(Stage::fit).message);
  else if (code == kExitDone && given("--refit") && !arguments.common.json)
    fmt::print(stderr, "Masks and avatar are made from it by the next: likeness train {}\n",
               project->folder.string());
  return code;
}

int run_align_photos(const BuildArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  AlignOptions options;
  options.seed = int(arguments.common.seed);
  const fs::path work = fs::path(arguments.out).concat(".colmap");
  const auto start = std::chrono::steady_clock::now();
  const ProgressLine line(arguments.common);
  // Photographs may show a person or not: what the face detector finds is masked.
  const auto person = coarse_person_mask(arguments.options.shared.landmark_model, Pictures::single);
  if (!person) return report_failure(person.error());
  const auto aligned =
      align_photos(arguments.input, *person, work, options, line.progress(), stop_on_signals());
  if (!aligned) return report_failure(aligned.error());
  if (const auto written = write_cameras(arguments.out, aligned->cameras); !written)
    return report_failure(written.error());
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (arguments.common.json) {
    print_json({{"frames", aligned->frames},
                {"registered", aligned->registered},
                {"static", aligned->cameras.is_static},
                {"seconds", seconds},
                {"reprojection_px", aligned->cameras.reprojection_px}});
  } else {
    fmt::print(stderr, "\r\033[K{}\n", aligned->evidence);
  }
  return kExitDone;
}

void add_training_options(CLI::App& verb, BuildArguments& a) {
  verb.add_option("--budget", a.options.train.budget_s,
                  "Seconds of training; placing further clips and --refine-track take theirs on top")
      ->check(CLI::Range(1.0, 1e6));
  verb.add_option("--checkpoint-every", a.options.train.checkpoint_every_s, "Seconds between checkpoints")
      ->check(CLI::Range(0.1, 3600.0));
  verb.add_option("--steps", a.options.train.steps, "Exact training steps instead of a budget");
  add_mode_option(verb, a.options.train.mode);
  verb.add_option("--landmark-loss", a.options.train.landmark_loss,
                  "Weight of a loss on where landmarks lie in the pictures, e.g. 0.1; default: 0, without")
      ->check(CLI::Range(0.0, 1e3));
  add_precision_option(verb, a.precision);
}

void add_identity_option(CLI::App& verb, BuildArguments& a) {
  verb.add_option(
      "--identity", a.identity,
      "The person's shape, held instead of fitted: identity coefficients of the head model (MICA's "
      "identity.npy for FLAME) or its vertices in metres, as .npy, .npz or .obj; none: fitted again");
}

void add_displacement_option(CLI::App& verb, BuildArguments& a) {
  verb.add_option(
      "--displacement", a.displacement,
      "A folder of detail maps, one a frame: heights in mm along the normal on the head model's texture, "
      "000360.npy, .exr or .tif of floats or .png of 16 bits (32768 is zero, a step a micrometre); none: "
      "without from now on");
}

void add_lens_option(CLI::App& verb, BuildArguments& a) {
  verb.add_option(
          "--lens", a.options.align.lens_mm,
          "Focal length of a resting camera, in mm as on 35 mm film (36 mm the longer side); default: as "
          "the clip tells, or a usual one. 0: the default again")
      ->check(CLI::Range(8.0, 2000.0) | CLI::Range(0.0, 0.0));
}

void add_capture_options(CLI::App& verb, BuildArguments& a) {
  verb.add_option("video", a.input, "The clip")->required();
  verb.add_option("--project", a.project, "The project folder, made if absent")->required();
  verb.add_option("--size", a.options.import.size, "Side of the pictures, px")
      ->check(CLI::IsMember({256, 512, 1024}));
  std::map<std::string, Split> splits;
  for (const Split split : kSplits) splits.emplace(split_name(split), split);
  verb.add_option(
          "--split", a.options.import.split,
          "What is held out to be measured on: the last tenth (tail, the default), a tenth of what a moving "
          "camera filmed, in a row (views), or three tenths by chance (random30)")
      ->transform(CLI::CheckedTransformer(std::move(splits)));
  verb.add_flag("--resting-camera", a.options.align.resting_camera,
                "The camera rests, whatever its background does: skip finding out");
  add_lens_option(verb, a);
  verb.add_option("--head-model", a.options.shared.head_model,
                  "A head model: FLAME's .pkl, ICT-FaceKit's folder, or a .npz; default: the built-in head");
  verb.add_option("--matting-network", a.options.matte.matting_network,
                  "A matting or parsing network (.onnx) to tell the person from the background with");
  verb.add_option("--landmark-model", a.options.shared.landmark_model,
                  "A dlib 68-point shape predictor; default: the system's");
}

}  // namespace

void add_build_commands(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<BuildArguments>();

  CLI::App* build = program.add_subcommand("build", "All stages: from a clip to a trained avatar");
  add_capture_options(*build, *a);
  add_training_options(*build, *a);
  add_identity_option(*build, *a);
  add_displacement_option(*build, *a);
  build->add_flag("!--no-latent", a->options.train.use_latent, "Ablation: without the per-frame code");
  build->add_flag("--refine-track", a->options.train.refine_track,
                  "Correct the training frames' poses and faces through the field while it learns");
  build->add_flag("!--no-occupancy", a->options.train.use_occupancy, "Ablation: without the occupancy grid");
  add_common_options_with_cuda(*build, a->common);
  build->add_flag("--forecast", a->forecast,
                  "Only tell what the build will take of disk, memory and minutes");
  build->callback(
      [a, &exit_code] { exit_code = a->forecast ? run_forecast(*a) : run_new(*a, Stage::train); });

  CLI::App* import_verb = program.add_subcommand("import", "Decode a clip, choose frames, crop");
  add_capture_options(*import_verb, *a);
  add_common_options(*import_verb, a->common);
  import_verb->callback([a, &exit_code] { exit_code = run_new(*a, Stage::import); });

  CLI::App* align = program.add_subcommand("align", "Cameras of a project, or of a folder of photographs");
  align->add_option("input", a->input, "Project folder, or folder of photographs")->required();
  align->add_option("--out", a->out, "cameras.json to write, for photographs");
  add_lens_option(*align, *a);
  add_common_options(*align, a->common);
  align->callback([a, align, &exit_code] {
    if (std::error_code ignored; fs::exists(a->input / "project.json", ignored)) {
      exit_code = run_existing(*a, Stage::align, *align);
    } else if (a->out.empty()) {
      throw CLI::RequiredError("--out, because " + a->input.string() + " is not a project folder,");
    } else {
      exit_code = run_align_photos(*a);
    }
  });

  CLI::App* fit = program.add_subcommand("fit", "Track the head, cut out the person");
  fit->add_option("project", a->input, "Project folder")->required();
  fit->add_option("--head-model", a->options.shared.head_model, "Use another head model from now on");
  fit->add_option(
         "--refit", a->refit,
         "Fit spans of frames again by themselves, from the good ones around them, and nothing else: "
         "190-204 or 12,40-60, beside those before; none takes all back")
      ->allow_extra_args(false);
  add_identity_option(*fit, *a);
  add_displacement_option(*fit, *a);
  add_lens_option(*fit, *a);
  add_common_options(*fit, a->common);
  fit->callback([a, fit, &exit_code] { exit_code = run_existing(*a, Stage::matte, *fit); });

  CLI::App* train = program.add_subcommand("train", "Train the avatar, or continue");
  train->add_option("project", a->input, "Project folder")->required();
  add_training_options(*train, *a);
  train->add_option("--leave-out", a->leave_out,
                    "Frames that shall not train, from now on: 12,40-60, or none");
  add_common_options_with_cuda(*train, a->common);
  train->callback([a, train, &exit_code] { exit_code = run_existing(*a, Stage::train, *train); });
}

}  // namespace likeness::app
