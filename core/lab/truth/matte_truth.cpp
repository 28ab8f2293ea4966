// True masks cut to the project's crop, and the comparison: see matte_truth.h.
#include "core/lab/truth/matte_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "core/base/files.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/lab/truth/truth_picture.h"
#include "core/matte/person_network.h"
#include "core/project/make_mattes.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/stage_inputs.h"
#include "core/scene/track.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kBeside = 2;  // px: the border is this wide to either side of the mixed pixels
constexpr int kMixedLow = 6, kMixedHigh = 249;  // of 255

// 255 within kBeside px of a pixel that is mixed, or where the matte steps from one side to the other.
std::vector<std::uint8_t> border_of(const Image8& truth) {
  std::vector<std::uint8_t> edge(truth.pixels(), 0), border(truth.pixels(), 0);
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x) {
      const int own = *truth.at(x, y);
      const bool mixed = own > kMixedLow && own < kMixedHigh;
      const bool step = (x + 1 < truth.width && std::abs(*truth.at(x + 1, y) - own) > 127) ||
                        (y + 1 < truth.height && std::abs(*truth.at(x, y + 1) - own) > 127);
      if (mixed || step) edge[std::size_t(y) * std::size_t(truth.width) + std::size_t(x)] = 255;
    }
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x) {
      if (!edge[std::size_t(y) * std::size_t(truth.width) + std::size_t(x)]) continue;
      for (int v = std::max(0, y - kBeside); v <= std::min(truth.height - 1, y + kBeside); ++v)
        for (int u = std::max(0, x - kBeside); u <= std::min(truth.width - 1, x + kBeside); ++u)
          border[std::size_t(v) * std::size_t(truth.width) + std::size_t(u)] = 255;
    }
  return border;
}

bool same_view(const Camera& a, const Camera& b) {
  const Intrinsics &k = a.intrinsics, &l = b.intrinsics;
  return a.cam_from_world.isApprox(b.cam_from_world, 1e-9) && k.fx == l.fx && k.cx == l.cx && k.cy == l.cy;
}

// Whether the camera rests at a frame: a neighbouring frame has the same true camera.
bool rests(const CameraSet& truth, int frame) {
  if (truth.rests()) return true;
  const Camera* own = find_camera(truth, frame);
  for (const int other : {frame - 1, frame + 1}) {
    const Camera* beside = find_camera(truth, other);
    if (own && beside && same_view(*own, *beside)) return true;
  }
  return false;
}

void add(MatteRow& row, int frame, const MatteErrors& errors) {
  row.iou_mean += errors.iou;
  row.border += errors.border;
  row.hair += errors.hair;
  if (errors.iou < row.iou_worst) row.iou_worst = errors.iou, row.worst_frame = frame;
  ++row.frames;
}

}  // namespace

MatteErrors compare_mattes(const Image8& found, const Image8& truth, double hair_above) {
  MatteErrors errors;
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < truth.pixels(); ++i) {
    const bool a = found.data[i] > 127, b = truth.data[i] > 127;
    both += a && b, either += a || b;
  }
  errors.iou = either ? double(both) / double(either) : 1;
  const auto border = border_of(truth);
  double sum = 0, hair_sum = 0;
  std::size_t count = 0, hair_count = 0;
  for (std::size_t i = 0; i < border.size(); ++i) {
    if (!border[i]) continue;
    const double difference = std::abs(int(found.data[i]) - int(truth.data[i])) / 255.0;
    sum += difference, ++count;
    if (double(i / std::size_t(truth.width)) < hair_above) hair_sum += difference, ++hair_count;
  }
  errors.border = count ? sum / double(count) : 0;
  errors.hair = hair_count ? hair_sum / double(hair_count) : 0;
  return errors;
}

