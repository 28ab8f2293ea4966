// How well an avatar reproduces frames it never saw. A held-out frame is rendered from the track of its own
// picture: head pose, expression, jaw, eyes and torso pose are its only free numbers; its latent code is
// zero.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/image/image.h"
#include "core/lab/score/frame_score.h"
#include "core/matte/read_regions.h"
#include "core/project/project.h"
#include "core/render/backend.h"
#include "core/render/render.h"

namespace likeness {

// A held-out frame beside its truth, as far as it was filmed.
struct ScoredFrame {
  const FrameScore& score;
  const Image8 &truth, &rendered;  // 8-bit RGB
  const Image8& silhouette;        // of the avatar: one channel, 255 where it hides what is behind
  const Regions& regions;
};

struct EvalOptions {
  // One PNG per held-out frame, named by its number in the source (000360.png), in source pixels: red person,
  // green head, blue face. Empty = the project's own, written once by the matte stage.
  std::filesystem::path regions;
  // Where held-out frames go as PNG (truth | avatar | difference x 4), and as mp4; empty = not written.
  std::filesystem::path pictures;
  std::filesystem::path video;
  std::filesystem::path
      lpips;  // a network that measures perceptual distance (perceptual_network.h); empty = none
  RenderQuality quality = RenderQuality::final;
  RenderPlace place;                               // where the avatar is rendered
  std::function<void(const ScoredFrame&)> look{};  // called with every frame that is scored
  bool refit = false;  // also fit every frame's pose and expression to the frozen field; about 3 s a frame
};

// Held-out frames with every frame's pose and expression fitted to the frozen field: the oracle of
// core/train/field_fit.h, never a result of the avatar as tracked.
struct RefitScores {
  std::optional<double> psnr_db;  // of full frames; absent as Evaluation's
  double psnr_head_db = 0, psnr_face_db = 0;
  int free_numbers_per_frame = 0;  // that were fitted to the field
};

struct Evaluation {
  // Means of the frames' dB, but for the pooled one. Full-frame figures are absent where the background of a
  // held-out frame is not modelled (a moving camera has no plate).
  std::optional<double> psnr_db, psnr_pooled_db, ssim, gmsd, mse, lpips;
  double psnr_person_db = 0, psnr_head_db = 0, psnr_face_db = 0, face_mse = 0;
  LandmarkErrors landmarks_px;           // px at `size`
  int frames_test = 0, frames_lost = 0;  // lost: held-out frames without a track, which cannot be rendered
  int size = 0;
  int free_numbers_per_frame = 0;  // of the track of one held-out frame
  double render_fps = 0, samples_per_ray = 0;
  std::optional<RefitScores> refit;
  std::string background_fault{};  // of the avatar: why its background is not the one that was filmed
  std::string split;
  std::string backend = "cpu";  // that rendered the last frame
  std::vector<FrameScore> frames;
};

// The figure that says first how good an avatar is: of full frames, or of the person where what stands behind
// them was not learnt or is not known.
struct Headline {
  const char* of = "full";  // or "person"
  double psnr_db = 0;
  std::string why;  // it is not of full frames; a sentence, or empty
};
Headline headline(const Evaluation& evaluation);

Result<Evaluation> evaluate(const Project& project, const EvalOptions& options, const Progress& progress,
                            std::stop_token stop);

}  // namespace likeness
