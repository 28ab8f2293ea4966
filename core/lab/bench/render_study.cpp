// Settings of the renderer side by side: see render_study.h.
#include "core/lab/bench/render_study.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <iterator>
#include <memory>
#include <set>
#include <string>

#include <fmt/format.h>

#include "core/image/files.h"
#include "core/image/metrics.h"
#include "core/lab/score/held_out.h"
#include "core/lab/score/sized_clip.h"
#include "core/project/project_attributes.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/render/pose_avatar.h"
#include "core/train/exposure.h"

namespace likeness {

namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

struct ChosenFrame {
  const TrackedFrame* tracked;
  Camera camera;
};

// At most `most` of the frames that can be rendered, evenly chosen; most <= 0: all.
std::vector<ChosenFrame> choose_frames(const HeldOutSet& set, int most) {
  std::vector<ChosenFrame> all;
  for (const int frame : held_out_frames(set.capture)) {
    const TrackedFrame* tracked = find_tracked(set.track, frame);
    const auto camera = filmed_camera(set.capture, set.cameras, set.track, frame);
    if (tracked && tracked->status != FrameStatus::lost && camera) all.push_back({tracked, *camera});
  }
  std::vector<ChosenFrame> chosen;
  for (const std::size_t k : evenly_chosen(all.size(), std::size_t(std::max(0, most))))
    chosen.push_back(all[k]);
  return chosen;
}

struct Truth {
  Image picture;
  Regions regions;
  Image8 plate;  // empty if the background is not known
  Vec3f exposure = Vec3f::Ones();
};

Result<Truth> truth_of(const Project& project, const HeldOutSet& set, int frame) {
  const auto picture = read_truth(project, set.capture, frame);
  if (!picture) return picture.error();
  auto regions = read_regions(regions_path(project), set.capture, frame);
  if (!regions) return regions.error();
  Truth truth{to_float(*picture), std::move(*regions), {}};
  const auto camera = picture_camera(set.capture, set.cameras, set.track, frame);
  if (!camera) return truth;
  truth.plate = plate_behind(set, frame, *camera);
  const auto exposure = held_out_exposure(project, set, frame, *camera, *picture);
  if (!exposure) return exposure.error();
  truth.exposure = *exposure;
  return truth;
}

Avatar without_opacities(const Avatar& avatar) {
  Avatar bare = avatar;
  bare.head.opacity.clear();
  if (bare.torso) bare.torso->opacity.clear();
  return bare;
}

// One for each row, since a device renderer is prepared for the options of its pictures.
using Renderers = std::vector<std::unique_ptr<FrameRenderer>>;

Result<Renderers> make_renderers(Backend& backend, const Avatar& avatar, const Avatar& bare,
                                 const std::vector<RenderRow>& rows) {
  Renderers renderers;
  for (const RenderRow& row : rows) {
    auto made = backend.make_renderer(row.setting.opacities ? avatar : bare);
    if (!made) return made.error();
    renderers.push_back(std::move(*made));
  }
  return renderers;
}

// Adds one frame to the sums of every row. The first picture of a pose finds its tables cold, and a device
// allocates at its very first, so one of each is rendered before any is timed.
Result<void> add_frame(const Renderers& renderers, const Camera& camera, const RenderState& state,
                       const Truth& truth, bool first, std::vector<RenderRow>& rows) {
  for (std::size_t r = 0; r < (first ? rows.size() : 1); ++r)
    if (auto done = renderers[r]->render(camera, state, rows[r].setting.options); !done) return done.error();
  Image final_picture;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    RenderRow& row = rows[r];
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t worked = std::clock();
    const auto frame = renderers[r]->render(camera, state, row.setting.options);
    if (!frame) return frame.error();
    row.processor_milliseconds += 1000.0 * double(std::clock() - worked) / CLOCKS_PER_SEC;
    row.milliseconds += milliseconds_since(start);
    row.samples_per_ray += frame->samples_per_ray;
    const Image picture = to_float(to_bytes(exposed(composite(frame->rgba, truth.plate), truth.exposure)));
    if (final_picture.empty()) final_picture = picture;
    row.to_final_db += mse(final_picture, picture);  // pooled: two pictures may be equal
    if (truth.plate.empty())
      row.psnr_db.reset();
    else if (row.psnr_db)
      *row.psnr_db += psnr_from_mse(mse(truth.picture, picture));
    row.psnr_head_db += psnr_from_mse(mse(truth.picture, picture, truth.regions.head));
    row.psnr_face_db += psnr_from_mse(mse(truth.picture, picture, truth.regions.face));
  }
  return {};
}

}  // namespace

std::vector<RenderSetting> quality_ladder() {
  std::vector<RenderSetting> settings;
  for (const RenderQuality quality : {RenderQuality::final, RenderQuality::preview})
    settings.push_back({kRenderQualities[int(quality)], render_options(quality)});
  return settings;
}

