// The matte stage's work and its frames: what is known of each, and what the track says about it. Internal to
// the stage (matte.cpp), as are learn_background.h, cut_frames.h and write_mattes.h.
#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/kept_work.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/image/image.h"
#include "core/matte/matting_network.h"
#include "core/matte/person_hull.h"
#include "core/matte/person_network.h"
#include "core/matte/person_prior.h"
#include "core/matte/plate.h"
#include "core/matte/room_behind.h"
#include "core/matte/stroke_constraints.h"
#include "core/matte/strokes.h"
#include "core/scene/track.h"

namespace likeness::matting {

struct Stage {
  std::filesystem::path folder;
  const Capture& capture;
  const CameraSet& cameras;
  const Track& track;
  PersonModel person;
  int size = 256, cut_size = 256;
  const MattingNetwork* network = nullptr;        // or none
  const PersonNetwork* person_network = nullptr;  // or none
  const FrameStrokes& strokes;
  std::stop_token stop;
  KeptWork* kept = nullptr;  // or none
  RoomBehind room;           // empty: not known
  // Behind a hand-held camera: those that would take the plate, a mosaic, at `size` and at `cut_size`.
  // nullopt: the plate is the frames' own picture.
  std::optional<Camera> mosaic, small_mosaic;
};

// One frame that gets a matte.
struct Job {
  int frame = 0, shot = 0;  // shot: of a film that was cut
  bool trains = false, held_out = false, on_plate = false;
  const TrackedFrame* tracked = nullptr;
  const Camera* camera = nullptr;
  cv::Mat share;          // 8U, cut_size: of person, by the clip's own mask or by the network's; else empty
  bool own_mask = false;  // the clip brought one
};

// A mask of one frame as `make` makes it, or as a killed run has kept it. name: of this step of the work.
Result<cv::Mat> kept_mask(const Stage& stage, const std::string& name, int frame,
                          const std::function<Result<cv::Mat>()>& make);

// A picture's pixels, which it keeps.
cv::Mat view(const Image8& image);
cv::Mat reduced(const cv::Mat& picture, int size);
Intrinsics crop_of(const Stage& stage, const Camera& camera, int size);
// What was not filmed of the pictures, at size x size px: 8U, 255 there; empty where all of them was.
cv::Mat unfilmed(const Stage& stage, int size);
// Beyond what was filmed, its border is repeated, so that no edge appears there.
Result<cv::Mat> read_frame(const Stage& stage, int frame);
// The mask that the clip itself brought (alpha_name), 8U of size x size px; empty without one.
Result<cv::Mat> own_alpha(const Stage& stage, int frame, int size);
// The network's alpha for a picture, at its size; empty without a network.
Result<cv::Mat> network_alpha(const Stage& stage, const cv::Mat& picture);

// The frames that get a matte: those with a camera and a tracked head.
std::vector<Job> list_jobs(const Stage& stage);
// For a moving camera: marks the frames of the longest run that shares one pose bit for bit, if it lasts a
// second.
void mark_rest(const Stage& stage, std::vector<Job>& jobs);
// Whether the jobs before and after job i are of the next pictures of its shot and may be used for it: a
// training frame uses no held-out neighbour, as nothing of a held-out picture may reach training.
bool has_neighbours(const std::vector<Job>& jobs, std::size_t i);
// Evenly spread training frames, on the plate or off it.
std::vector<const Job*> choose(const std::vector<Job>& jobs, bool on_plate, std::size_t count);

std::optional<PersonPlace> place_of(const Stage& stage, const Job& job, const Intrinsics& picture);
// What strokes cover of a frame's picture; empty if nothing was painted.
StrokeCover strokes_on(const Stage& stage, const Job& job, int size);
// What the track and the user's strokes say about a frame. `hull` may be empty.
PersonPrior prior_of(const Stage& stage, const Job& job, int size, const PersonHull& hull);
// Before a hand-held camera: says which cameras take the mosaic.
void choose_mosaic(Stage& stage, const std::vector<Job>& jobs);
// A picture of a frame's crop as the plate's camera would have taken it: the frame's own before a resting
// camera. outside: the value where the frame does not look.
cv::Mat onto_plate(const Stage& stage, const Job& job, const cv::Mat& picture, int interpolation,
                   const cv::Scalar& outside);
// A frame's part of the plate, of which `plate` is the whole, at its crop's `size`.
Plate plate_of_frame(const Stage& stage, const Job& job, const Plate& plate, int size);
// The room behind a frame off the plate, as a plate; empty where it is not known.
Plate room_of(const Stage& stage, const Job& job, const cv::Mat& picture, const cv::Mat& possible);

}  // namespace likeness::matting
