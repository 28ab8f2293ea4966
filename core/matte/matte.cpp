// The matte stage: samples -> plate and colour statistics in three rounds -> of a moving camera the room, and
// the rounds again -> cuts of every frame -> the room again -> alpha -> frozen regions.
#include "core/matte/matte.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "core/base/files.h"
#include "core/base/parallel.h"
#include "core/image/files.h"
#include "core/matte/matting_network.h"
#include "core/matte/person_hull.h"
#include "core/matte/person_prior.h"
#include "core/matte/plate.h"
#include "core/matte/regions.h"
#include "core/matte/replace_folder.h"
#include "core/matte/segment.h"
#include "core/matte/stroke_constraints.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kCutSide =
    256;  // px at which person and background are told apart; the edge is done at full size
constexpr std::size_t kPlateSamples = 80, kOtherSamples = 32;
constexpr std::size_t kRoomFrames = 160;  // that the room behind a moving camera is learnt from, at most
constexpr int kRounds = 4;
// Log-likelihood ratio from which a colour is rather the person's. Below zero: the certain part of a head
// shows little of its hair.
constexpr float kRatherPersons = -1.5f;

struct Stage {
  fs::path folder;
  const Capture& capture;
  const CameraSet& cameras;
  const Track& track;
  PersonModel person;
  int size = 256, cut_size = 256;
  const MattingNetwork* network = nullptr;  // or none
  const FrameStrokes& strokes;
  std::stop_token stop;
  RoomBehind room;  // empty: not known
};

// One frame that gets a matte.
struct Job {
  int frame = 0;
  bool trains = false, held_out = false, on_plate = false;
  const TrackedFrame* tracked = nullptr;
  const Camera* camera = nullptr;
};

struct Sample {
  const Job* job = nullptr;
  cv::Mat picture, small;  // size and cut_size, 8UC3
  PersonPrior prior;       // cut_size
  cv::Mat network;         // cut_size, 8U; empty without one
  Plate room;              // cut_size, of a frame off the plate where the room is known
  cv::Mat person;          // cut_size, empty before the first cut
};

struct Statistics {
  Plate plate, small_plate;
  ColourModel upper, lower;  // colours above and below the neck's base
  PersonHull hull;           // empty before the first cut
  cv::Mat still;             // cut_size, empty without a plate
  bool has_plate = false;
};

cv::Mat view(const Image8& image) {
  return cv::Mat(image.height, image.width, image.channels == 3 ? CV_8UC3 : CV_8U,
                 const_cast<std::uint8_t*>(image.data.data()));
}

cv::Mat reduced(const cv::Mat& picture, int size) {
  cv::Mat small;
  cv::resize(picture, small, {size, size}, 0, 0, cv::INTER_AREA);
  return small;
}

Intrinsics crop_of(const Stage& stage, const Camera& camera, int size) {
  const SquareCrop& crop = stage.capture.crop;
  return crop_intrinsics(camera.intrinsics, crop.x, crop.y, crop.side, size);
}

Result<cv::Mat> read_frame(const Stage& stage, int frame) {
  const auto image = read_image(stage.folder / frame_name(frame));
  if (!image) return image.error();
  if (image->channels != 3 || image->width != image->height)
    return Error{ErrorCode::bad_input,
                 fmt::format("A frame of {} x {} px with {} channels; a square RGB picture is expected.",
                             image->width, image->height, image->channels),
                 "Run `likeness import` again.", (stage.folder / frame_name(frame)).string()};
  cv::Mat picture = view(*image).clone();
  return picture.cols == stage.size ? picture : reduced(picture, stage.size);
}

// What the network says of a picture, at its size; empty without one.
Result<cv::Mat> network_alpha(const Stage& stage, const cv::Mat& picture) {
  if (!stage.network) return cv::Mat();
  Image8 rgb(picture.cols, picture.rows, 3);
  std::memcpy(rgb.data.data(), picture.data, rgb.data.size());
  const auto alpha = stage.network->alpha(rgb);
  if (!alpha) return alpha.error();
  return view(*alpha).clone();
}

