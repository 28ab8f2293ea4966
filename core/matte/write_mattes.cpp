// Files of the matte stage: see write_mattes.h.
#include "core/matte/write_mattes.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "core/base/files.h"
#include "core/base/parallel.h"
#include "core/image/files.h"
#include "core/matte/plate_file.h"
#include "core/matte/regions.h"
#include "core/matte/replace_folder.h"
#include "core/matte/segment.h"

namespace likeness::matting {

namespace fs = std::filesystem;

namespace {

// Majority of a frame and its two neighbours, where these are the next frames of the video.
cv::Mat steady(const std::vector<Job>& jobs, const std::vector<cv::Mat>& cuts, std::size_t i) {
  if (!has_neighbours(jobs, i)) return cuts[i];
  // Only flicker is removed: a pixel changes only where both neighbours disagree with it over a small area.
  const cv::Mat agreed = (cuts[i - 1] & cuts[i + 1]) | (cuts[i] & (cuts[i - 1] | cuts[i + 1]));
  return agreed;
}

}  // namespace

Result<void> write_masks(const Stage& stage, const std::vector<Job>& jobs, const std::vector<cv::Mat>& cuts,
                         const Statistics& statistics, const fs::path& folder, const Progress& progress) {
  std::mutex mutex;
  std::optional<Error> fault;
  std::atomic<std::size_t> done = 0;
  parallel_for(jobs.size(), [&](std::size_t i) {
    if (stage.stop.stop_requested()) return;
    const fs::path mask = folder / frame_name(jobs[i].frame).filename();
    if (stage.kept && path_exists(mask)) return;  // by a run that was killed: files are written whole
    const auto picture = read_frame(stage, jobs[i].frame);
    Result<void> written = picture ? Result<void>() : Result<void>(picture.error());
    const auto network = picture ? network_alpha(stage, *picture) : Result<cv::Mat>(cv::Mat());
    if (!network) written = network.error();
    const auto brought = own_alpha(stage, jobs[i].frame, stage.size);
    if (!brought) written = brought.error();
    if (picture && network && brought) {
      cv::Mat person = steady(jobs, cuts, i).clone();
      hold_cut(person, strokes_on(stage, jobs[i], person.cols));
      if (person.cols != stage.size) {
        cv::resize(person, person, {stage.size, stage.size}, 0, 0, cv::INTER_LINEAR);
        person = person > 127;
      }
      const Plate room = room_of(stage, jobs[i], *picture, cv::Mat(person.size(), CV_8U, cv::Scalar(255)));
      const bool on_plate = jobs[i].on_plate && statistics.has_plate;
      const Plate own = on_plate ? plate_of_frame(stage, jobs[i], statistics.plate, stage.size) : Plate{};
      const Plate* plate = on_plate ? &own : room.colour.empty() ? nullptr : &room;
      const int radius = std::max(2, stage.size / 80);
      const cv::Mat alpha = network->empty() ? soften(*picture, person, plate, radius)
                                             : soften_by_network(*network, person, 2 * radius);
      Image8 out(stage.size, stage.size, 1);
      std::memcpy(out.data.data(), alpha.data, out.data.size());
      if (!brought->empty()) std::memcpy(out.data.data(), brought->data, out.data.size());
      apply_strokes(strokes_on(stage, jobs[i], stage.size), out);
      fill_outside(out, resampled(stage.capture.inside, stage.capture.size, stage.size), 0);
      written = write_image(mask, out);
    }
    const std::lock_guard lock(mutex);
    if (!written && !fault) fault = written.error();
    progress.report(double(++done) / double(jobs.size()), fmt::format("frame {}", jobs[i].frame));
  });
  if (stage.stop.stop_requested()) return cancelled_error();
  if (fault) return *fault;
  return {};
}

// The regions of a frame, where they are whole.
bool has_regions(const Stage& stage, int frame) {
  const auto regions = read_image(stage.folder / "regions" / frame_name(frame).filename());
  return regions && regions->channels >= 3 && regions->width == stage.capture.width &&
         regions->height == stage.capture.height;
}

bool regions_complete(const Stage& stage) {
  return std::ranges::all_of(stage.capture.frames, [&](const CaptureFrame& frame) {
    return !frame.held_out || has_regions(stage, frame.frame);
  });
}

Result<void> write_regions(const Stage& stage, const std::vector<Job>& jobs, const fs::path& masks,
                           const Progress& progress) {
  const auto folder = fresh_folder(stage.folder / "regions.part");
  if (!folder) return folder.error();
  std::size_t done = 0;
  for (const auto& job : jobs) {
    if (stage.stop.stop_requested()) return cancelled_error();
    if (!job.held_out) continue;
    // Frozen once made: two tracks of one capture are scored on the same pixels.
    const fs::path name = frame_name(job.frame).filename();
    std::error_code fault;
    if (has_regions(stage, job.frame)) {
      fs::copy_file(stage.folder / "regions" / name, *folder / name, fault);
      if (fault) return file_error(*folder / name, "write", fault.value());
      continue;
    }
    const auto alpha = read_image(masks / frame_name(job.frame).filename());
    if (!alpha) return alpha.error();
    const Intrinsics& source = job.camera->intrinsics;
    const auto place =
        place_person(stage.person, *job.tracked, *job.camera, source, stage.track.metres_per_unit);
    if (!place) continue;
    const Image8 regions = draw_regions(stage.capture, view(*alpha), stage.person, *place, source);
    if (auto written = write_image(*folder / frame_name(job.frame).filename(), regions); !written)
      return written;
    progress.report(double(++done) / double(jobs.size()), fmt::format("regions of frame {}", job.frame));
  }
  return replace_folder(*folder, stage.folder / "regions");
}

Result<void> write_plate(const Stage& stage, const std::vector<Job>& jobs, const Statistics& statistics,
                         MatteResult& result) {
  std::error_code ignored;
  const fs::path picture = stage.folder / "plate.png", info = stage.folder / "plate.json",
                 seen = stage.folder / "plate_known.png";
  if (!statistics.has_plate) {
    fs::remove(info, ignored);
    fs::remove(picture, ignored);
    fs::remove(seen, ignored);
    return {};
  }
  result.has_plate = true;
  result.plate_coverage = statistics.plate.coverage();
  for (const auto& job : jobs)
    if (job.on_plate) result.plate_frames.push_back(job.frame);
  const int width = statistics.plate.colour.cols, height = statistics.plate.colour.rows;
  Image8 out(width, height, 3);
  std::memcpy(out.data.data(), statistics.plate.colour.data, out.data.size());
  if (auto written = write_image(picture, out); !written) return written;
  Image8 known(width, height, 1);
  std::memcpy(known.data.data(), statistics.plate.known.data, known.data.size());
  if (auto written = write_image(seen, known); !written) return written;
  return write_plate_info(info, {result.plate_coverage, result.plate_frames, stage.mosaic});
}

}  // namespace likeness::matting
