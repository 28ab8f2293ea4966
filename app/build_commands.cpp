// likeness build|import|align|fit|train: run a project's stages, all or up to one.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "app/backend_option.h"
#include "app/commands.h"
#include "app/consent_option.h"
#include "app/parts.h"
#include "app/project_options.h"
#include "app/terminal.h"
#include "core/base/file_names.h"
#include "core/base/files.h"
#include "core/base/parallel.h"
#include "core/camera/align.h"
#include "core/capture/capture.h"
#include "core/check/clip_words.h"
#include "core/head/detail_maps.h"
#include "core/head/read_person.h"
#include "core/matte/coarse_mask.h"
#include "core/matte/matte_report.h"
#include "core/matte/person_network.h"
#include "core/project/build_forecast.h"
#include "core/project/care.h"
#include "core/project/further_clips.h"
#include "core/project/project_head_model.h"
#include "core/project/refits.h"
#include "core/project/run_stages.h"
#include "core/project/staleness.h"
#include "core/render/avatar.h"
#include "core/scene/track.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct BuildArguments {
  CommonOptions common;
  fs::path input, project, out;
  std::string consent;  // as given
  GivenOptions given;
  bool forecast = false;
  FieldPrecision precision = FieldPrecision::bf16;
};

// A shape that does not fit the head model is refused before anything is changed.
Result<void> check_identity(const ProjectOptions& options) {
  if (options.fit.identity.empty()) return {};
  const auto model = project_head_model(options);
  if (!model) return model.error();
  const auto person = read_person(options.fit.identity, *model);
  return person ? Result<void>() : Result<void>(person.error());
}

// The same for detail maps.
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
  if (const auto named = check_can_be_named(arguments.project); !named) return report_failure(named.error());
  const auto clip = probe_video(arguments.input);
  if (!clip) return report_failure(clip.error());
  const auto model = project_head_model(arguments.given.options);
  if (!model) return report_failure(model.error());
  const int threads = current_thread_limit();
  const BuildForecast forecast = forecast_build(*clip, arguments.given.options, *model, threads);
  const Resources free = free_resources(arguments.project);
  const auto fits = check_forecast(forecast, free, folder_bytes(arguments.project));
  const auto smaller = smaller_size(*clip, arguments.given.options, *model, threads, free);
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

// Of the stages that are up to date.
ClipFacts facts_of(const Project& project) {
  ClipResults results;
  results.stated = project.options.align.camera;
  results.person_network = !person_network_hash(project.options.shared.person_network).empty();
  const auto capture = read_capture(capture_path(project));
  if (capture && is_current(project, Stage::import)) results.capture = &*capture;
  const auto cameras = read_cameras(cameras_path(project));
  if (cameras && is_current(project, Stage::align)) results.cameras = &*cameras;
  results.camera_evidence = project.record(Stage::align).message;
  const auto mattes = read_matte_report(matte_report_path(project));
  if (mattes && *mattes && is_current(project, Stage::matte)) results.mattes = &**mattes;
  return clip_facts(results);
}

