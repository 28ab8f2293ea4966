// See sides_study.h.
#include "core/lab/beyond/sides_study.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/linalg.h"
#include "core/image/files.h"
#include "core/image/metrics.h"
#include "core/lab/beyond/contact_sheet.h"
#include "core/lab/beyond/measures.h"
#include "core/lab/score/evaluate.h"
#include "core/lab/score/frame_score.h"
#include "core/lab/score/held_out.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr double kRowWidth_deg = 10;
constexpr std::size_t kShownInside = 4, kShownOfRow = 2;  // frames in the contact sheet

double angle_of(const HeadView& view, SidesAngle angle) {
  switch (angle) {
    case SidesAngle::off:
      return angle_deg(view);
    case SidesAngle::yaw:
      return view.yaw_deg;
    case SidesAngle::pitch:
      return view.pitch_deg;
  }
  return 0;
}

SidesAngle main_direction(const HeadView& view) {
  return std::abs(view.yaw_deg) >= std::abs(view.pitch_deg) ? SidesAngle::yaw : SidesAngle::pitch;
}

bool is_beyond(const CaptureFrame& frame, const SideRange& sides) {
  return frame.held_out && frame.view && angle_deg(*frame.view) > sides.beyond_deg;
}
bool is_inside(const CaptureFrame& frame, const SideRange& sides) {
  return frame.held_out && frame.view && angle_deg(*frame.view) <= sides.inside_deg;
}

// What one picture showed beside its truth.
struct SeenFrame {
  double person_db = 0, head_db = 0, face_db = 0;
  Vec3d colour_off = Vec3d::Zero();  // of the face
  double iou = 0, specks = 0;
};
using SeenFrames = std::map<int, SeenFrame>;

SeenFrame see(const ScoredFrame& scored) {
  SeenFrame seen;
  const Regions& regions = scored.regions;
  seen.person_db = psnr_from_mse(scored.score.person_mse);
  seen.head_db = psnr_from_mse(scored.score.head_mse);
  seen.face_db = psnr_from_mse(scored.score.face_mse);
  seen.colour_off = mean_colour(scored.rendered, regions.face) - mean_colour(scored.truth, regions.face);
  seen.iou = mask_iou(scored.silhouette, regions.person);
  seen.specks = speck_share(scored.truth, scored.rendered, regions.head);
  return seen;
}

Vec3d mean_colour_off(const SeenFrames& seen, const std::vector<int>& numbers) {
  Vec3d sum = Vec3d::Zero();
  int count = 0;
  for (const int number : numbers)
    if (const auto own = seen.find(number); own != seen.end() && own->second.colour_off.allFinite())
      sum += own->second.colour_off, ++count;
  return count > 0 ? Vec3d(sum / count) : Vec3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

SidesScore score_of_frames(const SeenFrames& seen, const std::vector<int>& numbers, const Vec3d& inside_off) {
  SidesScore score;
  std::vector<const SeenFrame*> own;
  for (const int number : numbers)
    if (const auto at = seen.find(number); at != seen.end()) own.push_back(&at->second);
  score.frames = int(own.size());
  const auto mean = [&](double SeenFrame::*value) {
    double sum = 0;
    int count = 0;
    for (const SeenFrame* frame : own)
      if (std::isfinite(frame->*value)) sum += frame->*value, ++count;
    return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
  };
  score.score.psnr_head_db = mean(&SeenFrame::head_db);
  score.score.psnr_face_db = mean(&SeenFrame::face_db);
  score.score.psnr_person_db = mean(&SeenFrame::person_db);
  score.iou = mean(&SeenFrame::iou), score.specks = mean(&SeenFrame::specks);
  score.drift = (mean_colour_off(seen, numbers) - inside_off).cwiseAbs().maxCoeff();
  return score;
}

template <class Wanted>
std::vector<int> numbers_of(const Capture& capture, const Wanted& wanted) {
  std::vector<int> numbers;
  for (const CaptureFrame& frame : capture.frames)
    if (wanted(frame)) numbers.push_back(frame.frame);
  return numbers;
}

std::vector<int> spread(const std::vector<int>& numbers, std::size_t most) {
  std::vector<int> chosen;
  const std::size_t count = std::min(most, numbers.size());
  for (std::size_t i = 0; i < count; ++i)
    chosen.push_back(numbers[(2 * i + 1) * numbers.size() / (2 * count)]);
  return chosen;
}

}  // namespace

