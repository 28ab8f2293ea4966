// Film, build, pose, compare: see beyond_study.h.
#include "core/lab/beyond/beyond_study.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/quantile.h"
#include "core/face/landmarks.h"
#include "core/holds/asked.h"
#include "core/image/files.h"
#include "core/image/metrics.h"
#include "core/lab/beyond/contact_sheet.h"
#include "core/lab/beyond/measures.h"
#include "core/lab/beyond/registered_avatar.h"
#include "core/lab/beyond/truth_pictures.h"
#include "core/lab/score/frame_score.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/run_stages.h"
#include "core/render/ray_depth.h"
#include "core/render/render.h"
#include "core/scene/head_regions.h"
#include "core/synth/demo_capture.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr double kFilmWidth_mm = 36;
constexpr int kInsideFrames = 8;       // held-out frames
constexpr float kBrowMoves = 0.0003f;  // m by which an action moves the forehead, to be left out there
constexpr float kOpaque = 0.5f;
constexpr double kFilmed = 0.15, kBuilt = 0.75, kLooked = 0.95;  // of the progress

std::string film_words(const DemoOptions& film) {
  return fmt::format(
      "person {} light {} seed {} frames {} size {} x {} samples {} head {} of {} actions {} {}\n",
      film.person, film.light, film.seed, film.frames, film.width, film.height, film.samples_per_pixel,
      film.head_within_deg, kWidestTurn_deg, film.action_share, LIKENESS_VERSION);
}

// Film and true pictures of another film are removed; a film without its words is not finished.
Result<void> film_person(const DemoOptions& film, const fs::path& folder, const Progress& progress,
                         std::stop_token stop) {
  const std::string words = film_words(film);
  const auto filmed = read_text(folder / "film.txt");
  if (filmed && *filmed == words && path_exists(folder / "demo.mp4")) return {};
  std::error_code ignored;
  fs::remove_all(folder / "truth", ignored), fs::remove(folder / "film.txt", ignored);
  if (auto written = write_demo_capture(folder, film, progress, stop); !written) return written;
  return write_text(folder / "film.txt", words);
}

// All that pictures are made and compared with.
struct Bench {
  const Avatar& avatar;
  AvatarRig rig;
  const Registration& registration;
  const FaceDetector& detector;
  RenderOptions quality = render_options(RenderQuality::final);
};

struct Compared {
  Image8 picture;  // before the true room
  Image8 alpha;    // 255 where the avatar is
  FrameScore score;
  double ssim = 0, gmsd = 0, specks = 0;
};

Compared compare(const Bench& bench, const TruthPicture& truth) {
  const PosedShot posed = pose_as(bench.registration, bench.avatar, truth.shot);
  const RenderedFrame frame =
      render_frame(bench.avatar, posed.camera, pose_avatar(bench.rig, posed.pose), bench.quality);
  Compared compared;
  compared.picture = to_bytes(composite(frame.rgba, truth.room));
  compared.alpha = Image8(frame.rgba.width, frame.rgba.height, 1);
  for (std::size_t i = 0; i < compared.alpha.data.size(); ++i)
    compared.alpha.data[i] = frame.rgba.data[4 * i + 3] > kOpaque ? 255 : 0;
  const Image a = to_float(truth.rgb), b = to_float(compared.picture);
  compared.score = score_picture(a, b, truth.regions, 0);
  compared.ssim = ssim(a, b), compared.gmsd = gmsd(a, b);
  compared.specks = speck_share(truth.rgb, compared.picture, truth.regions.head);
  return compared;
}

BeyondScore score_of(const Compared& c) {
  return {psnr_from_mse(c.score.head_mse), psnr_from_mse(c.score.face_mse), psnr_from_mse(c.score.person_mse),
          c.ssim, c.gmsd};
}

// Median over the true skin, along the ray, mm.
double depth_error_mm(const Bench& bench, const TruthPicture& truth) {
  const PosedShot posed = pose_as(bench.registration, bench.avatar, truth.shot);
  const RayDepths ends = ray_depths(bench.avatar, posed.camera, pose_avatar(bench.rig, posed.pose));
  std::vector<double> errors;
  const Registration& r = bench.registration;
  // The avatar's face may stand farther away as a whole.
  const double beyond = (r.farther * r.lens - 1) *
                        (truth.shot.camera.cam_from_world * truth.shot.world_from_head * r.true_face).norm();
  for (std::size_t i = 0; i < truth.depth.size(); ++i)
    if (truth.skin.data[i] != 0 && ends.alpha[i] > kOpaque)
      errors.push_back(1000 * std::abs(r.scale * ends.metres[i] - beyond - truth.depth[i]));
  return errors.empty() ? std::numeric_limits<double>::quiet_NaN() : median(std::move(errors));
}

