// What the user chose for a project: a struct a stage, and what several stages read. Everything else has one
// default, kept by the stages themselves. Each choice is a row of the table in option_table.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/track/clip/refit_span.h"
#include "core/train/mode.h"

namespace likeness {

struct SharedChoices {
  std::filesystem::path video;
  std::filesystem::path head_model;      // empty = the built-in head
  std::filesystem::path landmark_model;  // as landmark_source takes it (core/face/landmarks.h)
  std::uint64_t seed = 0;
  std::filesystem::path person_network{};  // ONNX; empty = the installed one if there is one, "none" = none

  bool operator==(const SharedChoices&) const = default;
};

struct ImportChoices {
  int size = 256;             // px
  Split split = Split::tail;  // what is held out
  ClipSeconds seconds{};      // of the clip that are read
  SideRange sides{};          // of Split::sides

  bool operator==(const ImportChoices&) const = default;
};

struct AlignChoices {
  std::optional<CameraKind> camera;  // what it does, by the user's word; empty: the align stage finds out
  double lens_mm =
      0;  // of a resting or hand-held camera, as on 35 mm film; 0: as the clip says, or a usual one

  bool operator==(const AlignChoices&) const = default;
};

struct FitChoices {
  std::filesystem::path identity;      // the person's shape, known from elsewhere; empty = fitted
  std::filesystem::path displacement;  // a folder of detail maps (core/head/detail_maps.h); empty: none
  std::vector<RefitSpan> refits;       // of the track, fitted again; ascending, apart from each other
  std::vector<int> rest_frames;        // that show the resting face, ascending; empty: found

  bool operator==(const FitChoices&) const = default;
};

struct MatteChoices {
  std::filesystem::path matting_network;  // ONNX; empty = none

  bool operator==(const MatteChoices&) const = default;
};

struct TrainChoices {
  double budget_s = 300;
  double full_budget_s = 0;        // before a training was finished early; 0: none was
  std::uint64_t steps = 0;         // exact training steps instead of a budget
  double checkpoint_every_s = 30;  // what a killed training loses at most
  std::optional<FieldMode> mode;   // empty: chosen from the capture (core/train/choose_parts.h)
  bool use_latent = true, use_occupancy = true;
  bool refine_track = false;  // correct the training frames through the field
  double landmark_loss = 0;   // weight of the training's landmark loss; 0: without
  bool use_proxies = true;    // what was not filmed is taught (core/train/proxy_views.h)
  std::vector<int> left_out;  // frames the user takes out of the training, ascending; held-out ones cannot be

  bool operator==(const TrainChoices&) const = default;
};

struct ProjectOptions {
  SharedChoices shared{};
  ImportChoices import{};
  AlignChoices align{};
  FitChoices fit{};
  MatteChoices matte{};
  TrainChoices train{};

  bool operator==(const ProjectOptions&) const = default;
};

// A training that was finished early left its seconds as the budget: too little for one that starts anew.
void restore_budget(ProjectOptions& options);

}  // namespace likeness