namespace {

// masks: the folder of the mattes that are compared.
Result<std::vector<MatteRow>> compare_masks(const Project& project, const fs::path& masks,
                                            const fs::path& demo, const std::string& network,
                                            const Progress& progress, std::stop_token stop) {
  const auto capture = read_capture(capture_path(project));
  if (!capture) return capture.error();
  const auto cameras = read_cameras(demo / "cameras_truth.json");
  if (!cameras) return cameras.error();
  const auto track = read_track(demo / "track_truth.json");
  if (!track) return track.error();
  MatteRow moving{network, "camera moves"}, resting{network, "camera rests"}, held_out{network, "held out"};
  const SquareCrop& square = capture->crop;
  std::size_t done = 0;
  for (const CaptureFrame& frame : capture->frames) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(++done) / double(capture->frames.size()), fmt::format("frame {}", frame.frame));
    const fs::path name = frame_name(frame.frame).filename();
    std::error_code ignored;
    if (!fs::exists(masks / name, ignored)) continue;  // refused, or its camera was lost
    const auto found = read_own_picture(masks, name.string(), capture->size, 1);
    if (!found) return found.error();
    const auto whole = read_truth_picture(demo / "masks_truth" / fmt::format("{:06d}.png", frame.frame), 1);
    if (!whole) return whole.error();
    Image8 truth =
        resize(crop(*whole, square.x, square.y, square.side, square.side), found->width, found->height);
    fill_outside(truth, capture->inside, 0);  // as in the matte: not known
    const TrackedFrame* tracked = find_tracked(*track, frame.frame);
    if (!tracked) continue;
    const double ears = 0.5 * (tracked->landmarks[0].y() + tracked->landmarks[16].y());
    const MatteErrors errors =
        compare_mattes(*found, truth, (ears - square.y) * found->height / double(square.side));
    add(rests(*cameras, frame.frame) ? resting : moving, frame.frame, errors);
    if (frame.held_out) add(held_out, frame.frame, errors);
  }
  std::vector<MatteRow> rows;
  for (MatteRow* row : {&moving, &resting, &held_out}) {
    if (row->frames == 0) continue;
    row->iou_mean /= row->frames;
    row->border /= row->frames;
    row->hair /= row->frames;
    rows.push_back(*row);
  }
  if (rows.empty())
    return Error{ErrorCode::bad_input, "The project has no mattes.", "Run `likeness fit` on it first.",
                 project.folder.string()};
  progress.report(1);
  return rows;
}

}  // namespace

Result<std::vector<MatteRow>> study_mattes(const Project& project, const fs::path& demo,
                                           const Progress& progress, std::stop_token stop) {
  return compare_masks(project, project.folder / "masks", demo, "as it is", progress, stop);
}

Result<std::vector<MatteRow>> study_mattes_again(const Project& project, const fs::path& demo,
                                                 const std::string& network, const fs::path& folder,
                                                 const Progress& progress, std::stop_token stop) {
  MatteInputs inputs = stage_inputs(project.options).matte;
  inputs.choices.matting_network.clear();
  if (network == "none") inputs.person_network = "none";
  if (network == "person" && person_network_hash(inputs.person_network).empty())
    return Error{ErrorCode::missing_dependency, "There is no person network to make mattes with.",
                 "Run packaging/networks in the checkout, or name another network.", project.folder.string()};
  const auto read = read_tracked_capture(project);
  if (!read) return read.error();
  const auto model = head_model_at(inputs.head_model);
  if (!model) return model.error();
  if (const auto made = make_writable_folder(folder); !made) return made.error();
  std::error_code failure;
  fs::create_directory_symlink(fs::absolute(project.folder / "frames"), folder / "frames", failure);
  if (failure) return file_error(folder, "write", failure.value());
  const auto made =
      make_mattes(project, inputs, folder, *read, *model, progress.stage(0, 0.95, "mattes"), stop);
  if (!made) return made.error();
  return compare_masks(project, folder / "masks", demo, network, progress.stage(0.95, 1, "truth"), stop);
}

}  // namespace likeness
