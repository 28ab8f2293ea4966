// Mattes enlarged to the source and counted: see marked_mattes.h.
#include "core/lab/truth/marked_mattes.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "core/image/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

struct Counts {
  std::size_t both = 0, either = 0;

  void add(bool a, bool b) { both += a && b, either += a || b; }
  double iou() const { return either ? double(both) / double(either) : 1; }
};

}  // namespace

MarkedMatte compare_with_marks(const Image8& found, const SquareCrop& crop, const DrawnPerson& drawn) {
  const Image8 matte = resize(found, crop.side, crop.side);
  Counts person, head, torso;
  for (int y = std::max(0, crop.y); y < std::min(drawn.person.height, crop.y + crop.side); ++y)
    for (int x = std::max(0, crop.x); x < std::min(drawn.person.width, crop.x + crop.side); ++x) {
      if (*drawn.unsure.at(x, y)) continue;
      const bool is = *matte.at(x - crop.x, y - crop.y) > 127, should = *drawn.person.at(x, y) > 0;
      person.add(is, should);
      (*drawn.head_nearer.at(x, y) ? head : torso).add(is, should);
    }
  return {0, person.iou(), head.iou(), torso.iou()};
}

Result<MarkedMattes> study_marked_mattes(const Project& project, const PersonMarks& marks,
                                         const Progress& progress, std::stop_token stop) {
  const auto capture = read_capture(capture_path(project));
  if (!capture) return capture.error();
  if (capture->video_hash != marks.video_hash || capture->width != marks.width ||
      capture->height != marks.height)
    return Error{ErrorCode::bad_input,
                 fmt::format("The marks are of {}, not of the project's clip.", marks.clip),
                 "Give the marks of the clip that the project imported.", capture->video.string()};
  MarkedMattes result;
  for (std::size_t i = 0; i < marks.frames.size(); ++i) {
    if (stop.stop_requested()) return cancelled_error();
    const PersonOutline& outline = marks.frames[i];
    progress.report(double(i) / double(marks.frames.size()), fmt::format("frame {}", outline.frame));
    const fs::path path = project.folder / "masks" / frame_name(outline.frame).filename();
    std::error_code ignored;
    if (!fs::exists(path, ignored)) {
      result.without_matte.push_back(outline.frame);
      continue;
    }
    const auto found = read_image(path);
    if (!found) return found.error();
    if (found->channels != 1)
      return Error{ErrorCode::bad_input, "A matte has more than one channel.", "Run `likeness fit` again.",
                   path.string()};
    MarkedMatte row =
        compare_with_marks(*found, capture->crop, draw_marks(outline, marks.width, marks.height));
    row.frame = outline.frame;
    result.frames.push_back(row);
  }
  if (result.frames.empty())
    return Error{ErrorCode::bad_input, "The project has no mattes of the marked frames.",
                 "Run `likeness fit` on it first.", project.folder.string()};
  progress.report(1);
  return result;
}

}  // namespace likeness
