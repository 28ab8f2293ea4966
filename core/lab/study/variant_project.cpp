// Tracks, mattes and the project that has them: see variant_project.h.
#include "core/lab/study/variant_project.h"

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/path_text.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/face/landmarks.h"
#include "core/head/detail_maps.h"
#include "core/lab/truth/track_study.h"
#include "core/matte/person_network.h"
#include "core/project/corrections.h"
#include "core/project/make_mattes.h"
#include "core/project/project_detail.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/stage_inputs.h"
#include "core/track/clip/track_clip.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr std::initializer_list<const char*> kMatteFiles{"masks", "plate.png", "plate_known.png",
                                                         "plate.json", "matte_report.json"};

struct Inputs {
  const Project& project;
  Capture capture;
  CameraSet cameras;
  HeadModel model;
  std::string content;  // hash of all that tracks depend on, besides the steps
};

Result<Inputs> load_inputs(const Project& project) {
  auto capture = read_capture(capture_path(project));
  if (!capture) return capture.error();
  auto cameras = read_cameras(cameras_path(project));
  if (!cameras) return cameras.error();
  auto model = project_head_model(project.options);
  if (!model) return model.error();
  if (std::error_code ignored; !fs::is_directory(regions_path(project), ignored)) {
    return Error{ErrorCode::not_found,
                 fmt::format("{} has no evaluation regions yet.", project.folder.string()),
                 fmt::format("Run: likeness fit {}", project.folder.string()), project.folder.string()};
  }
  const auto capture_hash = hash_file(capture_path(project)), cameras_hash = hash_file(cameras_path(project));
  if (!capture_hash) return capture_hash.error();
  if (!cameras_hash) return cameras_hash.error();
  std::string content = *capture_hash + *cameras_hash + model->hash +
                        landmark_source_hash(project.options.shared.landmark_model);
  return Inputs{project, std::move(*capture), std::move(*cameras), std::move(*model), std::move(content)};
}

// The track of one step, made once for all variants that start from it.
Result<fs::path> make_track(const Inputs& inputs, const std::string& step, const fs::path& folder,
                            const Progress& progress, std::stop_token stop) {
  const fs::path path =
      folder / fmt::format("{}-{}.track.json", step, hash_text(inputs.content).substr(0, 8));
  if (std::error_code ignored; fs::exists(path, ignored)) return path;
  TrackOptions base;
  base.predictor = inputs.project.options.shared.landmark_model;
  base.shots = spans_where_cut(inputs.capture);
  base.part = frames_of_seconds(inputs.capture);
  const auto steps = track_steps({step}, base);
  if (!steps) return steps.error();
  const SquareCrop& crop = inputs.capture.crop;
  auto track =
      track_clip(inputs.project.options.shared.video, {crop.x, crop.y, crop.side, crop.side}, inputs.cameras,
                 silent_frames(inputs.capture), inputs.model, steps->front().options, progress, stop);
  if (!track) return track.error();
  if (const auto written = write_track(path, *track); !written) return written.error();
  return path;
}

// Links entries of one folder into another one. What is there already stays.
Result<void> share(const fs::path& from, const fs::path& to, std::initializer_list<const char*> names) {
  std::error_code failure;
  for (const char* name : names) {
    const fs::path source = fs::absolute(from / name);
    if (failure || !fs::exists(source, failure) || fs::exists(to / name, failure)) continue;
    fs::remove(to / name, failure);  // a dangling link, to where the project once was
    fs::is_directory(source) ? fs::create_directory_symlink(source, to / name, failure)
                             : fs::create_symlink(source, to / name, failure);
  }
  if (failure) return file_error(to, "write", failure.value());
  return {};
}

