// Whether a clip will make an avatar, in words: what is wrong with it, when, and what to do about it.
//
// The thresholds are derived from measurements: docs/CAPTURE_CHECK.md lists them beside the figures of good
// clips and of the same clips spoilt in known ways.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/check/clip_measures.h"

namespace likeness {

enum class Fault {
  no_face,
  second_person,
  too_short,
  incomplete,
  blurred,
  too_dark,
  too_bright,
  small_face,
  head_cut,
  few_angles,
  few_expressions,
  light_changes,
  camera_shakes,
  plain_background
};
std::string_view fault_name(Fault fault);  // as written above

struct Remark {
  Fault fault = Fault::no_face;
  bool grave = false;  // it will not make a good avatar
  double from_s = 0,
         to_s = 0;           // the longest stretch that shows it; the whole clip for a fault of the whole
  std::string what, remedy;  // sentences
};

enum class Verdict { ready, usable, refilm };
std::string_view verdict_name(Verdict verdict);

struct CaptureVerdict {
  Verdict verdict = Verdict::ready;  // refilm with a grave remark, usable with any
  std::vector<Remark> remarks{};     // the grave ones first
  bool faceless = false;             // import would refuse it: hardly a picture shows a face
};
std::string_view verdict_words(const CaptureVerdict& verdict);  // a sentence for people

// One of the expressions an avatar needs, as far as the clip shows it.
struct KeyExpressionShown {
  std::string_view words;        // "smile"
  double range = 0, needed = 0;  // how much its amount varies, 0..1; the range from which it counts as shown
};
std::array<KeyExpressionShown, kKeyExpressions.size()> key_expressions_shown(const ClipMeasures& measures);

// Whether this one picture shows the fault; for faults of the whole clip, true for every picture.
bool shows_fault(const Look& look, Fault fault);

CaptureVerdict judge_capture(const ClipMeasures& measures);

}  // namespace likeness