// What the clip is and what was not learnt of it, at the end of a build.
void print_closing_words(const Project& project) {
  const ClipFacts facts = facts_of(project);
  tell("{}\n{}\n{}\n", camera_sentence(facts.camera), mask_sentence(facts.mask), parts_sentence(facts.parts));
  const auto avatar = read_avatar(avatar_path(project));
  if (avatar && !avatar->background_fault.empty())
    tell("{} Judge the avatar by the person: likeness eval gives person, head and face.\n",
         avatar->background_fault);
}
// "camera" and "shots": of a film that was cut also those that are left out, with the reason.
void add_shots(const Project& project, nlohmann::json& summary) {
  const auto capture = read_capture(capture_path(project));
  const bool cut = capture && is_current(project, Stage::import) && capture->shots.size() > 1;
  const auto cameras = read_cameras(cameras_path(project));
  const bool aligned = cameras && is_current(project, Stage::align);
  if (aligned) summary["camera"] = camera_kind_name(cameras->kind);
  if (cut || aligned) summary["shots"] = nlohmann::json::array();
  if (cut)
    for (const ClipShot& shot : capture->shots) {
      nlohmann::json entry = {
          {"from_s", shot.from_s}, {"to_s", shot.to_s}, {"used", shot.used}, {"reason", shot.reason}};
      if (aligned && shot.used) entry["camera"] = camera_kind_name(cameras->kind);
      summary["shots"].push_back(std::move(entry));
    }
  else if (aligned)
    for (const CameraShot& shot : cameras->shots)
      summary["shots"].push_back(
          {{"from_s", shot.from_s}, {"to_s", shot.to_s}, {"camera", camera_kind_name(shot.camera)}});
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
  add_shots(project, summary);
  if (is_current(project, Stage::fit))
    if (const auto track = read_track(track_path(project)); track && !track->rest.frames.empty())
      summary["rest"] = {{"frames", track->rest.frames},
                         {"asked", track->rest.asked},
                         {"trust", track->rest.trust},
                         {"why", track->rest.why},
                         {"warning", track->rest.warning}};
  if (is_current(project, Stage::train))
    if (const auto avatar = read_avatar(avatar_path(project))) {
      summary["parts"] = parts_json(avatar->parts);
      summary["background_fault"] = avatar->background_fault;
    }
  const ClipFacts facts = facts_of(project);
  summary["words"] = {{"camera", camera_sentence(facts.camera)},
                      {"mask", mask_sentence(facts.mask)},
                      {"parts", parts_sentence(facts.parts)}};
  return summary;
}

