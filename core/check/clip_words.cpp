// See clip_words.h.
#include "core/check/clip_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/capture/choose_shots.h"

namespace likeness {
namespace {

constexpr double kWorthSaying_s = 0.5;  // of a clip: less of it is not worth a word
constexpr double kWellSeen = 0.8;       // of the frames: below it, the prior is often missing

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  return text;
}

// "1 frame", "20 frames"
std::string frames_words(int count) { return fmt::format("{} frame{}", count, count == 1 ? "" : "s"); }

double left_out_s(const std::vector<ClipShot>& shots) {
  double left_out = 0;
  for (const ClipShot& shot : shots)
    if (!shot.used) left_out += shot.to_s - shot.from_s;
  return left_out;
}

std::string cut_words(const std::vector<ClipShot>& shots) {
  if (left_out_s(shots) > 0)
    return fmt::format("outside {} it shows another place, angle or crop, or no face", serving_words(shots));
  std::vector<std::string> times;
  for (std::size_t i = 1; i < shots.size(); ++i) times.push_back(fmt::format("{:.1f} s", shots[i].from_s));
  return fmt::format("it is cut at {}", joined(times));
}

std::string bars_words(const PartsFacts& facts) {
  const bool above = facts.film.height < facts.height, beside = facts.film.width < facts.width;
  return fmt::format("the bars {} are cut off", above && beside ? "round it"
                                                : above         ? "above and below it"
                                                                : "beside it");
}

PartsFacts parts_of(const Capture& capture) {
  PartsFacts facts;
  facts.frames = int(capture.frames.size());
  facts.width = capture.width, facts.height = capture.height, facts.film = capture.film;
  facts.shots = capture.shots;
  if (capture.frames.empty()) return facts;
  int faceless = 0, blurred = 0;
  for (const CaptureFrame& frame : capture.frames) {
    faceless += frame.refused.starts_with("No face");
    blurred += frame.refused.starts_with("Blurred");
    facts.repeated += frame.refused.starts_with("Repeats");
  }
  const double steps = std::max(1, facts.frames - 1);
  const double each_s = (capture.frames.back().time_s - capture.frames.front().time_s) / steps;
  facts.seconds = each_s * facts.frames;
  facts.faceless_s = each_s * faceless, facts.blurred_s = each_s * blurred;
  return facts;
}

}  // namespace

const char* camera_kind_words(CameraKind kind) {
  constexpr std::array<const char*, 3> kWords{"resting", "held in the hand", "walking"};
  return kWords[std::size_t(kind)];
}

ClipFacts clip_facts(const ClipResults& results) {
  ClipFacts facts;
  facts.camera.stated = results.stated.has_value();
  facts.camera.kind = results.stated;
  if (results.cameras && (!results.stated || results.cameras->kind == *results.stated)) {
    facts.camera.kind = results.cameras->kind, facts.camera.evidence = results.camera_evidence;
    // What the align stage falls back on, it is "taken to" be.
    facts.camera.sure = results.camera_evidence.find(" taken to ") == std::string::npos;
  }
  if (results.mattes)
    facts.mask = {results.mattes->prior, results.mattes->frames, results.mattes->prior_frames};
  else if (results.person_network)
    facts.mask.prior = MaskPrior::person_network;
  if (results.capture) facts.parts = parts_of(*results.capture);
  return facts;
}

ClipFacts joined_facts(ClipFacts first, const ClipFacts& other) {
  if (!first.camera.kind) first.camera = other.camera;
  if (first.mask.frames == 0) first.mask = other.mask;
  if (first.parts.frames == 0) first.parts = other.parts;
  return first;
}

std::string camera_sentence(const CameraFacts& facts) {
  if (!facts.kind) return "What the camera does is not known yet: it is found out when the avatar is made.";
  if (facts.stated)
    return fmt::format("As you said, the camera {}.", *facts.kind == CameraKind::resting ? "rests"
                                                      : *facts.kind == CameraKind::handheld
                                                          ? "is held in the hand"
                                                          : "walks");
  switch (*facts.kind) {
    case CameraKind::resting:
      return facts.sure
                 ? "The camera rests: nothing behind the person moves."
                 : "The camera seems to rest: what is behind the person is too plain, or too hidden, to "
                   "show whether it moves.";
    case CameraKind::handheld:
      return facts.sure ? "The camera is held in the hand: it sways and turns about one place."
                        : "The camera seems to be held in the hand.";
    case CameraKind::walking:
      return facts.sure
                 ? "The camera walks: what is near and what is far behind the person move apart."
                 : "The camera seems to walk: neither a camera at rest nor one that only turns would show "
                   "such a background.";
  }
  return {};
}

std::string mask_sentence(const MaskFacts& facts) {
  if (facts.prior == MaskPrior::none)
    return "The person network is not used, so the mask follows the tracked head and colours alone: look "
           "whether hair and clothes are cut out whole.";
  if (facts.prior == MaskPrior::clip) return "The clip brings its own mask of the person.";
  const char* name = facts.prior == MaskPrior::person_network ? "The person network" : "The matting network";
  if (facts.frames == 0) return fmt::format("{} is there and will say who is the person.", name);
  const double share = double(facts.used) / facts.frames;
  return fmt::format(
      "{} sees the person in {:.0f} % of {}: {}", name, 100 * share, frames_words(facts.frames),
      share >= kWellSeen ? "the mask can be trusted."
                         : "in the others the mask follows the tracked head and colours alone.");
}

std::string parts_sentence(const PartsFacts& facts) {
  const double lost = facts.faceless_s + facts.blurred_s + left_out_s(facts.shots);
  const double serve = std::max(0.0, facts.seconds - lost);
  std::vector<std::string> why;
  if (facts.faceless_s >= kWorthSaying_s)
    why.push_back(fmt::format("{:.1f} s show no face", facts.faceless_s));
  if (facts.blurred_s >= kWorthSaying_s) why.push_back(fmt::format("{:.1f} s are blurred", facts.blurred_s));
  if (facts.repeated > 0)
    why.push_back(fmt::format("{} of {} only repeat{} the one before", facts.repeated,
                              frames_words(facts.frames), facts.repeated == 1 ? "s" : ""));
  if (!facts.film.empty()) why.push_back(bars_words(facts));
  if (facts.shots.size() > 1) why.push_back(cut_words(facts.shots));
  std::string text = lost < kWorthSaying_s
                         ? fmt::format("All {:.1f} s of the clip serve", facts.seconds)
                         : fmt::format("{:.1f} of {:.1f} s of the clip serve", serve, facts.seconds);
  return text + (why.empty() ? "." : ": " + joined(why) + ".");
}

}  // namespace likeness
