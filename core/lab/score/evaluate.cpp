// Held-out evaluation: see evaluate.h.
#include "core/lab/score/evaluate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/capture/split.h"
#include "core/image/files.h"
#include "core/image/metrics.h"
#include "core/lab/score/frame_score.h"
#include "core/lab/score/held_out.h"
#include "core/lab/score/perceptual_network.h"
#include "core/project/care.h"
#include "core/project/project_attributes.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/render/pose_avatar.h"
#include "core/render/room_picture.h"
#include "core/train/exposure.h"
#include "core/train/field_fit.h"
#include "core/video/encode.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

Image8 beside(const Image8& truth, const Image8& rendered) {
  Image8 out(truth.width * 3, truth.height, 3);
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const int a = truth.at(x, y)[c], b = rendered.at(x, y)[c];
        out.at(x, y)[c] = std::uint8_t(a);
        out.at(truth.width + x, y)[c] = std::uint8_t(b);
        out.at(2 * truth.width + x, y)[c] = std::uint8_t(std::min(255, 4 * std::abs(a - b)));
      }
    }
  }
  return out;
}

Image8 silhouette(const Image& rgba) {
  constexpr float kOpaque = 0.5f;
  Image8 mask(rgba.width, rgba.height, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = rgba.data[4 * i + 3] > kOpaque ? 255 : 0;
  return mask;
}

}  // namespace

Headline headline(const Evaluation& evaluation) {
  if (evaluation.psnr_db && evaluation.background_fault.empty()) return {"full", *evaluation.psnr_db, ""};
  return {"person", evaluation.psnr_person_db,
          !evaluation.background_fault.empty()
              ? evaluation.background_fault
              : "What stands behind the person is not known: the camera moves, and no room was learnt."};
}