int run(Project& project, Stage last, const CommonOptions& common, const ChosenBackend& backend) {
  const ThreadLimit limit(common.threads);
  RunObserver observer;
  if (!common.json) {
    observer.parts = [](const std::vector<AvatarPart>& parts) {
      clear_line();
      tell("  parts of this avatar, and why\n");
      tell("{}", parts_text(parts));
    };
    observer.stage_changed = [](Stage stage, const StageRecord& record) {
      if (record.state != StageState::done) return;
      clear_line();
      tell("{:>7}  {} ({:.0f} s)\n", stage_name(stage), record.message, record.seconds);
      for (const std::string& warning : record.warnings) tell("         note: {}\n", warning);
    };
    observer.further_changed = [](Stage stage, int number, const Project& clip) {
      const StageRecord& record = clip.record(stage);
      if (record.state != StageState::done) return;
      clear_line();
      tell("{:>7}  {}: {} ({:.0f} s)\n", stage_name(stage), further_clip_name(clip, number), record.message,
           record.seconds);
      for (const std::string& warning : record.warnings) tell("         note: {}\n", warning);
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
    print_closing_words(project);
    tell("Done. Next: likeness render {} --out avatar.mp4 --camera orbit\n", project.folder.string());
  }
  return kExitDone;
}

// Whether this is the project's clip, perhaps moved or copied since: then what was chosen for it still holds.
bool is_clip_of(const Project& project, const fs::path& video) {
  std::error_code other;
  if (fs::equivalent(project.options.shared.video, video, other)) return true;
  const auto capture = read_capture(capture_path(project));
  const auto hash = hash_video(video);
  return capture && hash && capture->video_hash == *hash;
}

// A new answer into the project.
Result<void> keep_consent(Consent answer, Project& project) {
  if (answer == Consent::not_asked || answer == project.consent) return {};
  const auto changed = change_project(project.folder, [&](Project& p) { p.consent = answer; });
  if (!changed) return changed.error();
  project.consent = answer;
  return {};
}

// A first build that fails on its clip leaves no folder behind: there is nothing in it to keep.
int run_new(const BuildArguments& arguments, Stage last, const CLI::App& verb) {
  const auto backend = chosen_backend(arguments.common, arguments.precision);
  if (!backend) return report_failure(backend.error());
  std::error_code unknown;
  const bool existed = fs::exists(arguments.project, unknown) || unknown;
  ProjectOptions options;
  options.shared.video = arguments.input;
  Consent known = Consent::not_asked;
  if (const auto earlier = open_project(arguments.project);
      earlier && is_clip_of(*earlier, options.shared.video)) {
    known = earlier->consent;
    for (const OptionRow& row : option_table())
      if (row.kept_with_clip) copy_option(row, earlier->options, options);
  }
  if (const auto applied = apply_given(verb, arguments.given, options); !applied)
    return report_failure(applied.error());
  if (const auto fine = check_identity(options); !fine) return report_failure(fine.error());
  if (const auto fine = check_displacement(options); !fine) return report_failure(fine.error());
  const bool clip_there = fs::exists(arguments.input, unknown);
  const auto consent = answered_consent(arguments.consent,
                                        known == Consent::not_asked && clip_there && !arguments.common.json);
  if (!consent) return report_failure(consent.error());
  auto project = open_or_create_project(arguments.project, options);
  if (!project) return report_failure(project.error());
  if (const auto kept = keep_consent(*consent, *project); !kept) return report_failure(kept.error());
  const int code = run(*project, last, arguments.common, *backend);
  // An import of another clip forgets what was answered of the one before.
  if (const auto kept = keep_consent(*consent, *project); !kept && fs::exists(arguments.project, unknown))
    return report_failure(kept.error());
  if (project->consent == Consent::not_asked && code == kExitDone && !arguments.common.json)
    tell("Whether the filmed person agreed was not answered; exports say so. Answer it with --consent.\n");
  if (code == kExitFailed && !existed && project->record(Stage::import).state == StageState::failed) {
    std::error_code ignored;
    fs::remove_all(arguments.project, ignored);
  }
  return code;
}

// Checks that what the new choices name fits the project, before anything is changed.
Result<void> check_given(const CLI::App& verb, const Project& before, const ProjectOptions& options) {
  const auto given = [&](const char* key) { return is_given(verb, key); };
  if (given("identity") || given("head_model"))
    if (const auto fine = check_identity(options); !fine) return fine;
  if (given("displacement") || given("head_model"))
    if (const auto fine = check_displacement(options); !fine) return fine;
  if (given("left_out")) {
    const auto capture = read_capture(capture_path(before));
    if (!capture) return capture.error();
    if (const auto fine = check_left_out(*capture, options.train.left_out); !fine) return fine;
  }
  if (given("rest_frames") && path_exists(capture_path(before))) {
    const auto capture = read_capture(capture_path(before));
    if (!capture) return capture.error();
    if (const auto fine = check_rest_frames(*capture, options.fit.rest_frames); !fine) return fine;
  }
  return given("refits") ? check_project_refits(before, options.fit.refits) : Result<void>();
}

// Options named on the command line replace the project's, the others stay.
int run_existing(const BuildArguments& arguments, Stage last, const CLI::App& verb) {
  auto opened = open_project(arguments.input);
  if (!opened) return report_failure(opened.error());
  ProjectOptions options = opened->options;
  if (is_given(verb, "budget_s")) options.train.full_budget_s = 0, options.train.steps = 0;
  if (const auto applied = apply_given(verb, arguments.given, options); !applied)
    return report_failure(applied.error());
  if (const auto fine = check_given(verb, *opened, options); !fine) return report_failure(fine.error());
  const bool refits = is_given(verb, "refits");
  if (refits) last = Stage::fit;  // takes seconds; later stages are left to the next train
  const auto backend = chosen_backend(arguments.common, arguments.precision);
  if (!backend) return report_failure(backend.error());
  auto project = open_or_create_project(arguments.input, options);
  if (!project) return report_failure(project.error());
  if (!arguments.consent.empty())
    if (const auto kept = keep_consent(*answered_consent(arguments.consent, false), *project); !kept)
      return report_failure(kept.error());
  // "Finish with what is learnt" shortened the budget of one avatar; a training with other inputs gets all of
  // it.
  if (project->options.train.full_budget_s > 0 && !is_current(*project, Stage::train)) {
    restore_budget(options);
    project = open_or_create_project(arguments.input, options);
    if (!project) return report_failure(project.error());
  }
  const bool nothing_new = refits && is_current(*project, Stage::fit);
  const int code = run(*project, last, arguments.common, *backend);
  if (code == kExitDone && nothing_new && !arguments.common.json)
    tell("Nothing to do: {}\n", project->record(Stage::fit).message);
  else if (code == kExitDone && refits && !arguments.common.json)
    tell("To make masks and avatar from it: likeness train {}\n", project->folder.string());
  return code;
}

int run_align_photos(const BuildArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  if (const auto free = check_free(arguments.out, "--out"); !free) return report_failure(free.error());
  AlignOptions options;
  options.seed = int(arguments.given.options.shared.seed);
  const fs::path out = arguments.out;
  const fs::path work = out.parent_path() / name_with(out.filename().string(), ".colmap");
  const auto start = std::chrono::steady_clock::now();
  const ProgressLine line(arguments.common);
  // Photographs may or may not show a person: what the face detector finds is masked.
  const auto person = coarse_person_mask(arguments.given.options.shared.landmark_model, Pictures::single,
                                         arguments.given.options.shared.person_network);
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
                {"static", aligned->cameras.rests()},
                {"camera", camera_kind_name(aligned->cameras.kind)},
                {"seconds", seconds},
                {"reprojection_px", aligned->cameras.reprojection_px},
                {"warnings", aligned->warnings}});
  } else {
    clear_line();
    tell("{}\n", aligned->evidence);
    for (const std::string& warning : aligned->warnings) tell("{}\n", warning);
  }
  return kExitDone;
}

