// Samples, statistics learnt from them, and the rounds: see learn_background.h.
#include "core/matte/learn_background.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"

namespace likeness::matting {

namespace {

constexpr std::size_t kPlateSamples = 80, kOtherSamples = 32;
constexpr int kRounds = 4;
// Log-likelihood ratio above which a colour is more likely the person's. Below zero: the certain part of a
// head shows little of its hair.
constexpr float kRatherPersons = -1.5f;

struct Sample {
  const Job* job = nullptr;
  cv::Mat picture, small;  // size and cut_size, 8UC3
  PersonPrior prior;       // cut_size
  cv::Mat network;         // cut_size, 8U; empty without one
  Plate room;              // cut_size, of a frame off the plate where the room is known
  cv::Mat person;          // cut_size, empty before the first cut
};

Result<std::vector<Sample>> load_samples(const Stage& stage, const std::vector<Job>& jobs) {
  // Memory: 80 pictures of 512 px are 63 MB; larger ones are taken in smaller number.
  const std::size_t plate_count = stage.size > 512 ? kPlateSamples / 2 : kPlateSamples;
  std::vector<const Job*> chosen = choose(jobs, true, plate_count);
  for (const Job* job : choose(jobs, false, kOtherSamples)) chosen.push_back(job);
  std::vector<Sample> samples(chosen.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (stage.stop.stop_requested()) return cancelled_error();
    auto picture = read_frame(stage, chosen[i]->frame);
    if (!picture) return picture.error();
    samples[i].job = chosen[i];
    samples[i].picture = *picture;
    samples[i].small = reduced(*picture, stage.cut_size);
    const auto network = network_alpha(stage, samples[i].small);
    if (!network) return network.error();
    samples[i].network = *network;
    samples[i].prior = prior_of(stage, *chosen[i], stage.cut_size, {});
    samples[i].room = room_of(stage, *chosen[i], samples[i].small, samples[i].prior.possible);
  }
  return samples;
}

// Where the person may be in a sample, generously, at the cut's size.
cv::Mat occupied_of(const Sample& sample) {
  if (sample.person.empty()) return sample.prior.possible;
  cv::Mat grown;
  const int radius = std::max(2, sample.person.cols / 100);
  cv::dilate(sample.person | sample.prior.certain, grown,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}));
  if (!sample.prior.held.empty()) grown |= sample.prior.held;  // a torso at rest is no wall
  if (!sample.prior.excluded.empty()) grown.setTo(0, sample.prior.excluded);
  return grown;
}

PersonHull hull_of(const Stage& stage, const std::vector<Sample>& samples) {
  std::vector<MattedView> views;
  for (const auto& sample : samples) {
    if (sample.person.empty() || sample.job->tracked->status != FrameStatus::good) continue;
    const Intrinsics picture = crop_of(stage, *sample.job->camera, stage.cut_size);
    if (const auto place = place_of(stage, *sample.job, picture))
      views.push_back({*place, picture, sample.person});
  }
  return carve_person(stage.person, views);
}

// `background` without pixels near the person that have the person's colours.
cv::Mat without_persons_own(const Sample& sample, const cv::Mat& background, const PlateDoubt& doubt) {
  cv::Mat kept = background.clone();
  for (int y = 0; y < kept.rows; ++y)
    for (int x = 0; x < kept.cols; ++x)
      if (kept.at<unsigned char>(y, x) && sample.prior.possible.at<unsigned char>(y, x) &&
          doubt.persons_own(sample.small.at<cv::Vec3b>(y, x)))
        kept.at<unsigned char>(y, x) = 0;
  return kept;
}

// What the plate's camera would see of the room; empty if the room was not learnt.
cv::Mat room_at_rest(const Stage& stage, const std::vector<Sample>& samples) {
  const auto resting =
      std::ranges::find_if(samples, [](const Sample& sample) { return sample.job->on_plate; });
  if (!stage.room || resting == samples.end()) return {};
  const Image8 room = stage.room(resting->job->frame);
  return room.empty() ? cv::Mat() : view(room).clone();
}

