// Small made clips filmed with every kind of camera, and what the camera stage may rightly say of each.
//
// They are as short and small as their cameras can be told by, so that all of them are filmed and aligned in
// minutes. Persons, lights, seeds and formats vary; nothing is chosen by how it comes out. Cuts stay in one
// place: what a film shows of other places is left out before cameras are looked for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/synth/demo_options.h"

namespace likeness {

struct KindClip {
  std::string name;
  DemoOptions film;
};
const std::vector<KindClip>& kind_clips();
// names: empty = all of them. In the list's order.
Result<std::vector<KindClip>> kind_clips_named(const std::vector<std::string>& names);

// The film as `likeness demo FOLDER` takes it. Two films differ if and only if their words do.
std::string demo_words(const DemoOptions& film);
const char* demo_wall_name(DemoWall wall);  // "furnished", "plain", "textured"

// What a stage said of a camera.
struct KindFound {
  CameraKind kind = CameraKind::resting;
  bool assumed = false;  // as AlignResult::kind_assumed
};

enum class KindOutcome {
  right,       // the true kind, which the pictures showed
  by_default,  // the true kind, but assumed, though the pictures show it
  untold,      // no picture shows it, and what is assumed then was assumed
  wrong        // anything else, a failure of the stage included
};
const char* kind_outcome_name(KindOutcome outcome);  // "right", "by default", "untold", "wrong"

// Two walls do not show everything. Before a plain one nothing shows whether the camera moves: only to take
// it to rest, and to say that this is taken, is no mistake. Along a textured one that is flat and fills the
// background a walk shows no near and far that move apart, and a solve from that is not defined: there a
// camera that walks may be said to be hand-held, but not to rest.
// truth: what a perfect solve would show. found: nullopt where the stage failed.
KindOutcome judge_kind(DemoWall wall, CameraKind truth, const std::optional<KindFound>& found);

// The rules of judge_kind in words, a line each, for whoever reads a table of outcomes.
const std::vector<std::string>& kind_rules();

struct KindCount {
  int right = 0, by_default = 0, untold = 0, wrong = 0;

  void add(KindOutcome outcome);
};
// "20 of 22 right, 1 by default, 1 wrong; of 2 more nothing can be told".
std::string kind_count_words(const KindCount& count);

}  // namespace likeness