// The tracked frame nearest in number: heads do not leap where the track is lost. No held-out one for a frame
// that teaches.
const TrackedFrame* nearest_tracked(const Stage& stage, const CaptureFrame& frame) {
  const auto may_know = [&](const TrackedFrame& candidate) {
    if (candidate.status == FrameStatus::lost) return false;
    if (frame.held_out) return true;
    const auto own = std::ranges::find(stage.capture.frames, candidate.frame, &CaptureFrame::frame);
    return own == stage.capture.frames.end() || !own->held_out;
  };
  const TrackedFrame* best = nullptr;
  for (const auto& candidate : stage.track.frames)
    if ((!best || std::abs(candidate.frame - frame.frame) < std::abs(best->frame - frame.frame)) &&
        may_know(candidate))
      best = &candidate;
  return best;
}

std::vector<Job> list_jobs(const Stage& stage) {
  std::vector<Job> jobs;
  for (const auto& frame : stage.capture.frames) {
    if (!frame.used && !frame.held_out) continue;
    Job job{frame.frame, frame.used && !frame.held_out, frame.held_out, stage.cameras.is_static, nullptr,
            nullptr};
    job.camera = find_camera(stage.cameras, frame.frame);
    job.tracked = find_tracked(stage.track, frame.frame);
    if (!job.tracked || job.tracked->status == FrameStatus::lost) job.tracked = nearest_tracked(stage, frame);
    if (job.camera && job.tracked) jobs.push_back(job);
  }
  return jobs;
}

// Of a moving camera: the frames of the longest run that shares one pose bit for bit, if it lasts a second.
void mark_rest(const Stage& stage, std::vector<Job>& jobs) {
  if (stage.cameras.is_static) return;
  const auto same = [](const Job& a, const Job& b) {
    return a.camera->cam_from_world.matrix() == b.camera->cam_from_world.matrix();
  };
  std::size_t best_begin = 0, best_end = 0;
  int length = 0;
  for (std::size_t begin = 0; begin < jobs.size();) {
    std::size_t end = begin + 1;
    while (end < jobs.size() && same(jobs[begin], jobs[end])) ++end;
    const int frames = jobs[end - 1].frame - jobs[begin].frame + 1;
    if (frames > length) length = frames, best_begin = begin, best_end = end;
    begin = end;
  }
  const auto trains = std::count_if(jobs.begin() + long(best_begin), jobs.begin() + long(best_end),
                                    [](const Job& job) { return job.trains; });
  if (length < std::max(8.0, stage.capture.frames_per_second) || trains < 5) return;
  for (std::size_t i = best_begin; i < best_end; ++i) jobs[i].on_plate = true;
}

std::optional<PersonPlace> place_of(const Stage& stage, const Job& job, const Intrinsics& picture) {
  return place_person(stage.person, *job.tracked, *job.camera, picture, stage.track.metres_per_unit);
}

// What strokes cover of a frame's picture; empty where nobody painted.
StrokeCover strokes_on(const Stage& stage, const Job& job, int size) {
  const auto own = stage.strokes.find(job.frame);
  if (own == stage.strokes.end()) return {};
  return cover_strokes(own->second, stage.capture.crop, size);
}

// What the track says of a frame. `hull` may be empty.
PersonPrior tracked_prior(const Stage& stage, const Job& job, int size, const PersonHull& hull) {
  const Intrinsics picture = crop_of(stage, *job.camera, size);
  if (const auto place = place_of(stage, job, picture)) {
    PersonPrior prior = person_prior(stage.person, *place, picture);
    sharpen_prior(prior, hull, *place, picture);
    return prior;
  }
  PersonPrior nothing;
  nothing.certain = nothing.likely = nothing.below = cv::Mat(size, size, CV_8U, cv::Scalar(0));
  nothing.possible = cv::Mat(size, size, CV_8U, cv::Scalar(255));
  nothing.location = cv::Mat(size, size, CV_32F, cv::Scalar(0));
  return nothing;
}

// The same with what somebody painted.
PersonPrior prior_of(const Stage& stage, const Job& job, int size, const PersonHull& hull) {
  PersonPrior prior = tracked_prior(stage, job, size, hull);
  constrain_prior(prior, strokes_on(stage, job, size));
  return prior;
}

