// A room is rendered like a head at the world's origin that no expression moves.
#include "core/render/room_picture.h"

namespace likeness {
namespace {

constexpr int kSamples = 24, kStrata = 16;  // a room's rays are longer than a head's
constexpr float kNothing = 0.5f;

}  // namespace

RoomScene make_room_scene(const FieldPart& room) {
  RoomScene scene;
  scene.alone.head = room;
  return scene;
}

Image8 room_picture(const RoomScene& room, const Camera& camera, RenderQuality quality) {
  RenderOptions options = render_options(quality);
  options.max_samples = kSamples;
  options.strata = kStrata;
  const RenderedFrame frame = render_frame(room.alone, camera, {}, options);
  return to_bytes(composite(frame.rgba, {}, Vec3f::Constant(kNothing)));
}

}  // namespace likeness