// Whether the skin above the brows is moved by any of the actions.
bool moves_forehead(const HeadModel& model, const HeadShape& shape, const AskedAction& asked,
                    float brow_line) {
  Articulation face = neutral_articulation(model);
  perform_asked(model, asked, face);
  const std::vector<Vec3f> posed = pose_head(model, shape, face);
  const HeadRegions regions = head_regions(model);
  std::vector<std::uint8_t> skin(regions.face.size());
  for (std::size_t f = 0; f < skin.size(); ++f) skin[f] = regions.face[f] && regions.skin[f];
  return std::ranges::any_of(region_vertices(model, skin), [&](int v) {
    const Vec3f& at = shape.vertices[std::size_t(v)];
    return at.y() > brow_line && (posed[std::size_t(v)] - at).norm() > kBrowMoves;
  });
}

std::string view_name(const AskedView& view) {
  return fmt::format("yaw{:+.0f}_pitch{:+.0f}", view.yaw, view.pitch);
}

struct Inputs {
  const Project& project;
  const Capture& capture;
  TruthCamera& truth;
  const fs::path& folder;
  const Progress& progress;
  std::stop_token stop;
};

Result<void> look_inside(const Bench& bench, Inputs& in, BeyondStudy& study) {
  const std::set<int> held_out = held_out_frames(in.capture);
  const std::vector<int> frames(held_out.begin(), held_out.end());
  const int count = std::min(kInsideFrames, int(frames.size()));
  BeyondScore sum{0, 0, 0, 0, 0};
  for (int i = 0; i < count; ++i) {
    const int frame = frames[std::size_t(i) * frames.size() / std::size_t(count)];
    const auto truth = in.truth.take(fmt::format("frame{}", frame), in.truth.of_frame(frame), in.stop);
    if (!truth) return truth.error();
    const Compared compared = compare(bench, *truth);
    const BeyondScore own = score_of(compared);
    *sum.psnr_head_db += *own.psnr_head_db / count, *sum.psnr_face_db += *own.psnr_face_db / count;
    *sum.psnr_person_db += *own.psnr_person_db / count;
    *sum.ssim += *own.ssim / count, *sum.gmsd += *own.gmsd / count;
    study.inside_specks += compared.specks / count;
  }
  study.inside = sum;
  return {};
}

Result<void> look_from_sides(const Bench& bench, Inputs& in, BeyondStudy& study) {
  ContactSheet sheet;
  std::optional<Vec3d> at_front;  // colour of the skin off the truth
  for (const AskedView& view : asked_views()) {
    in.progress.report(double(study.views.size()) / double(asked_views().size() + asked_actions().size()),
                       view_name(view));
    const auto truth =
        in.truth.take(view_name(view), in.truth.seen_from(in.truth.at_rest(), view.yaw, view.pitch), in.stop);
    if (!truth) return truth.error();
    const Compared compared = compare(bench, *truth);
    const Vec3d off = mean_colour(compared.picture, truth->skin) - mean_colour(truth->rgb, truth->skin);
    if (!at_front) at_front = off;
    BeyondView& own = study.views.emplace_back();
    own.yaw = view.yaw, own.pitch = view.pitch;
    own.score = score_of(compared);
    own.drift = (off - *at_front).cwiseAbs().maxCoeff();
    own.iou = mask_iou(compared.alpha, truth->regions.person);
    own.depth_mm = depth_error_mm(bench, *truth);
    own.landmarks_px = landmark_errors(bench.detector, truth->rgb, compared.picture).inner;
    own.specks = compared.specks;
    sheet.add({&truth->rgb, &compared.picture});
  }
  return write_image(in.folder / "views.png", sheet.picture());
}