void add_new_project(CLI::App& verb, BuildArguments& a) {
  verb.add_option("video", a.input, "The clip")->required();
  verb.add_option("--project", a.project, "The project folder, made if absent")->required();
}

}  // namespace

void add_build_commands(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<BuildArguments>();

  CLI::App* build = program.add_subcommand("build", "All stages: from a clip to a trained avatar");
  add_new_project(*build, *a);
  add_consent_option(*build, a->consent);
  add_project_options(*build, &OptionVerbs::build, a->given);
  add_precision_option(*build, a->precision);
  add_common_options_with_cuda(*build, a->common);
  build->add_flag("--forecast", a->forecast, "Only say how much time, disk and memory the build will take");
  build->callback([a, build, &exit_code] {
    exit_code = a->forecast ? run_forecast(*a) : run_new(*a, Stage::train, *build);
  });

  CLI::App* import_verb = program.add_subcommand("import", "Decode a clip, choose frames, crop");
  add_new_project(*import_verb, *a);
  add_consent_option(*import_verb, a->consent);
  add_project_options(*import_verb, &OptionVerbs::import, a->given);
  add_common_options(*import_verb, a->common);
  import_verb->callback(
      [a, import_verb, &exit_code] { exit_code = run_new(*a, Stage::import, *import_verb); });

  CLI::App* align = program.add_subcommand("align", "Cameras of a project, or of a folder of photographs");
  align->add_option("input", a->input, "Project folder, or folder of photographs")->required();
  align->add_option("--out", a->out, "cameras.json to write, for photographs");
  add_project_options(*align, &OptionVerbs::align, a->given);
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
  add_project_options(*fit, &OptionVerbs::fit, a->given);
  add_common_options(*fit, a->common);
  fit->callback([a, fit, &exit_code] { exit_code = run_existing(*a, Stage::matte, *fit); });

  CLI::App* train = program.add_subcommand("train", "Train the avatar, or continue");
  train->add_option("project", a->input, "Project folder")->required();
  add_consent_option(*train, a->consent);
  add_project_options(*train, &OptionVerbs::train, a->given);
  add_precision_option(*train, a->precision);
  add_common_options_with_cuda(*train, a->common);
  train->callback([a, train, &exit_code] { exit_code = run_existing(*a, Stage::train, *train); });
}

}  // namespace likeness::app
