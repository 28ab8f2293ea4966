// Cameras of a folder of photographs: in file-name order first, as phones number them, every pair where that
// fails.
#include <fmt/format.h>

#include <algorithm>

#include "core/base/hash.h"
#include "core/camera/align.h"
#include "core/camera/colmap.h"
#include "core/camera/workplace.h"
#include "core/video/photos.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kMostForAllPairs = 150;
constexpr double kEnoughPhotos = 0.8;

std::string photo_picture_name(std::size_t index) { return fmt::format("{:06}.png", index); }

struct WrittenPhotos {
  int width = 0, height = 0;    // of each
  std::vector<Error> left_out;  // damaged ones, and those of another size
};

// Decodes every photograph (colmap reads broken files without a word) and writes it reduced.
Result<WrittenPhotos> write_photos(const std::vector<fs::path>& photos, const PersonMask& person,
                                   const fs::path& work, int width, const Progress& progress,
                                   std::stop_token stop) {
  const bool ready = pictures_ready(work);
  WrittenPhotos pictures;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (stop.stop_requested()) return cancelled_error();
    auto photo = read_photo(photos[i]);
    if (photo && pictures.width == 0) pictures.width = photo->width, pictures.height = photo->height;
    if (photo && (photo->width != pictures.width || photo->height != pictures.height))
      photo = other_size_error(photos[i], *photo, pictures.width, pictures.height);
    if (!photo) {
      pictures.left_out.push_back(photo.error());
      if (!may_leave_out(photo.error(), pictures.left_out.size(), photos.size())) return photo.error();
      continue;
    }
    if (ready) break;
    const Image8 mask = person ? person(int(i), *photo) : Image8();
    auto written = write_picture(work, photo_picture_name(i), *photo, mask, std::min(width, pictures.width));
    if (!written) return written.error();
    progress.report(double(i + 1) / double(photos.size()), photos[i].filename().string());
  }
  if (!ready)
    if (auto marked = mark_pictures_ready(work); !marked) return marked.error();
  return pictures;
}

// What identifies the inputs: names, sizes and times of the files, not gigabytes of content.
std::string inputs_of(const std::vector<fs::path>& photos, const AlignOptions& options, bool masked) {
  std::string inputs =
      fmt::format("radial {} {} {} {}", options.colmap_width, options.colmap_features, options.seed, masked);
  for (const auto& photo : photos) {
    std::error_code ignored;
    inputs += fmt::format("\n{} {} {}", photo.string(), fs::file_size(photo, ignored),
                          fs::last_write_time(photo, ignored).time_since_epoch().count());
  }
  return hash_text(inputs);
}

}  // namespace

Result<AlignResult> align_photos(const fs::path& folder, const PersonMask& person, const fs::path& work,
                                 const AlignOptions& options, const Progress& progress,
                                 std::stop_token stop) {
  const auto photos = list_photos(folder);
  if (!photos) return photos.error();
  if (auto ready = prepare_work_folder(work, inputs_of(*photos, options, bool(person))); !ready)
    return ready.error();
  const auto pictures =
      write_photos(*photos, person, work, options.colmap_width, progress.stage(0, 0.1, "photographs"), stop);
  if (!pictures) return pictures.error();

  ColmapOptions colmap;
  colmap.program = options.colmap;
  colmap.features = options.colmap_features;
  colmap.seed = options.seed;
  colmap.enough = kEnoughPhotos;
  colmap.max_for_all_pairs = kMostForAllPairs;
  const auto model = solve_colmap(work, colmap, progress.stage(0.1, 1, "structure from motion"), stop);
  if (!model) return model.error();
  AlignResult result;
  for (const auto& photo : *photos) result.photos.push_back(photo.filename().string());
  result.cameras.kind = CameraKind::walking;
  result.cameras.scale = CameraScale::arbitrary;
  result.frames = int(photos->size());
  result.registered = int(model->images.size());
  for (const auto& image : model->images) {
    const Intrinsics& small = model->cameras.at(image.camera);
    const double sx = double(pictures->width) / small.width, sy = double(pictures->height) / small.height;
    Camera camera{std::atoi(image.name.c_str()), small, image.cam_from_world};
    camera.intrinsics.width = pictures->width;
    camera.intrinsics.height = pictures->height;
    camera.intrinsics.fx *= sx, camera.intrinsics.cx *= sx;
    camera.intrinsics.fy *= sy, camera.intrinsics.cy *= sy;
    result.cameras.cameras.push_back(camera);
    result.cameras.reprojection_px = mean_reprojection_px(*model) * sx;
  }
  result.evidence = fmt::format("moving: {} photographs, {} placed, mean reprojection error {:.2f} px.",
                                result.frames, result.registered, result.cameras.reprojection_px);
  if (!pictures->left_out.empty()) {
    const Error left_out = left_out_error(pictures->left_out, photos->size());
    result.warnings.push_back(left_out.what + " " + left_out.fix);
  }
  if (result.registered < result.frames)
    result.warnings.push_back(fmt::format("{} of {} photographs could not be placed; they are left out.",
                                          result.frames - result.registered, result.frames));
  progress.report(1);
  return result;
}

}  // namespace likeness