Result<Evaluation> evaluate(const Project& project, const EvalOptions& options, const Progress& progress,
                            std::stop_token stop) {
  const auto inputs = read_held_out(project);
  if (!inputs) return inputs.error();
  const HeldOutSet& set = *inputs;
  const auto& [capture, cameras, track, avatar, plate_info] = set;
  const auto model = project_head_model(project.options);
  if (!model) return model.error();
  if (auto fits = check_track_fits(track, *model); !fits) return fits.error();
  const auto made = make_rig(avatar, *model);
  if (!made) return made.error();
  const AvatarRig& rig = *made;
  const auto detector = FaceDetector::load(project.options.shared.landmark_model);
  if (!detector) return detector.error();
  std::optional<PerceptualNetwork> perceptual;
  if (!options.lpips.empty()) {
    auto network = PerceptualNetwork::load(options.lpips);
    if (!network) return network.error();
    perceptual.emplace(std::move(*network));
  }
  const fs::path regions_folder = options.regions.empty() ? regions_path(project) : options.regions;
  for (const auto& [path, option] : {std::pair(options.video, "--video"), {options.pictures, "--pictures"}})
    if (const auto free = path.empty() ? Result<void>() : check_free(project, path, option); !free)
      return free.error();
  std::optional<VideoWriter> video;
  if (!options.video.empty()) {
    const int width = capture.inside.empty() ? capture.size : capture.inside.width,
              height = capture.inside.empty() ? capture.size : capture.inside.height;
    auto writer = VideoWriter::create(
        options.video, width * 3, height,
        {.frames_per_second = std::clamp(capture.frames_per_second, 1.0, 240.0), .timed = true});
    if (!writer) return writer.error();
    video.emplace(std::move(*writer));
  }

  const RenderOptions quality = render_options(options.quality);
  const auto courses = read_courses(project, avatar);
  if (!courses) return courses.error();
  const auto renderer = make_renderer(options.place, avatar);
  if (!renderer) return renderer.error();
  const auto room = avatar.room ? std::optional(make_room_scene(*avatar.room)) : std::nullopt;
  Evaluation result;
  result.background_fault = avatar.background_fault;
  result.split = split_name(capture.split);
  result.size = capture.size;
  result.free_numbers_per_frame =
      6 + int(track.frames.front().pose.articulation.expression.size()) + 3 + 6 + (track.has_torso ? 6 : 0);
  std::vector<double> ssims, gmsds, distances;
  std::vector<FrameScore> refitted;
  bool background_known = true;
  int refit_numbers = 0;
  double render_s = 0, samples = 0;
  const std::set<int> held_out = held_out_frames(capture);
  std::optional<double> started_s;  // of the film
  for (const int frame : held_out) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(result.frames_test + result.frames_lost) / double(held_out.size()),
                    fmt::format("frame {}", frame));
    const TrackedFrame* tracked = find_tracked(track, frame);
    const auto camera = filmed_camera(capture, cameras, track, frame);
    if (tracked == nullptr || tracked->status == FrameStatus::lost || !camera) {
      ++result.frames_lost;
      continue;
    }
    const auto truth = read_truth(project, capture, frame);
    if (!truth) return truth.error();
    const auto regions = read_regions(regions_folder, capture, frame);
    if (!regions) return regions.error();

    const auto start = std::chrono::steady_clock::now();
    const AvatarPose pose = frame_pose(avatar, *courses, *tracked);
    const auto rendered = (*renderer)->render(*camera, pose_avatar(rig, pose), quality);
    if (!rendered) return rendered.error();
    render_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    samples += rendered->samples_per_ray;
    Image8 plate = plate_behind(set, frame, *camera);
    background_known &= !plate.empty() || room.has_value();
    if (plate.empty() && room) plate = room_picture(*room, *camera, options.quality);
    const auto exposure = held_out_exposure(project, set, frame, *camera, *truth);
    if (!exposure) return exposure.error();
    // Scored as exported: rounded to 8 bits.
    const Image8 picture = to_bytes(exposed(composite(rendered->rgba, plate), *exposure));
    const Image a = to_float(*truth), b = to_float(picture);

    FrameScore score = score_picture(a, b, *regions, frame);
    score.landmarks_px = landmark_errors(*detector, *truth, picture);
    ssims.push_back(ssim(a, b));
    gmsds.push_back(gmsd(a, b));
    if (perceptual) {
      const auto distance = perceptual->distance(*truth, picture);
      if (!distance) return distance.error();
      distances.push_back(*distance);
    }
    if (options.look) options.look({score, *truth, picture, silhouette(rendered->rgba), *regions});
    result.frames.push_back(score);
    ++result.frames_test;
    if (options.refit) {
      const Image8 even = exposed(*truth, exposure->cwiseInverse());
      const FieldFit fit = fit_to_field(avatar, rig, *camera, {&even, &plate, &regions->head}, pose, {}, {});
      const auto again = (*renderer)->render(
          *camera, pose_avatar(rig, changed_pose(pose, avatar.condition, fit.change)), quality);
      if (!again) return again.error();
      refitted.push_back(score_picture(
          a, to_float(to_bytes(exposed(composite(again->rgba, plate), *exposure))), *regions, frame));
      refit_numbers = int(fit.change.size());
    }

    const Image8 pair = beside(*truth, picture);
    if (video) {
      if (!started_s) started_s = time_of_frame(capture, frame);
      if (const auto added = video->add(pair, time_of_frame(capture, frame) - *started_s); !added)
        return added.error();
    }
    if (!options.pictures.empty()) {
      const auto written = write_image(options.pictures / fmt::format("{:06}.png", frame), pair);
      if (!written) return written.error();
    }
  }
  result.backend = (*renderer)->backend();
  if (result.frames_test == 0) {
    return Error{ErrorCode::failed, "None of the held-out frames has a track, so nothing can be measured.",
                 "Film a longer clip in which the face stays in view to the end.", project.folder.string()};
  }
  if (video) {
    if (const auto finished = video->finish(); !finished) return finished.error();
  }

  const auto mean = [](const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v;
    return sum / double(values.size());
  };
  if (background_known) {
    result.mse = mean_finite(result.frames, [](const FrameScore& f) { return f.mse; });
    result.psnr_db = mean_finite(result.frames, [](const FrameScore& f) { return psnr_from_mse(f.mse); });
    result.psnr_pooled_db = psnr_from_mse(*result.mse);
    result.ssim = mean(ssims);
    result.gmsd = mean(gmsds);
    if (perceptual) result.lpips = mean(distances);
  }
  result.psnr_person_db =
      mean_finite(result.frames, [](const FrameScore& f) { return psnr_from_mse(f.person_mse); });
  result.psnr_head_db =
      mean_finite(result.frames, [](const FrameScore& f) { return psnr_from_mse(f.head_mse); });
  result.psnr_face_db =
      mean_finite(result.frames, [](const FrameScore& f) { return psnr_from_mse(f.face_mse); });
  if (options.refit) {
    RefitScores& refit = result.refit.emplace();
    if (background_known)
      refit.psnr_db = mean_finite(refitted, [](const FrameScore& f) { return psnr_from_mse(f.mse); });
    refit.psnr_head_db = mean_finite(refitted, [](const FrameScore& f) { return psnr_from_mse(f.head_mse); });
    refit.psnr_face_db = mean_finite(refitted, [](const FrameScore& f) { return psnr_from_mse(f.face_mse); });
    refit.free_numbers_per_frame = refit_numbers;
  }
  result.face_mse = mean_finite(result.frames, [](const FrameScore& f) { return f.face_mse; });
  result.landmarks_px = {mean_finite(result.frames, [](const FrameScore& f) { return f.landmarks_px.inner; }),
                         mean_finite(result.frames, [](const FrameScore& f) { return f.landmarks_px.mouth; }),
                         mean_finite(result.frames, [](const FrameScore& f) { return f.landmarks_px.eyes; })};
  result.render_fps = result.frames_test / std::max(render_s, 1e-9);
  result.samples_per_ray = samples / result.frames_test;
  progress.report(1);
  return result;
}

}  // namespace likeness