Result<void> ask_actions(const Bench& bench, Inputs& in, BeyondStudy& study) {
  const HeadModel& model = in.truth.model();
  ContactSheet sheet;
  const auto rest = in.truth.take("rest", in.truth.at_rest(), in.stop);
  if (!rest) return rest.error();
  const Compared at_rest = compare(bench, *rest);
  for (const AskedAction& asked : asked_actions()) {
    const std::string name = fmt::format("{}_{:.1f}", asked.name, asked.amount);
    in.progress.report(double(asked_views().size() + study.actions.size()) /
                           double(asked_views().size() + asked_actions().size()),
                       name);
    Shot shot = in.truth.at_rest();
    perform_asked(model, asked, shot.articulation);
    const auto truth = in.truth.take(name, shot, in.stop);
    if (!truth) return truth.error();
    const Compared compared = compare(bench, *truth);
    BeyondAction& own = study.actions.emplace_back();
    own.name = asked.name, own.amount = asked.amount;
    own.score = score_of(compared);
    if (!moves_forehead(model, in.truth.shape(), asked, in.truth.brow_line()))
      own.forehead_change = mean_change(compared.picture, at_rest.picture, rest->forehead) -
                            mean_change(truth->rgb, rest->rgb, rest->forehead);
    own.specks = compared.specks;
    if (asked.amount == 1) sheet.add({&truth->rgb, &compared.picture});
  }
  return write_image(in.folder / "actions.png", sheet.picture());
}

}  // namespace

DemoOptions faint_film(int person, int seed) {
  DemoOptions film;
  film.person = person, film.seed = seed;
  film.camera = DemoCamera::resting;
  film.head_within_deg = 5, film.action_share = 0.4;
  film.lens_tag = true;
  return film;
}

Result<BeyondStudy> study_beyond_truth(const fs::path& folder, const BeyondOptions& options,
                                       const Progress& progress, std::stop_token stop) {
  if (auto made = make_writable_folder(folder / "truth"); !made) return made.error();
  if (auto filmed = film_person(options.film, folder, progress.stage(0, kFilmed, "filming"), stop); !filmed)
    return filmed.error();
  const auto truth = read_track_truth(folder);
  if (!truth) return truth.error();
  ProjectOptions chosen = options.project;
  chosen.shared.video = folder / "demo.mp4";
  const Intrinsics& lens = truth->cameras.cameras.front().intrinsics;
  chosen.align.lens_mm = kFilmWidth_mm * lens.fx / lens.width;
  auto project = open_or_create_project(folder / "person.likeness", chosen);
  if (!project) return project.error();
  if (auto built = run_stages(*project, Stage::train, progress.stage(kFilmed, kBuilt, "building"), {}, stop,
                              options.place);
      !built)
    return built.error();
  const auto tracked = read_tracked_capture(*project);
  if (!tracked) return tracked.error();
  const auto avatar = read_avatar(avatar_path(*project));
  if (!avatar) return avatar.error();
  const auto model = project_head_model(project->options);
  if (!model) return model.error();
  if (model->hash != truth->model.hash)
    return Error{ErrorCode::bad_input, "The truth is in the built-in head's terms, the avatar in another's.",
                 "Study it with the built-in head.", "study beyond"};
  const auto detector = FaceDetector::load(chosen.shared.landmark_model);
  if (!detector) return detector.error();
  const auto registration =
      register_to_truth(tracked->capture, tracked->cameras, tracked->track, *model, *truth);
  if (!registration) return registration.error();
  auto rig = make_rig(*avatar, *model);
  if (!rig) return rig.error();
  const Bench bench{*avatar, std::move(*rig), *registration, *detector};
  TruthCamera camera(options.film, *truth, tracked->capture, folder / "truth");
  const Progress looking = progress.stage(kBuilt, kLooked, "looking");
  Inputs inputs{*project, tracked->capture, camera, folder, looking, stop};
  BeyondStudy study;
  study.steps = avatar->steps, study.train_seconds = avatar->train_seconds;
  for (const auto look : {look_inside, look_from_sides, ask_actions})
    if (auto looked = look(bench, inputs, study); !looked) return looked.error();
  auto holds = check_holds(*avatar, *model, {options.place.backend, options.place.fall_back, {}}, {},
                           progress.stage(kLooked, 1, "what holds"), stop);
  if (!holds) return holds.error();
  study.holds = std::move(*holds);
  progress.report(1);
  return study;
}

}  // namespace likeness
