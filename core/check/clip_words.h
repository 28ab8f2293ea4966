// What a clip is, in sentences for people: what its camera does and how that is known, how far the mask of
// the person can be trusted, and which parts of it serve. The same words of a clip that was only looked at
// and of one that was imported, in the check, on its page and in the window.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/image/pixel_rect.h"
#include "core/matte/matte_report.h"

namespace likeness {

struct CameraFacts {
  std::optional<CameraKind> kind{};  // nullopt: not known yet
  bool sure = true;                  // false: no other explanation fits, but this one was not proved
  bool stated = false;               // by the user's word
  std::string evidence{};            // with figures and their limits, in sentences; empty: none
};

struct MaskFacts {
  MaskPrior prior = MaskPrior::none;
  int frames = 0, used = 0;  // looked at; of them, those in which the prior saw the person; 0: not known yet
};

struct PartsFacts {
  double seconds = 0;     // of the clip
  double faceless_s = 0;  // without a face near
  double blurred_s = 0;   // whose face is too blurred to train
  int frames = 0, repeated = 0;
  int width = 0, height = 0;      // px, of the whole picture
  PixelRect film{};               // what was filmed of it; empty: all
  std::vector<ClipShot> shots{};  // between cuts, in order; one or none: there are no cuts
};
struct ClipFacts {
  CameraFacts camera{};
  MaskFacts mask{};
  PartsFacts parts{};
};

// What the stages of a project found of its clip. Null, or nullopt: not there yet.
struct ClipResults {
  const Capture* capture = nullptr;
  const CameraSet* cameras = nullptr;
  std::string camera_evidence{};       // of the align stage
  std::optional<CameraKind> stated{};  // what the camera does, by the user's word
  const MatteReport* mattes = nullptr;
  bool person_network = false;  // there is one for the mattes to come
};
ClipFacts clip_facts(const ClipResults& results);

// `first`, with what it does not know taken from `other`: a clip that was looked at and not yet built.
ClipFacts joined_facts(ClipFacts first, const ClipFacts& other);

// One sentence each; figures that prove it are in the facts' evidence.
std::string camera_sentence(const CameraFacts& facts);
std::string mask_sentence(const MaskFacts& facts);
std::string parts_sentence(const PartsFacts& facts);

// The kind in a word or two: "resting", "held in the hand", "walking".
const char* camera_kind_words(CameraKind kind);

}  // namespace likeness
