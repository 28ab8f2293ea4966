// The room behind a person filmed by a moving camera: its file, and pictures of it from anywhere.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/render/avatar.h"
#include "core/render/render.h"

namespace likeness {

// room.bin: versioned, checksummed, whole or not at all.
Result<void> write_room(const std::filesystem::path& path, const FieldPart& room);
Result<FieldPart> read_room(const std::filesystem::path& path);

// A room ready for pictures; its field is copied.
struct RoomScene {
  Avatar alone;  // the room in the place of the head, and nothing else
};
RoomScene make_room_scene(const FieldPart& room);

// (h, w, 3) sRGB-encoded. Where there is no sample, grey.
Image8 room_picture(const RoomScene& room, const Camera& camera,
                    RenderQuality quality = RenderQuality::final);

}  // namespace likeness