// The mattes from a track, made once for all variants that do not change it.
Result<fs::path> mattes_of_track(const Inputs& inputs, const Track& track, const std::string& content,
                                 const fs::path& folder, const Progress& progress, std::stop_token stop) {
  const fs::path path = folder / fmt::format("mattes-{}", hash_text(content).substr(0, 8));
  std::error_code failure;
  if (fs::exists(path, failure)) return path;
  const fs::path part = folder / fmt::format(".{}.part", path.filename().string());
  if (const auto made = make_writable_folder(part); !made) return made.error();
  if (const auto shared = share(inputs.project.folder, part, {"frames", "regions"}); !shared)
    return shared.error();
  const TrackedCapture read{inputs.capture, inputs.cameras, track};
  // Mattes as a build makes them, networks and room included.
  const auto matted = make_mattes(inputs.project, stage_inputs(inputs.project.options).matte, part, read,
                                  inputs.model, progress, stop);
  if (!matted) return matted.error();
  fs::rename(part, path, failure);
  if (failure) return file_error(path, "write", failure.value());
  return path;
}

// A project folder that shares the pictures of the studied one and has its own track. mattes: the folder that
// holds the mattes.
Result<Project> make_workplace(const Inputs& inputs, const fs::path& folder, const Track& track,
                               const fs::path& mattes, bool maps) {
  Project work = inputs.project;
  work.folder = folder;
  work.further_clips.clear();  // the models compared are trained on one clip
  if (const auto made = make_writable_folder(folder); !made) return made.error();
  if (const auto shared =
          share(inputs.project.folder, folder, {"frames", "regions", "capture.json", "cameras.json"});
      !shared)
    return shared.error();
  if (const auto written = write_track(track_path(work), track); !written) return written.error();
  if (const auto forgotten = forget_project_detail(work); !forgotten) return forgotten.error();
  if (maps && !work.options.fit.displacement.empty()) {
    DetailReport report;
    const auto detail =
        learn_project_detail(work.options.fit.displacement, inputs.capture, track, inputs.model, report);
    if (!detail) return detail.error();
    if (const auto written = write_project_detail(work, *detail); !written) return written.error();
  }
  if (const auto matted = share(mattes, folder, kMatteFiles); !matted) return matted.error();
  return work;
}

}  // namespace

Result<Project> make_variant_project(const Project& studied, const std::string& name,
                                     const TrackVariant& variant, const fs::path& folder,
                                     const Progress& progress, std::stop_token stop) {
  Project project = studied;
  if (!variant.person_network) project.options.shared.person_network = "none";
  const auto inputs = load_inputs(project);
  if (!inputs) return inputs.error();
  if (const auto made = make_writable_folder(folder); !made) return made.error();
  Result<fs::path> tracked = track_path(project);
  if (!variant.step.empty())
    tracked = make_track(*inputs, variant.step, folder, progress.stage(0, 0.8, "track"), stop);
  if (!tracked) return tracked.error();
  auto track = read_track(*tracked);
  if (!track) return track.error();
  track->head_model_file = text_of_path(project.options.shared.head_model);
  if (variant.change != nullptr) variant.change(*track, inputs->model);
  const auto track_hash = hash_file(*tracked);
  if (!track_hash) return track_hash.error();
  std::string maps;
  if (variant.maps && !project.options.fit.displacement.empty()) {
    const auto hash = detail_maps_hash(project.options.fit.displacement);
    if (!hash) return hash.error();
    maps = " maps " + *hash;
  }
  const std::string corrections = corrections_hash(project) + project.options.matte.matting_network.string() +
                                  person_network_hash(project.options.shared.person_network);
  Result<fs::path> mattes = project.folder;
  const bool others = variant.change != nullptr && !variant.same_mattes;
  if (!variant.step.empty() || others || !variant.person_network)
    mattes = mattes_of_track(*inputs, *track,
                             *track_hash + corrections + (variant.change != nullptr ? name : std::string()),
                             folder, progress.stage(0.8, 1, "matte"), stop);
  if (!mattes) return mattes.error();
  // Named by a hash of its inputs, so that it never holds anything made from others.
  const std::string content =
      hash_text(fmt::format("{} {} {} {}{}", inputs->content, *track_hash, name, corrections, maps));
  return make_workplace(*inputs, folder / fmt::format("{}-{}.likeness", name, content.substr(0, 8)), *track,
                        *mattes, variant.maps);
}

}  // namespace likeness
