// See export_order.h.
#include "ui/studio/export_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "core/base/files.h"
#include "core/direct/direct_avatar.h"
#include "core/export/head_mesh.h"
#include "core/export/write_out.h"
#include "core/render/camera_path.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

bool moves(const ExportChoice& choice) {
  return choice.kind == ExportKind::orbit || choice.kind == ExportKind::performance ||
         choice.kind == ExportKind::driven;
}

bool performs(const ExportChoice& choice) {
  return choice.kind == ExportKind::performance || (choice.kind == ExportKind::mesh && choice.moving);
}

// plate_holds: the camera stands where the clip's camera rested.
std::string background_of(const ExportChoice& choice, bool plate_holds) {
  const auto byte = [](float part) { return int(std::lround(255 * std::clamp(part, 0.f, 1.f))); };
  switch (choice.ground) {
    case ExportGround::room:
      return plate_holds ? "plate" : "room";
    case ExportGround::light:
      return "#e6e6e6";
    case ExportGround::dark:
      return "#1c1f26";
    case ExportGround::colour:
      return fmt::format("#{:02x}{:02x}{:02x}", byte(choice.colour[0]), byte(choice.colour[1]),
                         byte(choice.colour[2]));
    case ExportGround::picture:
      return choice.picture.string();
    case ExportGround::transparent:
      return {};
  }
  return {};
}

// camera_rests: it stays where the capture's camera was.
FilmOptions film_options(const ExportOrder& order, bool camera_rests, const RenderPlace& place) {
  const ExportChoice& choice = order.choice;
  FilmOptions options;
  options.out = order.out, options.place = place;
  options.frames_per_second = choice.frames_per_second;
  if (!makes_pictures(choice)) return options;
  options.alpha = choice.ground == ExportGround::transparent;
  options.background = background_of(choice, camera_rests && !order.contents->avatar->avatar.plate.empty());
  options.mark = choice.mark;
  options.width = order.contents->avatar->avatar.size * choice.times;
  return options;
}

Result<Performance> chosen_performance(const ExportOrder& order) {
  if (order.choice.performance.empty()) return *order.performance;
  return read_performance(order.choice.performance);
}

// Whether a channel takes the camera from where the clip's camera rested: zoom and shift do not.
bool moves_camera(const std::string& channel) {
  return channel == "camera yaw" || channel == "camera pitch" || channel == "camera distance";
}

// Whether the performance leaves the camera there: no key takes it away.
bool camera_stands(const Performance& performance) {
  return std::ranges::all_of(performance.channels, [](const auto& channel) {
    return !moves_camera(channel.first) || std::ranges::all_of(channel.second, [&](const Key& key) {
      return key.value == rest_value(channel.first);
    });
  });
}

bool camera_stands(const ViewPoint& view) { return view.yaw == 0 && view.pitch == 0 && view.distance == 1; }

// Degrees from the view on screen: what nobody chose stays within what the avatar's orbits are.
ValueRange orbit_swing(const ExportChoice& choice, const ProjectAvatar& avatar, float from) {
  if (choice.half_angle_deg) return {-float(*choice.half_angle_deg), float(*choice.half_angle_deg)};
  const ValueRange all = orbit_of(avatar);
  return {std::min(0.f, all.low - from), std::max(0.f, all.high - from)};
}

// The moment on screen, from the view on screen, or swinging to both sides of it.
Film posed_film(const ExportOrder& order) {
  const ExportChoice& choice = order.choice;
  const bool orbit = choice.kind == ExportKind::orbit;
  const int frames = orbit ? std::max(2, int(std::lround(choice.seconds * choice.frames_per_second))) : 1;
  const float from = value_at(*order.performance, "camera yaw", order.time_s);
  const ValueRange swing = orbit ? orbit_swing(choice, *order.contents->avatar, from) : ValueRange{};
  std::vector<Camera> cameras;
  std::vector<AvatarPose> poses;
  for (const double yaw : orbit_yaws(steady_times(frames, choice.frames_per_second), swing.low, swing.high)) {
    Performance seen = *order.performance;
    seen.channels["camera yaw"] = {{0, from + float(yaw)}};
    DirectedMoment moment = direct_moment(order.contents->avatar->directed, seen, order.time_s);
    cameras.push_back(moment.camera);
    poses.push_back(std::move(moment.pose));
  }
  return listed_film(std::move(cameras), std::move(poses));
}

// Whether a still's camera stands where the clip's rested.
bool stands_there(const ExportOrder& order) {
  return order.choice.kind == ExportKind::still &&
         camera_stands(
             direct_moment(order.contents->avatar->directed, *order.performance, order.time_s).view);
}