// Evenly spread training frames, on the plate or off it.
std::vector<const Job*> choose(const std::vector<Job>& jobs, bool on_plate, std::size_t count) {
  std::vector<const Job*> all, chosen;
  for (const auto& job : jobs)
    if (job.trains && job.on_plate == on_plate) all.push_back(&job);
  const std::size_t kept = std::min(count, all.size());
  for (std::size_t i = 0; i < kept; ++i) chosen.push_back(all[i * all.size() / kept]);
  return chosen;
}

// The room behind a frame off the plate, as a plate; empty where it is not known.
Plate room_of(const Stage& stage, const Job& job, const cv::Mat& picture, const cv::Mat& possible) {
  if (job.on_plate || !stage.room) return {};
  const Image8 room = stage.room(job.frame);
  if (room.empty()) return {};
  cv::Mat seen = view(room), reach = possible;
  if (seen.cols != picture.cols) seen = reduced(seen, picture.cols);
  if (reach.cols != picture.cols)
    cv::resize(reach, reach, {picture.cols, picture.rows}, 0, 0, cv::INTER_NEAREST);
  return room_plate(picture, seen.clone(), reach == 0, reach);
}

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

// `background` less what near the person has rather the person's colours.
cv::Mat without_persons_own(const Sample& sample, const cv::Mat& background, const PlateDoubt& doubt) {
  cv::Mat kept = background.clone();
  for (int y = 0; y < kept.rows; ++y)
    for (int x = 0; x < kept.cols; ++x)
      if (kept.at<unsigned char>(y, x) && sample.prior.possible.at<unsigned char>(y, x) &&
          doubt.persons_own(sample.small.at<cv::Vec3b>(y, x)))
        kept.at<unsigned char>(y, x) = 0;
  return kept;
}

// What the plate's camera would see of the room; empty where it was not learnt.
cv::Mat room_at_rest(const Stage& stage, const std::vector<Sample>& samples) {
  const auto resting =
      std::ranges::find_if(samples, [](const Sample& sample) { return sample.job->on_plate; });
  if (!stage.room || resting == samples.end()) return {};
  const Image8 room = stage.room(resting->job->frame);
  return room.empty() ? cv::Mat() : view(room).clone();
}

// Plate, hull and colour statistics from the samples as they are cut now.
// What a cut leaves free teaches the background only as far as `first`, the statistics before any cut, does
// not call it the person's; nullptr before the first cut, when everything near the person is left out.
Statistics learn(const Stage& stage, const std::vector<Sample>& samples, const Statistics* first) {
  Statistics statistics;
  std::vector<cv::Mat> pictures, small, occupied, small_occupied;
  PlateDoubt doubt, small_doubt;
  if (first)
    doubt.persons_own = small_doubt.persons_own = [first](const cv::Vec3b& colour) {
      return std::max(first->upper.ratio(colour), first->lower.ratio(colour)) > kRatherPersons;
    };
  for (const auto& sample : samples) {
    const cv::Mat taken = occupied_of(sample);
    const cv::Mat background = first ? without_persons_own(sample, taken == 0, doubt) : cv::Mat(taken == 0);
    // What only the cut calls person may be furniture that is never freed: it does not teach colours.
    const cv::Mat person = sample.person.empty()
                               ? sample.prior.certain
                               : sample.person & (sample.prior.likely | sample.prior.certain);
    const cv::Mat above = sample.prior.below == 0;
    statistics.upper.add(sample.small, person & above, true);
    statistics.lower.add(sample.small, person & sample.prior.below, true);
    statistics.upper.add(sample.small, background & above, false);
    statistics.lower.add(sample.small, background, false);  // too little is free beside the shoulders alone
    if (!sample.job->on_plate) continue;
    cv::Mat enlarged, enlarged_near;
    cv::resize(taken, enlarged, {stage.size, stage.size}, 0, 0, cv::INTER_NEAREST);
    cv::resize(sample.prior.possible, enlarged_near, {stage.size, stage.size}, 0, 0, cv::INTER_NEAREST);
    pictures.push_back(sample.picture);
    occupied.push_back(enlarged);
    doubt.near.push_back(enlarged_near);
    small.push_back(sample.small);
    small_occupied.push_back(taken);
    small_doubt.near.push_back(sample.prior.possible);
  }
  statistics.upper.finish();
  statistics.lower.finish();
  statistics.hull = hull_of(stage, samples);
  statistics.has_plate = !pictures.empty();
  if (statistics.has_plate) {
    statistics.plate = estimate_plate(pictures, occupied, first ? &doubt : nullptr);
    statistics.still = still_texture(small);
    statistics.small_plate = stage.size == stage.cut_size
                                 ? statistics.plate
                                 : estimate_plate(small, small_occupied, first ? &small_doubt : nullptr);
    if (const cv::Mat room = room_at_rest(stage, samples); !room.empty()) {
      complete_plate(statistics.plate, room);
      if (stage.size == stage.cut_size)
        statistics.small_plate = statistics.plate;
      else
        complete_plate(statistics.small_plate, reduced(room, stage.cut_size));
    }
  }
  return statistics;
}

