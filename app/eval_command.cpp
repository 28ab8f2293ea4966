// likeness eval: held-out figures of a project.
#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "app/backend_option.h"
#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/score/evaluate.h"
#include "core/project/staleness.h"
#include "core/render/avatar.h"
#include "core/train/mode.h"

namespace likeness::app {

namespace {

struct EvalArguments {
  CommonOptions common;
  std::filesystem::path project;
  EvalOptions options;
};

nlohmann::json to_json(const Evaluation& e, const Avatar& avatar, RenderQuality quality, bool up_to_date) {
  nlohmann::json frames = nlohmann::json::array();
  for (const FrameScore& f : e.frames) {
    frames.push_back({{"frame", f.frame},
                      {"mse", finite_or_null(f.mse)},
                      {"person_mse", finite_or_null(f.person_mse)},
                      {"head_mse", finite_or_null(f.head_mse)},
                      {"face_mse", finite_or_null(f.face_mse)},
                      {"lmk_error_px", finite_or_null(f.landmarks_px.inner)},
                      {"lmk_mouth_px", finite_or_null(f.landmarks_px.mouth)},
                      {"lmk_eyes_px", finite_or_null(f.landmarks_px.eyes)}});
  }
  const Headline first = headline(e);
  return {{"headline", {{"of", first.of}, {"psnr_db", finite_or_null(first.psnr_db)}, {"why", first.why}}},
          {"background_learnt", e.background_fault.empty() && e.psnr_db.has_value()},
          {"psnr_db", finite_or_null(e.psnr_db)},
          {"psnr_person_db", finite_or_null(e.psnr_person_db)},
          {"psnr_head_db", finite_or_null(e.psnr_head_db)},
          {"psnr_face_db", finite_or_null(e.psnr_face_db)},
          {"psnr_pooled_db", finite_or_null(e.psnr_pooled_db)},
          {"psnr_refit_db", e.refit ? finite_or_null(e.refit->psnr_db) : nlohmann::json(nullptr)},
          {"psnr_refit_head_db", e.refit ? finite_or_null(e.refit->psnr_head_db) : nlohmann::json(nullptr)},
          {"psnr_refit_face_db", e.refit ? finite_or_null(e.refit->psnr_face_db) : nlohmann::json(nullptr)},
          {"lmk_error_px", finite_or_null(e.landmarks_px.inner)},
          {"lmk_mouth_px", finite_or_null(e.landmarks_px.mouth)},
          {"lmk_eyes_px", finite_or_null(e.landmarks_px.eyes)},
          {"ssim", finite_or_null(e.ssim)},
          {"gmsd", finite_or_null(e.gmsd)},
          {"lpips", finite_or_null(e.lpips)},
          {"mse", finite_or_null(e.mse)},
          {"face_mse", finite_or_null(e.face_mse)},
          {"frames_test", e.frames_test},
          {"frames_lost", e.frames_lost},
          {"free_numbers_per_frame", e.free_numbers_per_frame},
          {"split", e.split},
          {"size", e.size},
          {"steps", avatar.steps},
          {"seed", avatar.seed},
          {"mode", mode_name(mode_of(avatar))},
          {"up_to_date", up_to_date},
          {"backend", e.backend},
          {"head_model", avatar.head_model_name},
          {"train_seconds", avatar.train_seconds},
          {"quality", kRenderQualities[int(quality)]},
          {"render_fps", e.render_fps},
          {"samples_per_ray", e.samples_per_ray},
          {"frames", frames}};
}

std::string decibel(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f} dB", *value) : "not measured";
}

// No region, no face or no landmarks in any frame: there is nothing that a number could say.
std::string figure(double value) {
  return std::isfinite(value) ? fmt::format("{:.2f}", value) : "not measured";
}

int run(const EvalArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  const auto project = open_project(arguments.project);
  if (!project) return report_failure(project.error());
  auto options = arguments.options;
  const auto place = chosen_place(arguments.common);
  if (!place) return report_failure(place.error());
  options.place = *place;
  std::optional<Result<Evaluation>> outcome;
  {
    const ProgressLine line(arguments.common);
    outcome = evaluate(*project, options, line.progress(), stop_on_signals());
  }
  if (!*outcome) return report_failure(outcome->error());
  const Evaluation& e = **outcome;
  const auto avatar = read_avatar(avatar_path(*project));
  if (!avatar) return report_failure(avatar.error());
  // Scores of an avatar whose inputs have changed since its training are still its scores, but not the
  // project's.
  const bool up_to_date = is_current(*project, Stage::train);
  if (!up_to_date) {
    tell(
        "note: the clip, the track or the options changed after this avatar was trained; "
        "likeness train {} brings it up to date.\n",
        project->folder.string());
  }
  if (arguments.common.json) {
    print_json(to_json(e, *avatar, arguments.options.quality, up_to_date));
    return kExitDone;
  }
  fmt::print("{} held-out frames ({} split), {} px\n", e.frames_test, e.split, e.size);
  if (e.frames_lost > 0)
    fmt::print("{} more held-out frames have no track and are not measured\n", e.frames_lost);
  const auto faceless =
      std::ranges::count_if(e.frames, [](const FrameScore& f) { return !std::isfinite(f.face_mse); });
  if (faceless > 0) fmt::print("{} of them show no face and are left out of its figures\n", faceless);
  if (const Headline first = headline(e); first.why.empty())
    fmt::print("PSNR full {}  person {}  head {}  face {} dB\n", decibel(e.psnr_db), figure(e.psnr_person_db),
               figure(e.psnr_head_db), figure(e.psnr_face_db));
  else
    fmt::print("PSNR person {}  head {}  face {} dB; full {}\n{}\n", figure(e.psnr_person_db),
               figure(e.psnr_head_db), figure(e.psnr_face_db), decibel(e.psnr_db), first.why);
  if (e.refit)
    fmt::print(
        "with {} numbers per frame fitted to the frozen field (an oracle): full {}  head {}  face {} "
        "dB\n",
        e.refit->free_numbers_per_frame, decibel(e.refit->psnr_db), figure(e.refit->psnr_head_db),
        figure(e.refit->psnr_face_db));
  if (e.ssim) fmt::print("SSIM {:.4f}  GMSD {:.4f}\n", *e.ssim, *e.gmsd);
  if (e.lpips) fmt::print("LPIPS {:.4f}, by {}\n", *e.lpips, options.lpips.filename().string());
  fmt::print("landmarks off by {} px (mouth {}, eyes {})  {:.1f} frames/s at {:.1f} samples per ray\n",
             figure(e.landmarks_px.inner), figure(e.landmarks_px.mouth), figure(e.landmarks_px.eyes),
             e.render_fps, e.samples_per_ray);
  return kExitDone;
}

}  // namespace

void add_eval_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<EvalArguments>();
  CLI::App* verb = program.add_subcommand("eval", "Measure the avatar on frames it never saw");
  verb->add_option("project", a->project, "Project folder")->required();
  verb->add_option("--regions", a->options.regions,
                   "Folder of region pictures (red person, green head, blue face)")
      ->check(CLI::ExistingDirectory);
  verb->add_option("--lpips", a->options.lpips,
                   "A network (.onnx) that measures perceptual distance, e.g. LPIPS")
      ->check(CLI::ExistingFile);
  verb->add_option("--pictures", a->options.pictures, "Folder for PNGs: truth, avatar, difference");
  verb->add_option("--video", a->options.video, "mp4 of the same");
  add_quality_option(*verb, a->options.quality);
  verb->add_flag(
      "--refit", a->options.refit,
      "Also fit pose and expression of every frame to the frozen field, to see what tracking hides");
  add_common_options_with_cuda(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