std::vector<RenderSetting> render_settings() {
  std::vector<RenderSetting> settings = quality_ladder();
  for (const RenderQuality quality : {RenderQuality::final, RenderQuality::preview}) {
    RenderOptions options = render_options(quality);
    options.deferred = true;
    settings.push_back({fmt::format("{}, one colour per ray", kRenderQualities[int(quality)]), options});
  }
  const auto without = [&](const char* what, bool opacities, const auto& change) {
    RenderOptions options = render_options(RenderQuality::final);
    change(options);
    settings.push_back({fmt::format("final without {}", what), options, opacities});
  };
  without("ending opaque rays", true, [](RenderOptions& o) { o.stop_transmittance = 0; });
  without("a least weight of colours", true, [](RenderOptions& o) { o.shade_weight = 0; });
  without("strata", true, [](RenderOptions& o) { o.strata = 0; });
  without("opacities", false, [](RenderOptions&) {});
  without("strata and opacities", false, [](RenderOptions& o) { o.strata = 0; });
  settings.push_back({"exact", {}});
  constexpr const char* kSizes[] = {"", "half size, ", "third size, "};
  for (const int reduce : {1, 2, 3}) {
    const auto add = [&](int samples, int strata, int block,
                         float edge_contrast = RenderOptions().edge_contrast) {
      RenderOptions options;
      options.precision = FieldPrecision::bf16;
      options.max_samples = samples, options.strata = strata, options.block = block;
      options.reduce = reduce, options.edge_contrast = edge_contrast;
      const std::string edges =
          edge_contrast > 1 ? "edges too" : fmt::format("edges of {:.3g}", edge_contrast);
      settings.push_back({fmt::format("{}{} samples{}{}", kSizes[reduce - 1], samples,
                                      strata > 0 ? fmt::format(", {} strata of {} px", strata, block) : "",
                                      reduce > 1 ? ", " + edges : ""),
                          options});
    };
    for (const int samples : {32, 24, 20, 16, 12, 8}) add(samples, 8, 2);
    if (reduce > 1)
      for (const float edge_contrast : {99.f, 0.4f, 0.1f, 0.05f, 0.025f}) add(20, 8, 2, edge_contrast);
    if (reduce == 3) continue;
    for (const int samples : {32, 16}) add(samples, 0, 1);
    add(16, 8, 1), add(16, 16, 2), add(16, 16, 4);
  }
  for (const int rays : {20000, 30000, 60000, 80000}) {
    RenderOptions options = render_options(RenderQuality::preview);
    options.max_rays = rays;
    settings.push_back({fmt::format("preview of {} rays", rays), options});
  }
  return settings;
}

Result<RenderStudy> study_rendering(const Project& project, int frames, std::vector<RenderSetting> settings,
                                    std::shared_ptr<Backend> backend, const Progress& progress,
                                    std::stop_token stop) {
  const auto set = read_held_out(project);
  if (!set) return set.error();
  const auto model = project_head_model(project.options);
  if (!model) return model.error();
  if (const auto fits = check_track_fits(set->track, *model); !fits) return fits.error();
  const auto made = make_rig(set->avatar, *model);
  if (!made) return made.error();
  const AvatarRig& rig = *made;
  const auto courses = read_courses(project, set->avatar);
  if (!courses) return courses.error();
  const std::vector<ChosenFrame> chosen = choose_frames(*set, frames);
  if (chosen.empty())
    return Error{ErrorCode::failed, "None of the held-out frames has a track, so nothing can be rendered.",
                 "Film a longer clip in which the face stays in view to the end.", project.folder.string()};

  RenderStudy study;
  study.size = set->capture.size;
  study.frames = int(chosen.size());
  for (RenderSetting& setting : settings)
    study.rows.push_back({.setting = std::move(setting), .psnr_db = 0.0});
  const Avatar bare = without_opacities(set->avatar);
  if (!backend) backend = cpu_backend();
  const auto renderers = make_renderers(*backend, set->avatar, bare, study.rows);
  if (!renderers) return renderers.error();
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(k) / double(chosen.size()), fmt::format("frame {}", chosen[k].tracked->frame));
    const auto truth = truth_of(project, *set, chosen[k].tracked->frame);
    if (!truth) return truth.error();
    const TrackedFrame& t = *chosen[k].tracked;
    const auto start = std::chrono::steady_clock::now();
    const RenderState state = pose_avatar(rig, frame_pose(set->avatar, *courses, t));
    study.pose_milliseconds += milliseconds_since(start);
    const auto added = add_frame(*renderers, chosen[k].camera, state, *truth, k == 0, study.rows);
    if (!added) return added.error();
  }

  const double n = double(chosen.size());
  study.pose_milliseconds /= n;
  for (RenderRow& row : study.rows) {
    if (row.psnr_db) *row.psnr_db /= n;
    row.to_final_db = psnr_from_mse(row.to_final_db / n);
    for (double* sum : {&row.psnr_head_db, &row.psnr_face_db, &row.milliseconds, &row.processor_milliseconds,
                        &row.samples_per_ray})
      *sum /= n;
    row.frames_per_second = 1000 / (row.milliseconds + study.pose_milliseconds);
  }
  progress.report(1);
  return study;
}

}  // namespace likeness
