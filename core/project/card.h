// The honest card of an avatar: what its capture taught it, what it never saw, and what to film again.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/head/head_model.h"
#include "core/project/project.h"
#include "core/project/seen_mouth.h"
#include "core/project/seen_views.h"
#include "core/render/avatar.h"
#include "core/render/holding_range.h"
#include "core/scene/track.h"

namespace likeness {

enum class Learnt { never, little, well };
inline constexpr const char* kLearnt[] = {"never", "little", "well"};

// Named actions; both sides of the face are one, and the side seen less counts.
struct CardExpression {
  std::string name;  // without _L and _R
  float most = 0;    // on top of rest, 1 = full: 98th percentile of the training frames
  Learnt learnt = Learnt::never;
};

// A stretch of the clip in which the track is worst.
struct CardMoment {
  double from_s = 0, to_s = 0;
  double badness = 0;            // mean of the frames there, 1 = the clip's usual error; lost frames count 3
  std::string what, film_again;  // one sentence each
};

// A side from which, or an expression in which, the head was not seen enough.
struct CardGap {
  std::string what, film_again;  // one sentence each
};

struct Card {
  int trained = 0, weak = 0, lost = 0, refused = 0;  // frames; refused: blurred or without a face
  ViewAngle low, high;  // of the camera as seen from the head, rad: 2nd to 98th percentile
  SeenMouth mouth;      // how widely it was seen to smile, by the pictures
  std::vector<CardExpression> expressions;  // in the head model's order
  std::vector<CardGap> gaps;
  std::vector<AvatarPart> parts;      // of the method, and why it has them; empty: from before that was kept
  std::optional<HoldingRange> holds;  // beyond what was seen; nullopt: not looked for yet (what_holds)
  std::vector<CardMoment> worst;      // at most three, the worst first; none where the track is even
};

// Training and held-out frames both count for the moments: each says what the tracker could not follow.
// further: from where the further clips show the head, whose track is not looked at. mouth: what the pictures
// say of smiles, which counts where the track says less.
Card make_card(const Capture& capture, const CameraSet& cameras, const Track& track, const SeenViews& further,
               const Avatar& avatar, const HeadModel& model, const SeenMouth& mouth = {});

// Of a trained project.
Result<Card> project_card(const Project& project);

}  // namespace likeness
