// See learn_room.h.
#include "core/project/learn_room.h"

#include <memory>
#include <utility>

#include <fmt/format.h>

#include "core/project/project_views.h"
#include "core/project/solved_points.h"
#include "core/render/room_picture.h"
#include "core/train/room.h"

namespace likeness {
namespace {

constexpr std::uint64_t kLastSteps = 2000;

Result<TrainingView> room_view(const Project& project, const TrackedCapture& read, const RoughMatte& matte) {
  const auto& [capture, cameras, track] = read;
  const TrackedFrame* tracked = find_tracked(track, matte.frame);
  const auto camera = picture_camera(capture, cameras, track, matte.frame);
  if (!tracked || !camera)
    return Error{ErrorCode::failed, "A frame has a matte, but no camera or head.",
                 "Run `likeness fit` again.", project.folder.string()};
  auto rgb =
      read_own_picture(project.folder / "frames", fmt::format("{:06}.png", matte.frame), capture.size, 3);
  if (!rgb) return rgb.error();
  TrainingView view;
  view.camera = *camera;
  view.pose = tracked->pose;
  view.rgb = std::move(*rgb);
  view.alpha = TiledMask(matte.alpha);
  view.has_plate = false;
  return view;
}

// What rendering the room behind a frame needs.
struct Look {
  RoomScene scene;
  TrackedCapture read;
  Look(RoomScene s, TrackedCapture r) : scene(std::move(s)), read(std::move(r)) {}
};

}  // namespace

LearnRoom room_learner(const Project& project, std::uint64_t seed, const TrackedCapture& read) {
  return [&project, seed, &read](const std::vector<RoughMatte>& mattes, RoomPass pass,
                                 const Progress& progress, std::stop_token stop) -> Result<RoomBehind> {
    if (mattes.size() < kMinRoomViews) return RoomBehind{};
    std::vector<TrainingView> views;
    for (const RoughMatte& matte : mattes) {
      auto view = room_view(project, read, matte);
      if (!view) return view.error();
      views.push_back(std::move(*view));
    }
    const auto points = solved_points(project, read.track);
    if (!points) return points.error();
    RoomOptions options;
    options.seed = seed;
    if (pass == RoomPass::last) options.steps = kLastSteps;
    auto room = train_room(views, room_cube(views, *points), options, progress, stop);
    if (!room && room.error().code == ErrorCode::not_found) return RoomBehind{};
    if (!room) return room.error();
    if (auto written = write_room(room_path(project), *room); !written) return written.error();
    round_tables(room->field);
    const auto look = std::make_shared<const Look>(make_room_scene(*room), read);
    return RoomBehind([look](int frame) {
      const auto camera = picture_camera(look->read.capture, look->read.cameras, look->read.track, frame);
      return camera ? room_picture(look->scene, *camera) : Image8{};
    });
  };
}

}  // namespace likeness
