// Plates and rooms beside wall_truth: see wall_truth.h.
#include "core/lab/truth/wall_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <system_error>

#include "core/base/check.h"
#include "core/camera/mosaic.h"
#include "core/capture/capture.h"
#include "core/image/metrics.h"
#include "core/image/srgb.h"
#include "core/lab/truth/truth_picture.h"
#include "core/matte/plate_file.h"
#include "core/project/project_views.h"
#include "core/render/room_picture.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

float linear(std::uint8_t value) { return linear_of_srgb(float(value) / 255); }
float encoded(float light) { return srgb_of_linear(std::clamp(light, 0.0f, 1.0f)); }

bool is_known(const Image8& known, std::size_t pixel) { return known.empty() || known.data[pixel] > 0; }

// The factor of a channel that brings `found` nearest to `truth`, least squares over known pixels.
std::array<double, 3> light_between(const Image8& found, const Image8& known, const Image8& truth) {
  std::array<double, 3> above{}, below{};
  for (std::size_t i = 0; i < truth.pixels(); ++i) {
    if (!is_known(known, i)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double a = linear(found.data[3 * i + c]), b = linear(truth.data[3 * i + c]);
      above[c] += a * b, below[c] += a * a;
    }
  }
  std::array<double, 3> factors{};
  for (std::size_t c = 0; c < 3; ++c) factors[c] = below[c] > 0 ? above[c] / below[c] : 1;
  return factors;
}

// What project and demo say, and where the project's background comes from.
struct WallStudy {
  Capture capture;
  WallBehind behind;
};

Result<WallStudy> open_walls(const Project& project) {
  WallStudy study;
  auto capture = read_capture(capture_path(project));
  if (!capture) return capture.error();
  study.capture = std::move(*capture);
  const auto cameras = read_cameras(cameras_path(project));
  if (!cameras) return cameras.error();
  FoundWall plate;
  if (auto read = read_project_plate(project, plate.rgb, plate.known); !read) return read.error();
  std::error_code ignored;
  const auto info = read_plate_info(plate_info_path(project));
  if (!info) return info.error();
  if (!plate.rgb.empty() && info->camera) {
    auto read = read_tracked_capture(project);
    if (!read) return read.error();
    const auto mosaic = std::make_shared<const Mosaic>(Mosaic{plate.rgb, plate.known, *info->camera});
    study.behind = [mosaic, read = std::make_shared<const TrackedCapture>(std::move(*read))](int frame) {
      const auto camera = picture_camera(read->capture, read->cameras, read->track, frame);
      FoundWall seen;
      if (camera) seen.rgb = mosaic_seen_by(*mosaic, *camera, &seen.known);
      return seen;
    };
    return study;
  }
  if (cameras->rests() && !plate.rgb.empty()) {
    study.behind = [plate](int) { return plate; };
    return study;
  }
  if (!fs::exists(room_path(project), ignored))
    return Error{ErrorCode::bad_input, "The project knows no background.",
                 "Run `likeness fit` on it first; a plate needs a camera that rests.",
                 project.folder.string()};
  const auto room = read_room(room_path(project));
  if (!room) return room.error();
  auto read = read_tracked_capture(project);
  if (!read) return read.error();
  const auto scene = std::make_shared<const RoomScene>(make_room_scene(*room));
  study.behind = [scene, read = std::make_shared<const TrackedCapture>(std::move(*read))](int frame) {
    const auto camera = picture_camera(read->capture, read->cameras, read->track, frame);
    return camera ? FoundWall{room_picture(*scene, *camera), {}} : FoundWall{};
  };
  return study;
}

std::vector<int> numbered_pictures(const fs::path& folder) {
  std::vector<int> frames;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    const std::string name = entry.path().stem().string();
    int frame = 0;
    const auto [end, fault] = std::from_chars(name.data(), name.data() + name.size(), frame);
    if (fault == std::errc() && end == name.data() + name.size() && entry.path().extension() == ".png")
      frames.push_back(frame);
  }
  std::ranges::sort(frames);
  return frames;
}