// Plate, hull and colour statistics from the samples as they are cut now. What a cut leaves free is learnt as
// background only if `first`, the statistics before any cut, does not assign it to the person; nullptr before
// the first cut, when everything near the person is left out.
Statistics learn(const Stage& stage, const std::vector<Sample>& samples, const Statistics* first) {
  Statistics statistics;
  std::vector<cv::Mat> pictures, small, occupied, small_occupied;
  PlateDoubt doubt, small_doubt;
  if (first)
    doubt.persons_own = small_doubt.persons_own = [first](const cv::Vec3b& colour) {
      return std::max(first->upper.ratio(colour), first->lower.ratio(colour)) > kRatherPersons;
    };
  const cv::Mat outside = unfilmed(stage, stage.cut_size), beyond_plate = unfilmed(stage, stage.size);
  for (const auto& sample : samples) {
    const cv::Mat taken = outside.empty() ? occupied_of(sample) : cv::Mat(occupied_of(sample) | outside);
    const cv::Mat background = first ? without_persons_own(sample, taken == 0, doubt) : cv::Mat(taken == 0);
    // What only the cut calls person may be furniture that is never uncovered: its colours are not learnt.
    cv::Mat person = sample.person.empty() ? sample.prior.certain
                                           : sample.person & (sample.prior.likely | sample.prior.certain);
    if (!outside.empty()) person = person & (outside == 0);
    const cv::Mat above = sample.prior.below == 0;
    statistics.upper.add(sample.small, person & above, true);
    statistics.lower.add(sample.small, person & sample.prior.below, true);
    statistics.upper.add(sample.small, background & above, false);
    statistics.lower.add(sample.small, background, false);  // too little is free beside the shoulders alone
    if (!sample.job->on_plate) continue;
    cv::Mat enlarged, enlarged_near;
    cv::resize(taken, enlarged, {stage.size, stage.size}, 0, 0, cv::INTER_NEAREST);
    if (!beyond_plate.empty()) enlarged |= beyond_plate;
    cv::resize(sample.prior.possible, enlarged_near, {stage.size, stage.size}, 0, 0, cv::INTER_NEAREST);
    const auto mask = [&](const cv::Mat& m) {  // a frame says nothing about what it does not see
      return onto_plate(stage, *sample.job, m, cv::INTER_NEAREST, cv::Scalar(255));
    };
    const auto picture = [&](const cv::Mat& m) {
      return onto_plate(stage, *sample.job, m, cv::INTER_LINEAR, cv::Scalar::all(0));
    };
    pictures.push_back(picture(sample.picture));
    occupied.push_back(mask(enlarged));
    doubt.near.push_back(mask(enlarged_near));
    small.push_back(picture(sample.small));
    small_occupied.push_back(mask(taken));
    small_doubt.near.push_back(mask(sample.prior.possible));
  }
  statistics.upper.finish();
  statistics.lower.finish();
  statistics.hull = hull_of(stage, samples);
  statistics.has_plate = !pictures.empty();
  if (statistics.has_plate) {
    statistics.plate = estimate_plate(pictures, occupied, first ? &doubt : nullptr);
    if (!stage.mosaic) statistics.still = still_texture(small);
    statistics.small_plate = stage.size == stage.cut_size
                                 ? statistics.plate
                                 : estimate_plate(small, small_occupied, first ? &small_doubt : nullptr);
    if (const cv::Mat room = room_at_rest(stage, samples); !room.empty()) {
      complete_plate(statistics.plate, room);
      if (!beyond_plate.empty()) statistics.plate.known.setTo(0, beyond_plate);
      if (stage.size == stage.cut_size)
        statistics.small_plate = statistics.plate;
      else
        complete_plate(statistics.small_plate, reduced(room, stage.cut_size));
    }
  }
  return statistics;
}

}  // namespace

cv::Mat cut(const Stage& stage, const Job& job, const cv::Mat& small, const PersonPrior& prior,
            const Plate& room, const cv::Mat& network, const Statistics& statistics) {
  const bool plate = job.on_plate && statistics.has_plate, in_room = !plate && !room.colour.empty();
  const Plate own = plate ? plate_of_frame(stage, job, statistics.small_plate, stage.cut_size) : Plate{};
  const Plate* behind = plate ? &own : in_room ? &room : nullptr;
  return cut_person({&small, &prior, behind, &statistics.upper, &statistics.lower,
                     plate && !statistics.still.empty() ? &statistics.still : nullptr,
                     network.empty() ? nullptr : &network, in_room});
}

Result<Statistics> learn_in_rounds(const Stage& stage, const std::vector<Job>& jobs,
                                   const Progress& progress) {
  auto samples = load_samples(stage, jobs);
  if (!samples) return samples.error();
  const Statistics first = learn(stage, *samples, nullptr);
  Statistics statistics = first;
  for (int round = 1; round < kRounds; ++round) {
    parallel_for(samples->size(), [&](std::size_t i) {
      Sample& sample = (*samples)[i];
      if (stage.stop.stop_requested()) return;
      if (round > 1) sample.prior = prior_of(stage, *sample.job, stage.cut_size, statistics.hull);
      sample.person =
          cut(stage, *sample.job, sample.small, sample.prior, sample.room, sample.network, statistics);
    });
    if (stage.stop.stop_requested()) return cancelled_error();
    statistics = learn(stage, *samples, &first);
    progress.report(double(round) / (kRounds - 1), fmt::format("background, round {}", round));
  }
  return statistics;
}

}  // namespace likeness::matting
