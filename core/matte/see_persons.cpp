// See see_persons.h.
#include "core/matte/see_persons.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>

#include "core/base/parallel.h"
#include "core/matte/person_share.h"

namespace likeness::matting {
namespace {

// The part of the crop's picture, of `size` px, that lies inside the source picture: the border that is
// repeated beyond it looks like a person where there is one.
PictureRect filmed_part(const Capture& capture, int size) {
  const SquareCrop& crop = capture.crop;
  const double scale = double(size) / crop.side;
  const auto first = [&](int start) { return std::clamp(int(std::ceil(-start * scale)), 0, size - 1); };
  const auto last = [&](int start, int length) {
    return std::clamp(int(std::floor((length - start) * scale)), 1, size);
  };
  const int x = first(crop.x), y = first(crop.y);
  return {x, y, std::max(1, last(crop.x, capture.width) - x), std::max(1, last(crop.y, capture.height) - y)};
}

Result<cv::Mat> network_share(const Stage& stage, const Job& job) {
  const auto picture = read_frame(stage, job.frame);
  if (!picture) return picture.error();
  const cv::Mat small = reduced(*picture, stage.cut_size);
  Image8 rgb(small.cols, small.rows, 3);
  std::memcpy(rgb.data.data(), small.data, rgb.data.size());
  const auto share = stage.person_network->share_in(rgb, filmed_part(stage.capture, stage.cut_size));
  if (!share) return share.error();
  return view(*share).clone();
}

// own: whether the clip's own mask says it.
Result<cv::Mat> share_of(const Stage& stage, const Job& job, std::uint8_t& own) {
  auto alpha = own_alpha(stage, job.frame, stage.cut_size);
  own = alpha && !alpha->empty();
  if (!alpha || own || !stage.person_network) return alpha;
  return kept_mask(stage, "person", job.frame, [&] { return network_share(stage, job); });
}

}  // namespace

Result<void> see_persons(const Stage& stage, std::vector<Job>& jobs, const Progress& progress) {
  std::vector<cv::Mat> seen(jobs.size());
  std::vector<std::uint8_t> own(jobs.size(), 0);
  std::mutex mutex;
  std::optional<Error> fault;
  std::atomic<std::size_t> done = 0;
  parallel_for(jobs.size(), [&](std::size_t i) {
    if (stage.stop.stop_requested()) return;
    auto share = share_of(stage, jobs[i], own[i]);
    if (share) {
      seen[i] = std::move(*share);
    } else {
      const std::lock_guard lock(mutex);
      if (!fault) fault = share.error();
    }
    progress.report(double(++done) / double(jobs.size()), fmt::format("frame {}", jobs[i].frame));
  });
  if (stage.stop.stop_requested()) return cancelled_error();
  if (fault) return *fault;
  for (std::size_t i = 0; i < jobs.size(); ++i) jobs[i].own_mask = own[i];
  for (std::size_t i = 0; i < jobs.size(); ++i)
    jobs[i].share = !own[i] && has_neighbours(jobs, i) && !seen[i].empty()
                        ? steady_share(seen[i - 1], seen[i], seen[i + 1])
                        : seen[i];
  return {};
}

}  // namespace likeness::matting
