// The person cut out of every frame, and the room behind a moving camera learnt from such cuts.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/matte/learn_background.h"
#include "core/matte/matte_frames.h"
#include "core/matte/room_behind.h"

namespace likeness::matting {

// Cuts of all jobs, each on its own picture. Kept small: one byte a pixel at the cut's size.
struct Cuts {
  std::vector<cv::Mat> persons;  // one for each job
  int by_prior = 0;              // of them, those in which a network saw the tracked head, and was used
};
// name: of this pass, under which it is kept.
Result<Cuts> cut_all(const Stage& stage, const std::string& name, const std::vector<Job>& jobs,
                     const Statistics& statistics, const Progress& progress);

// The room behind the frames off the plate, learnt from rough cuts of the training frames among them.
Result<RoomBehind> room_behind(const Stage& stage, const std::vector<Job>& jobs, const Statistics& statistics,
                               const LearnRoom& learn_room, const Progress& progress);
// Learns the room again, from the cuts made with the first one, and with it the plate's unseen part.
Result<void> learn_room_again(Stage& stage, const std::vector<Job>& jobs, const std::vector<cv::Mat>& cuts,
                              const LearnRoom& learn_room, Statistics& statistics, const Progress& progress);

}  // namespace likeness::matting