// room: of the frame, empty where it is not known.
cv::Mat cut(const Job& job, const cv::Mat& small, const PersonPrior& prior, const Plate& room,
            const cv::Mat& network, const Statistics& statistics) {
  const bool plate = job.on_plate && statistics.has_plate, in_room = !plate && !room.colour.empty();
  const Plate* behind = plate ? &statistics.small_plate : in_room ? &room : nullptr;
  return cut_person({&small, &prior, behind, &statistics.upper, &statistics.lower,
                     plate ? &statistics.still : nullptr, network.empty() ? nullptr : &network, in_room});
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
      sample.person = cut(*sample.job, sample.small, sample.prior, sample.room, sample.network, statistics);
    });
    if (stage.stop.stop_requested()) return cancelled_error();
    statistics = learn(stage, *samples, &first);
    progress.report(double(round) / (kRounds - 1), fmt::format("background, round {}", round));
  }
  return statistics;
}

// Cuts of all jobs, each on its own picture. Kept small: one byte a pixel at the cut's size.
Result<std::vector<cv::Mat>> cut_all(const Stage& stage, const std::vector<Job>& jobs,
                                     const Statistics& statistics, const Progress& progress) {
  std::vector<cv::Mat> cuts(jobs.size());
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
    const Plate room = room_of(stage, jobs[i], small, prior.possible);
    cuts[i] = cut(jobs[i], small, prior, room, *network, statistics);
    progress.report(double(++done) / double(jobs.size()), fmt::format("frame {}", jobs[i].frame));
  });
  if (stage.stop.stop_requested()) return cancelled_error();
  if (fault) return *fault;
  return cuts;
}

RoughMatte matte_of(const Stage& stage, const Job& job, const cv::Mat& cut, int grow,
                    const cv::Mat& besides) {
  cv::Mat person;
  cv::dilate(cut, person, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * grow + 1, 2 * grow + 1}));
  if (!besides.empty()) person |= besides;
  if (person.cols != stage.size)
    cv::resize(person, person, {stage.size, stage.size}, 0, 0, cv::INTER_NEAREST);
  RoughMatte matte{job.frame, Image8(stage.size, stage.size, 1)};
  std::memcpy(matte.alpha.data.data(), person.data, matte.alpha.data.size());
  return matte;
}

// The room behind the frames off the plate, learnt from rough cuts of the training frames among them.
Result<RoomBehind> room_behind(const Stage& stage, const std::vector<Job>& jobs, const Statistics& statistics,
                               const LearnRoom& learn_room, const Progress& progress) {
  std::vector<Job> chosen;
  for (const Job* job : choose(jobs, false, kRoomFrames)) chosen.push_back(*job);
  if (chosen.empty()) return RoomBehind{};
  const auto cuts = cut_all(stage, chosen, statistics, progress.stage(0, 0.2, "rough mattes"));
  if (!cuts) return cuts.error();
  std::vector<RoughMatte> mattes;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    // Generously: what is left out here is seen from elsewhere, but hair must not become a part of the room.
    const PersonPrior prior = prior_of(stage, chosen[i], stage.cut_size, {});
    mattes.push_back(matte_of(stage, chosen[i], (*cuts)[i], std::max(3, stage.cut_size / 50),
                              prior.possible & (prior.below == 0)));
  }
  return learn_room(mattes, RoomPass::first, progress.stage(0.2, 1, "room"), stage.stop);
}