ExportOrder with_possible_ground(ExportOrder order) {
  const ViewPoint view =
      direct_moment(order.contents->avatar->directed, *order.performance, order.time_s).view;
  order.choice.ground =
      settled(order.choice, directed_scene(*order.performance, view), order.contents->avatar->avatar).ground;
  return order;
}

// A file's performance is known only when it is read.
ExportOrder with_known_ground(ExportOrder order, const Performance& performance) {
  ExportChoice known = order.choice;
  known.performance.clear();
  order.choice.ground =
      settled(known, directed_scene(performance, {}), order.contents->avatar->avatar).ground;
  return order;
}

Result<std::string> perform(const ExportOrder& order, const RenderPlace& place, const OpenedAvatar& opened,
                            const Progress& progress, std::stop_token stop) {
  auto performance = chosen_performance(order);
  if (!performance) return performance.error();
  performance->frames_per_second = order.choice.frames_per_second;
  const ExportOrder possible = with_known_ground(order, *performance);
  const auto frames = write_performed(
      opened, *performance, film_options(possible, camera_stands(*performance), place), progress, stop);
  if (!frames) return frames.error();
  std::string words = fmt::format("{} frames", *frames);
  if (possible.choice.ground != order.choice.ground)
    words +=
        ", before a light background: the performance moves the camera, and the filmed room is known "
        "from one place only";
  return words;
}

Result<std::string> follow_clip(const ExportOrder& order, const RenderPlace& place,
                                const OpenedAvatar& opened, const Progress& progress, std::stop_token stop) {
  DriveRequest request;
  request.video = order.choice.clip;
  request.landmark_model = order.contents->project.options.shared.landmark_model;
  request.options.move_head = !order.choice.keep_head;
  request.options.gains = order.gains;
  // As in a live drive, painted attributes stay as the sliders have them.
  const ProjectAvatar& avatar = *order.contents->avatar;
  const AvatarPose directed = direct_moment(avatar.directed, *order.performance, order.time_s).pose;
  for (std::size_t a = 0; a < directed.attributes.size(); ++a)
    request.attributes.emplace_back(avatar.avatar.attributes[a].name, directed.attributes[a]);
  const auto written = write_driven(opened, request, film_options(order, true, place),
                                    order.choice.side_by_side, progress, stop);
  if (!written) return written.error();
  std::string words = fmt::format("{} frames, {}", written->frames,
                                  written->sound.copied ? "with the clip's sound" : "without sound");
  if (written->bridged > 0)
    words +=
        fmt::format("; in {} the driver's face was lost and the motion is interpolated", written->bridged);
  for (const std::string& warning : written->warnings) words += ". " + warning;
  return words;
}

}  // namespace

bool makes_pictures(const ExportChoice& choice) { return choice.kind != ExportKind::mesh; }

DirectedScene directed_scene(const Performance& performance, const ViewPoint& view) {
  return {view, camera_stands(performance)};
}

bool room_possible(const ExportChoice& choice, const DirectedScene& scene, const Avatar& avatar) {
  if (avatar.room) return true;
  if (avatar.plate.empty() || choice.kind == ExportKind::orbit) return false;
  if (choice.kind == ExportKind::still) return camera_stands(scene.view);
  return choice.kind != ExportKind::performance || !choice.performance.empty() || scene.camera_stands;
}

ExportChoice with_wishes(const ExportChoice& wished, const ExportChoice& shown, ExportChoice asked) {
  const auto keep = [&](auto ExportChoice::*what) {
    if (asked.*what == shown.*what) asked.*what = wished.*what;
  };
  keep(&ExportChoice::ground), keep(&ExportChoice::form), keep(&ExportChoice::mesh);
  keep(&ExportChoice::side_by_side);
  return asked;
}

ExportChoice settled(ExportChoice choice, const DirectedScene& scene, const Avatar& avatar) {
  if (choice.ground == ExportGround::room && !room_possible(choice, scene, avatar))
    choice.ground = ExportGround::light;
  if (choice.ground == ExportGround::transparent && moves(choice)) choice.form = ExportForm::pictures;
  if (choice.ground == ExportGround::transparent) choice.side_by_side = false;
  if (choice.moving) choice.mesh = MeshForm::glb;  // a PLY holds one moment
  choice.times = std::clamp(choice.times, 1, kMostTimes);
  return choice;
}

