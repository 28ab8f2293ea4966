// Where the person is in frames of a real clip, as somebody drew it by hand: the truth of mattes where no
// renderer knows it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// Corners in source pixels, closed by itself; (0, 0) is the corner of the top left pixel, whose centre is
// (0.5, 0.5). Along the picture's border corners lie on it.
using Polygon = std::vector<Vec2d>;

struct PersonOutline {
  int frame = 0;  // number in the source (core/video/decode.h)
  std::vector<Polygon> person,
      holes;  // all that is seen of the person, with what they wear; what shows through
  std::vector<Polygon> head, head_holes;  // the head with its hair, without neck and torso
  std::vector<Polygon> unsure;            // where nobody can tell by eye: veils of hair, blur
};

struct PersonMarks {
  std::string clip;           // its file's name, for people
  std::string video_hash;     // hash_video of it
  int width = 0, height = 0;  // px of the source, rotation applied
  std::vector<PersonOutline> frames;
};

// {"version": 1, "clip": "a.mp4", "video_hash": "...", "size": [512, 512], "frames": [{"frame": 8,
// "person": [[[x, y], ...], ...], "holes": [...], "head": [...], "head_holes": [...], "unsure": [...]}]}.
// Holes and "unsure" may be absent; "how" is for people. Refused by name: points outside the picture,
// polygons of fewer than three points, a frame twice or without a person or head.
Result<PersonMarks> read_person_marks(const std::filesystem::path& path);

// Pictures of the source's size, one channel, 0 or 255; a pixel is in where its centre is.
struct DrawnPerson {
  Image8 person, head;
  Image8 unsure;       // drawn as such, and within kUnsureOfHead * head_width_px of the person's drawn edge:
                       // nobody draws better
  Image8 head_nearer;  // pixels nearer to the head than to the rest of the person, within it and beside it
  double head_width_px = 0;
};
inline constexpr double kUnsureOfHead = 0.01;
DrawnPerson draw_marks(const PersonOutline& outline, int width, int height);

}  // namespace likeness