// The room again, from the cuts that the first one led to, and with it the plate's unseen part.
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
  return {};
}

// Majority of a frame and its two neighbours, where these are the next frames of the video. A training frame
// asks no held-out neighbour: nothing of a held-out picture may reach training.
cv::Mat steady(const std::vector<Job>& jobs, const std::vector<cv::Mat>& cuts, std::size_t i) {
  const auto usable = [&](std::size_t other) {
    return std::abs(jobs[other].frame - jobs[i].frame) <= 2 && (jobs[i].held_out || !jobs[other].held_out);
  };
  if (i == 0 || i + 1 >= jobs.size() || !usable(i - 1) || !usable(i + 1)) return cuts[i];
  // Only flicker is taken out: a pixel changes only where both neighbours disagree with it over a small area.
  const cv::Mat agreed = (cuts[i - 1] & cuts[i + 1]) | (cuts[i] & (cuts[i - 1] | cuts[i + 1]));
  return agreed;
}

Result<void> write_masks(const Stage& stage, const std::vector<Job>& jobs, const std::vector<cv::Mat>& cuts,
                         const Statistics& statistics, const fs::path& folder, const Progress& progress) {
  std::mutex mutex;
  std::optional<Error> fault;
  std::atomic<std::size_t> done = 0;
  parallel_for(jobs.size(), [&](std::size_t i) {
    if (stage.stop.stop_requested()) return;
    const auto picture = read_frame(stage, jobs[i].frame);
    Result<void> written = picture ? Result<void>() : Result<void>(picture.error());
    const auto network = picture ? network_alpha(stage, *picture) : Result<cv::Mat>(cv::Mat());
    if (!network) written = network.error();
    if (picture && network) {
      cv::Mat person = steady(jobs, cuts, i).clone();
      hold_cut(person, strokes_on(stage, jobs[i], person.cols));
      if (person.cols != stage.size) {
        cv::resize(person, person, {stage.size, stage.size}, 0, 0, cv::INTER_LINEAR);
        person = person > 127;
      }
      const Plate room = room_of(stage, jobs[i], *picture, cv::Mat(person.size(), CV_8U, cv::Scalar(255)));
      const Plate* plate = jobs[i].on_plate && statistics.has_plate ? &statistics.plate
                           : room.colour.empty()                    ? nullptr
                                                                    : &room;
      const int radius = std::max(2, stage.size / 80);
      const cv::Mat alpha = network->empty() ? soften(*picture, person, plate, radius)
                                             : soften_by_network(*network, person, 2 * radius);
      Image8 out(stage.size, stage.size, 1);
      std::memcpy(out.data.data(), alpha.data, out.data.size());
      apply_strokes(strokes_on(stage, jobs[i], stage.size), out);
      written = write_image(folder / frame_name(jobs[i].frame).filename(), out);
    }
    const std::lock_guard lock(mutex);
    if (!written && !fault) fault = written.error();
    progress.report(double(++done) / double(jobs.size()), fmt::format("frame {}", jobs[i].frame));
  });
  if (stage.stop.stop_requested()) return cancelled_error();
  if (fault) return *fault;
  return {};
}

bool regions_complete(const Stage& stage) {
  std::error_code ignored;
  for (const auto& frame : stage.capture.frames)
    if (frame.held_out && !fs::exists(stage.folder / "regions" / frame_name(frame.frame).filename(), ignored))
      return false;
  return true;
}