bool is_in_row(const SidesRow& row, const CaptureFrame& frame, const SideRange& sides) {
  if (!is_beyond(frame, sides)) return false;
  if (row.angle != SidesAngle::off && main_direction(*frame.view) != row.angle) return false;
  const double angle = angle_of(*frame.view, row.angle);
  return angle >= row.from_deg && angle < row.to_deg;
}

std::vector<SidesRow> sides_rows(std::span<const CaptureFrame> frames, const SideRange& sides,
                                 bool by_direction) {
  std::map<std::pair<SidesAngle, int>, std::vector<HeadView>> found;
  for (const CaptureFrame& frame : frames) {
    if (!is_beyond(frame, sides)) continue;
    const SidesAngle angle = by_direction ? main_direction(*frame.view) : SidesAngle::off;
    found[{angle, int(std::floor(angle_of(*frame.view, angle) / kRowWidth_deg))}].push_back(*frame.view);
  }
  std::vector<SidesRow> rows;
  for (const auto& [key, views] : found) {
    SidesRow& row = rows.emplace_back();
    row.angle = key.first;
    row.from_deg = kRowWidth_deg * key.second, row.to_deg = row.from_deg + kRowWidth_deg;
    for (const HeadView& view : views) {
      row.yaw_deg += view.yaw_deg / double(views.size());
      row.pitch_deg += view.pitch_deg / double(views.size());
    }
  }
  return rows;
}

Result<SidesStudy> study_sides(const Project& project, const fs::path& folder, const RenderPlace& place,
                               const Progress& progress, std::stop_token stop) {
  if (const auto imported = read_capture(capture_path(project)); imported && imported->split != Split::sides)
    return Error{ErrorCode::bad_input,
                 fmt::format("The project holds out frames by the split {}, which says nothing about sides.",
                             split_name(imported->split)),
                 "Build the clip into a project of its own with --split sides.", project.folder.string()};
  const auto set = read_held_out(project);
  if (!set) return set.error();
  const Capture& capture = set->capture;
  if (auto made = make_writable_folder(folder); !made) return made.error();

  SidesStudy study;
  study.sides = capture.sides;
  study.frames = int(capture.frames.size());
  for (const CaptureFrame& frame : capture.frames) study.trained += frame.used, study.apart += frame.apart;
  study.off = sides_rows(capture.frames, capture.sides, false);
  study.views = sides_rows(capture.frames, capture.sides, true);
  const std::vector<int> inside =
      numbers_of(capture, [&](const CaptureFrame& f) { return is_inside(f, capture.sides); });
  study.inside = int(inside.size());
  study.beyond = int(held_out_frames(capture).size()) - study.inside;
  std::vector<int> shown = spread(inside, kShownInside);
  for (const SidesRow& row : study.views)
    for (const int number :
         spread(numbers_of(capture, [&](const CaptureFrame& f) { return is_in_row(row, f, capture.sides); }),
                kShownOfRow))
      shown.push_back(number);

  SeenFrames seen;
  std::map<int, std::pair<Image8, Image8>> pictures;
  EvalOptions options;
  options.place = place;
  options.look = [&](const ScoredFrame& scored) {
    seen.emplace(scored.score.frame, see(scored));
    if (std::ranges::find(shown, scored.score.frame) != shown.end())
      pictures[scored.score.frame] = {scored.truth, scored.rendered};
  };
  const auto evaluation = evaluate(project, options, progress, stop);
  if (!evaluation) return evaluation.error();
  study.lost = evaluation->frames_lost;
  study.steps = set->avatar.steps, study.train_seconds = set->avatar.train_seconds;
  const Vec3d inside_off = mean_colour_off(seen, inside);
  study.within = score_of_frames(seen, inside, inside_off);
  for (std::vector<SidesRow>* rows : {&study.off, &study.views})
    for (SidesRow& row : *rows)
      row.score = score_of_frames(
          seen, numbers_of(capture, [&](const CaptureFrame& f) { return is_in_row(row, f, capture.sides); }),
          inside_off);

  ContactSheet sheet;
  for (const int number : shown)
    if (const auto own = pictures.find(number); own != pictures.end())
      sheet.add({&own->second.first, &own->second.second});
  if (const Image8 picture = sheet.picture(); !picture.empty())
    if (const auto written = write_image(folder / "sides.png", picture); !written) return written.error();
  return study;
}

}  // namespace likeness