void add(WallRow& row, const WallErrors& errors, int& scored) {
  ++row.pictures;
  row.known_share += errors.known_share;
  if (!errors.psnr_db) return;
  ++scored;
  row.psnr_db = row.psnr_db.value_or(0) + *errors.psnr_db;
  row.psnr_own_light_db = row.psnr_own_light_db.value_or(0) + *errors.psnr_own_light_db;
}

Image8 both(const Image8& known, const Image8& mask) {
  Image8 result = mask;
  for (std::size_t i = 0; i < result.pixels(); ++i)
    result.data[i] = mask.data[i] > 127 && is_known(known, i) ? 255 : 0;
  return result;
}

}  // namespace

WallErrors compare_walls(const Image8& found, const Image8& known, const Image8& truth) {
  LIKENESS_CHECK(found.width == truth.width && found.height == truth.height, "%d x %d beside %d x %d",
                 found.width, found.height, truth.width, truth.height);
  WallErrors errors;
  std::size_t count = 0;
  double sum = 0, lit = 0;
  const std::array<double, 3> factors = light_between(found, known, truth);
  for (std::size_t i = 0; i < truth.pixels(); ++i) {
    if (!is_known(known, i)) continue;
    ++count;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint8_t ours = found.data[3 * i + c];
      const double wanted = truth.data[3 * i + c] / 255.0;
      sum += std::pow(ours / 255.0 - wanted, 2);
      lit += std::pow(double(encoded(float(factors[c]) * linear(ours))) - wanted, 2);
    }
  }
  errors.known_share = double(count) / double(std::max<std::size_t>(1, truth.pixels()));
  if (count == 0) return errors;
  // Eight bits say no more than their own rounding.
  const double least = 1 / (12 * 255.0 * 255.0);
  errors.psnr_db = psnr_from_mse(std::max(least, sum / double(3 * count)));
  errors.psnr_own_light_db = psnr_from_mse(std::max(least, lit / double(3 * count)));
  return errors;
}

Result<std::vector<WallRow>> study_walls(const Project& project, const fs::path& demo,
                                         const Progress& progress, std::stop_token stop) {
  const std::vector<int> frames = numbered_pictures(demo / "wall_truth");
  if (frames.empty())
    return Error{ErrorCode::bad_input, "The demo says nothing of the wall behind the person.",
                 "Make one with a camera: likeness demo FOLDER --camera resting", demo.string()};
  const auto study = open_walls(project);
  if (!study) return study.error();
  WallRow whole{"whole picture"}, hidden{"behind the person"};
  int whole_scored = 0, hidden_scored = 0;
  const SquareCrop& square = study->capture.crop;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(i) / double(frames.size()), fmt::format("frame {}", frames[i]));
    const FoundWall found = study->behind(frames[i]);
    if (found.rgb.empty()) continue;
    const fs::path name = fmt::format("{:06d}.png", frames[i]);
    const auto wall = read_truth_picture(demo / "wall_truth" / name, 3),
               mask = read_truth_picture(demo / "masks_truth" / name, 1);
    if (!wall) return wall.error();
    if (!mask) return mask.error();
    const auto cut = [&](const Image8& picture) {
      return resize(crop(picture, square.x, square.y, square.side, square.side), found.rgb.width,
                    found.rgb.height);
    };
    const Image8 truth = cut(*wall);
    add(whole, compare_walls(found.rgb, found.known, truth), whole_scored);
    add(hidden, compare_walls(found.rgb, both(found.known, cut(*mask)), truth), hidden_scored);
  }
  if (whole.pictures == 0)
    return Error{ErrorCode::bad_input, "The project knows the background of none of these frames.",
                 "Run `likeness fit` on it first.", project.folder.string()};
  for (const auto& [row, scored] : {std::pair(&whole, whole_scored), std::pair(&hidden, hidden_scored)}) {
    row->known_share /= row->pictures;
    if (!row->psnr_db) continue;
    *row->psnr_db /= scored, *row->psnr_own_light_db /= scored;
  }
  progress.report(1);
  return std::vector<WallRow>{whole, hidden};
}

}  // namespace likeness
