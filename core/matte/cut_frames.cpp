// Cuts and rooms: see cut_frames.h.
#include "core/matte/cut_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/parallel.h"

namespace likeness::matting {

Result<Cuts> cut_all(const Stage& stage, const std::string& name, const std::vector<Job>& jobs,
                     const Statistics& statistics, const Progress& progress) {
  std::vector<cv::Mat> cuts(jobs.size());
  std::atomic<int> by_prior = 0;
  std::mutex mutex;
  std::optional<Error> fault;
  std::atomic<std::size_t> done = 0;
  parallel_for(jobs.size(), [&](std::size_t i) {
    if (stage.stop.stop_requested()) return;
    const auto picture = read_frame(stage, jobs[i].frame);
    if (!picture) {
      const std::lock_guard lock(mutex);
      if (!fault) fault = picture.error();
      return;
    }
    const cv::Mat small = reduced(*picture, stage.cut_size);
    const auto network = network_alpha(stage, small);
    if (!network) {
      const std::lock_guard lock(mutex);
      if (!fault) fault = network.error();
      return;
    }
    const PersonPrior prior = prior_of(stage, jobs[i], stage.cut_size, statistics.hull);
    by_prior += !prior.held.empty() || !network->empty();
    auto made = kept_mask(stage, name, jobs[i].frame, [&]() -> Result<cv::Mat> {
      const Plate room = room_of(stage, jobs[i], small, prior.possible);
      return cut(stage, jobs[i], small, prior, room, *network, statistics);
    });
    if (made) cuts[i] = std::move(*made);
    progress.report(double(++done) / double(jobs.size()), fmt::format("frame {}", jobs[i].frame));
  });
  if (stage.stop.stop_requested()) return cancelled_error();
  if (fault) return *fault;
  return Cuts{std::move(cuts), by_prior};
}

namespace {

constexpr std::size_t kRoomFrames = 160;  // at most, from which the room behind a moving camera is learnt

RoughMatte matte_of(const Stage& stage, const Job& job, const cv::Mat& cut, int grow,
                    const cv::Mat& besides) {
  cv::Mat person;
  cv::dilate(cut, person, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * grow + 1, 2 * grow + 1}));
  if (!besides.empty()) person |= besides;
  if (const cv::Mat outside = unfilmed(stage, person.cols); !outside.empty()) person |= outside;
  if (person.cols != stage.size)
    cv::resize(person, person, {stage.size, stage.size}, 0, 0, cv::INTER_NEAREST);
  RoughMatte matte{job.frame, Image8(stage.size, stage.size, 1)};
  std::memcpy(matte.alpha.data.data(), person.data, matte.alpha.data.size());
  return matte;
}

}  // namespace

Result<RoomBehind> room_behind(const Stage& stage, const std::vector<Job>& jobs, const Statistics& statistics,
                               const LearnRoom& learn_room, const Progress& progress) {
  std::vector<Job> chosen;
  for (const Job* job : choose(jobs, false, kRoomFrames)) chosen.push_back(*job);
  if (chosen.empty()) return RoomBehind{};
  const auto cuts = cut_all(stage, "rough cut", chosen, statistics, progress.stage(0, 0.2, "rough mattes"));
  if (!cuts) return cuts.error();
  std::vector<RoughMatte> mattes;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    // Generously: what is excluded here is seen from elsewhere, but hair must not become part of the room.
    const PersonPrior prior = prior_of(stage, chosen[i], stage.cut_size, {});
    mattes.push_back(matte_of(stage, chosen[i], cuts->persons[i], std::max(3, stage.cut_size / 50),
                              prior.possible & (prior.below == 0)));
  }
  return learn_room(mattes, RoomPass::first, progress.stage(0.2, 1, "room"), stage.stop);
}

Result<void> learn_room_again(Stage& stage, const std::vector<Job>& jobs, const std::vector<cv::Mat>& cuts,
                              const LearnRoom& learn_room, Statistics& statistics, const Progress& progress) {
  const std::vector<const Job*> chosen = choose(jobs, false, kRoomFrames);
  std::vector<RoughMatte> mattes;
  for (const Job* job : chosen)
    mattes.push_back(
        matte_of(stage, *job, cuts[std::size_t(job - jobs.data())], std::max(2, stage.cut_size / 100), {}));
  auto room = learn_room(mattes, RoomPass::last, progress, stage.stop);
  if (!room) return room.error();
  stage.room = std::move(*room);
  const auto resting = std::ranges::find_if(jobs, [](const Job& job) { return job.on_plate; });
  if (statistics.has_plate && stage.room && resting != jobs.end())
    if (const Image8 seen = stage.room(resting->frame); !seen.empty())
      complete_plate(statistics.plate, view(seen).clone());
  if (const cv::Mat outside = unfilmed(stage, stage.size); statistics.has_plate && !outside.empty())
    statistics.plate.known.setTo(0, outside);
  return {};
}

}  // namespace likeness::matting