Result<void> write_regions(const Stage& stage, const std::vector<Job>& jobs, const fs::path& masks,
                           const Progress& progress) {
  const auto folder = fresh_folder(stage.folder / "regions.part");
  if (!folder) return folder.error();
  std::size_t done = 0;
  for (const auto& job : jobs) {
    if (stage.stop.stop_requested()) return cancelled_error();
    if (!job.held_out) continue;
    // Frozen once drawn: two tracks of one capture are scored on the same pixels.
    const fs::path name = frame_name(job.frame).filename();
    std::error_code fault;
    if (fs::exists(stage.folder / "regions" / name, fault)) {
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
  Image8 out(stage.size, stage.size, 3);
  std::memcpy(out.data.data(), statistics.plate.colour.data, out.data.size());
  if (auto written = write_image(picture, out); !written) return written;
  Image8 known(stage.size, stage.size, 1);
  std::memcpy(known.data.data(), statistics.plate.known.data, known.data.size());
  if (auto written = write_image(seen, known); !written) return written;
  return write_plate_info(info, {result.plate_coverage, result.plate_frames});
}

Result<MatteResult> run(Stage& stage, const LearnRoom& learn_room, const Progress& progress) {
  std::vector<Job> jobs = list_jobs(stage);
  const auto trains = std::count_if(jobs.begin(), jobs.end(), [](const Job& job) { return job.trains; });
  if (trains == 0)
    return Error{ErrorCode::failed, "No training frame has both a camera and a tracked head.",
                 "Look at the warnings of the camera and track stages; film again where they say so.",
                 "matte"};
  mark_rest(stage, jobs);
  auto statistics = learn_in_rounds(stage, jobs, progress.stage(0, 0.15, "background"));
  if (!statistics) return statistics.error();
  if (learn_room) {
    auto room = room_behind(stage, jobs, *statistics, learn_room, progress.stage(0.15, 0.2, "room"));
    if (!room) return room.error();
    stage.room = std::move(*room);
    if (stage.room) statistics = learn_in_rounds(stage, jobs, progress.stage(0.2, 0.25, "background"));
    if (!statistics) return statistics.error();
  }
  const auto cuts = cut_all(stage, jobs, *statistics, progress.stage(0.25, 0.5, "mattes"));
  if (!cuts) return cuts.error();
  if (stage.room)
    if (auto again = learn_room_again(stage, jobs, *cuts, learn_room, *statistics,
                                      progress.stage(0.5, 0.75, "room again"));
        !again)
      return again.error();
  const auto masks = fresh_folder(stage.folder / "masks.part");
  if (!masks) return masks.error();
  if (auto written =
          write_masks(stage, jobs, *cuts, *statistics, *masks, progress.stage(0.75, 0.95, "edges"));
      !written)
    return written.error();
  restore_folder(stage.folder / "regions");
  if (!regions_complete(stage))
    if (auto written = write_regions(stage, jobs, *masks, progress.stage(0.95, 1, "regions")); !written)
      return written.error();
  MatteResult result;
  if (auto written = write_plate(stage, jobs, *statistics, result); !written) return written.error();
  if (auto replaced = replace_folder(*masks, stage.folder / "masks"); !replaced) return replaced.error();
  if (result.has_plate && result.plate_coverage < 0.3)
    result.warnings.push_back(
        fmt::format("Only {:.0f} % of the background is ever seen; the rest of the plate is filled in.",
                    100 * result.plate_coverage));
  progress.report(1);
  return result;
}

}  // namespace

Result<MatteResult> matte_clip(const fs::path& folder, const Capture& capture, const CameraSet& cameras,
                               const Track& track, const HeadModel& model, const MatteOptions& options,
                               const Progress& progress, std::stop_token stop) {
  if (capture.crop.side <= 0 || options.size < 32)
    return Error{ErrorCode::bad_input,
                 fmt::format("A crop of {} px to {} px cannot be matted.", capture.crop.side, options.size),
                 "Run `likeness import` again.", folder.string()};
  std::optional<MattingNetwork> network;
  if (!options.network.empty()) {
    auto loaded = MattingNetwork::load(options.network);
    if (!loaded) return loaded.error();
    network = std::move(*loaded);
  }
  try {
    Stage stage{folder,
                capture,
                cameras,
                track,
                make_person_model(model, track),
                options.size,
                std::min(options.size, kCutSide),
                network ? &*network : nullptr,
                options.strokes,
                stop,
                {}};
    auto result = run(stage, options.learn_room, progress);
    std::error_code ignored;
    for (const char* unfinished : {"masks.part", "regions.part"})
      fs::remove_all(folder / unfinished, ignored);
    return result;
  } catch (const cv::Exception& fault) {
    return Error{ErrorCode::failed, fmt::format("The mattes could not be made: {}.", fault.what()),
                 "Free some memory and run the same command again.", folder.string()};
  }
}

}  // namespace likeness
