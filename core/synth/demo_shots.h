// Hard cuts of the demo: which stretch of the performance each shot shows, and from where.
//
// The person performs once, for longer than the film; an editor drops what lay between two shots. So after a
// cut pose and expression are others, as in films that people have edited.
#pragma once

#include <string>
#include <vector>

#include "core/synth/demo_options.h"

namespace likeness {

enum class CutKind {
  opening,    // of the film: no cut
  jump,       // the same place and lens, a moment later
  punch_in,   // the same place, cropped closer
  punch_out,  // and back
  angle       // the person sits elsewhere and is filmed from there
};
const char* cut_name(CutKind kind);  // "opening", "jump", "punch-in", "punch-out", "angle"

struct DemoShot {
  int first = 0, last = 0;          // frames of the film
  CutKind kind = CutKind::opening;  // of the cut before it
  int place = 0;                    // of camera and person, 0..2; shots of one place share the background
  bool close = false;               // cropped closer
  int camera = 0;                   // shots that share place and crop share this number
  int dropped = 0;                  // frames of the performance that were cut out before it, in all
};

// In order, without gaps. Deterministic; at least as many frames as shots are needed.
std::vector<DemoShot> demo_shots(const DemoOptions& options);
const DemoShot& shot_of(const std::vector<DemoShot>& shots, int frame);

// The performance before it was cut: the same options with its whole length and without cuts. Frame f of the
// film shows its frame f + shot_of(f).dropped.
DemoOptions uncut(const DemoOptions& options, const std::vector<DemoShot>& shots);

}  // namespace likeness