std::string export_file_name(const ExportChoice& choice, int number) {
  const auto named = [&](const char* name, const char* ending) {
    return fmt::format("{}-{:03}{}", name, number, ending);
  };
  const char* moving = choice.form == ExportForm::film ? ".mp4" : "";
  switch (choice.kind) {
    case ExportKind::still:
      return named("still", ".png");
    case ExportKind::orbit:
      return named("orbit", moving);
    case ExportKind::performance:
      return named("performance", moving);
    case ExportKind::driven:
      return named("driven", moving);
    case ExportKind::mesh:
      return named("head", choice.mesh == MeshForm::glb ? ".glb" : ".ply");
  }
  return named("export", "");
}

Result<void> check_order(const ExportOrder& order) {
  const ExportChoice& choice = order.choice;
  const auto is_file = [](const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
  };
  if (choice.kind == ExportKind::driven && !is_file(choice.clip))
    return Error{ErrorCode::not_found, "No clip is chosen to drive the avatar.", "Choose one first.",
                 choice.clip.string()};
  const bool own = choice.performance.empty();
  if (performs(choice) && (own ? order.performance->channels.empty() : !is_file(choice.performance)))
    return Error{ErrorCode::not_found, "There is no performance yet.",
                 "Direct one in the Direct step, or choose a performance file.", choice.performance.string()};
  if (makes_pictures(choice) && choice.ground == ExportGround::picture && !is_file(choice.picture))
    return Error{ErrorCode::not_found, "No picture is chosen for the background.",
                 "Choose one, or another background.", choice.picture.string()};
  return {};
}

Result<Image8> first_picture(const ExportOrder& order) {
  constexpr int kMostPixels = 320;
  const ProjectAvatar& avatar = *order.contents->avatar;
  Performance performance = *order.performance;
  ExportOrder first = order;
  double time_s = order.time_s;
  if (performs(order.choice)) {
    auto chosen = chosen_performance(order);
    if (!chosen) return chosen.error();
    performance = std::move(*chosen), time_s = 0;
    first = with_known_ground(std::move(first), performance);
  }
  const DirectedMoment moment = direct_moment(
      avatar.directed, order.choice.kind == ExportKind::driven ? Performance{} : performance, time_s);
  first = with_possible_ground(std::move(first));
  const bool stands = order.choice.kind != ExportKind::orbit && camera_stands(moment.view);
  FilmOptions options = film_options(first, stands, {});
  options.out = "first.png", options.quality = RenderQuality::preview;
  options.width = std::min(avatar.avatar.size, kMostPixels);
  return film_picture(avatar.avatar, avatar.rig, moment.camera, moment.pose, options);
}

Result<std::string> write_order(const ExportOrder& asked, const Progress& progress, std::stop_token stop) {
  const ExportOrder order = with_possible_ground(asked);
  const bool folder = order.out.extension().empty();
  std::error_code failure;
  // Made to be given away: as open as the umask says, in a project that is its owner's alone, too.
  fs::create_directories(order.out.parent_path(), failure);
  if (const auto made = make_writable_folder(order.out.parent_path()); !made) return made.error();
  failure.clear();
  // What has appeared there since the export was ordered is not ours to overwrite.
  if (folder ? !fs::create_directory(order.out, failure) && !failure : fs::exists(order.out, failure))
    return Error{ErrorCode::bad_input, fmt::format("{} already exists.", order.out.filename().string()),
                 "Export it again: it will be given another name.", order.out.string()};
  if (failure) return file_error(order.out, "create", failure.value());
  const ProjectAvatar& avatar = *order.contents->avatar;
  const OpenedAvatar opened{order.contents->project, avatar.avatar, *avatar.model, avatar.hash};
  std::string note;  // why the processor took over
  RenderPlace place{nullptr, true, [&](const std::string& text) { note = ". " + text; }};
  if (order.open && makes_pictures(order.choice)) {
    auto backend = order.open();
    if (backend)
      place.backend = std::move(*backend);
    else
      place.say(continuing_on_processor(backend.error()));
  }
  auto written = [&]() -> Result<std::string> {
    if (order.choice.kind == ExportKind::driven) return follow_clip(order, place, opened, progress, stop);
    if (performs(order.choice)) return perform(order, place, opened, progress, stop);
    const auto frames = write_posed(opened, posed_film(order),
                                    film_options(order, stands_there(order), place), progress, stop);
    if (!frames) return frames.error();
    return *frames == 1 ? std::string("written") : fmt::format("{} frames", *frames);
  }();
  if (!written)
    fs::remove_all(order.out, failure);  // half a sequence is of no use
  else
    *written += note;
  return written;
}

}  // namespace likeness::ui
