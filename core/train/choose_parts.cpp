// The rules, and their reasons: see choose_parts.h.
#include "core/train/choose_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <string>
#include <utility>

#include "core/train/condition_map.h"
#include "core/train/exposure.h"
#include "core/train/proxy_views.h"

namespace likeness {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kTitles{{
    {"expression", "Expression"},
    {"deformation", "Deformation by the head model"},
    {"gaze", "Where the eyes look"},
    {"still", "Hair and skull keep still"},
    {"torso", "Torso"},
    {"background", "Background"},
    {"light", "Exposure and white balance"},
    {"code", "Code for each frame"},
    {"proxies", "What was not filmed"},
    {"grid", "Grid"},
    {"clips", "Further clips"},
    {"occupancy", "Empty space skipped"},
    {"refine_track", "Track corrected during training"},
    {"landmark_loss", "Landmark loss"},
}};

std::string millimetres(double metres) { return fmt::format("{:.2g} mm", 1000 * metres); }

// -- Expression and deformation: the mode.

FieldMode mode_by_measures(const CaptureMeasures& m) {
  return m.face_motion < kStillFace ? FieldMode::static_ : kDefaultMode;
}

std::string mode_reason(const CaptureMeasures& m, const AskedParts& asked) {
  const FieldMode own = mode_by_measures(m);
  const std::string moves = fmt::format("he face moves by {} (root mean square over {} frames)",
                                        millimetres(m.face_motion), m.frames + m.further_frames);
  if (asked.mode)
    return fmt::format("You asked for --mode {}; otherwise it would be {}: t{}.", mode_name(*asked.mode),
                       mode_name(own), moves);
  if (own == FieldMode::static_)
    return fmt::format(
        "T{}: less than {}, too little to learn from. With --mode {} the head model would still move it.",
        moves, millimetres(kStillFace), mode_name(kDefaultMode));
  return fmt::format("T{}; less than {} would be too little to learn from.", moves, millimetres(kStillFace));
}

void add_mode(const CaptureMeasures& m, const AskedParts& asked, ChosenParts& chosen) {
  chosen.mode = asked.mode.value_or(mode_by_measures(m));
  const ModeParts parts = mode_parts(chosen.mode);
  const std::string reason = mode_reason(m, asked);
  chosen.parts.push_back({"expression", parts.expression, asked.mode.has_value(),
                          !parts.expression ? "not an input of the field"
                          : parts.ambient   ? "chooses a slice of a hyper-space"
                                            : "its numbers are inputs beside the features",
                          reason});
  const std::string turns =
      fmt::format(" The head is seen from {:.0f} degrees side to side and {:.0f} up and down.",
                  m.yaw * kDegrees, m.pitch * kDegrees);
  chosen.parts.push_back({"deformation", parts.warp, asked.mode.has_value(),
                          parts.warp ? "the head model takes samples to the face at rest" : "none",
                          reason + turns});
}

// -- Further inputs of the field.

void add_gaze(const CaptureMeasures& m, ChosenParts& chosen) {
  const bool conditioned = mode_parts(chosen.mode).expression;
  const double most = std::max(m.gaze_pitch, m.gaze_yaw);
  chosen.gaze = conditioned && most >= kSmallestGaze;
  std::string reason =
      !conditioned
          ? std::string("The field is not conditioned on the expression, which includes the eyes.")
          : fmt::format(
                "The eyes turn by {:.1f} degrees from side to side and {:.1f} up and down (root mean "
                "square); {:.1f} are needed.",
                m.gaze_yaw * kDegrees, m.gaze_pitch * kDegrees, kSmallestGaze * kDegrees);
  chosen.parts.push_back({"gaze", chosen.gaze, false,
                          chosen.gaze ? "an input of the field" : "not an input of the field",
                          std::move(reason)});
}

void add_still(const CaptureMeasures& m, ChosenParts& chosen) {
  chosen.still = m.turn >= kHardlyTurns;
  const std::string turns =
      fmt::format("The head turns by {:.1f} degrees (root mean square)", m.turn * kDegrees);
  if (chosen.still)
    chosen.parts.push_back({"still", true, false, "neither expression nor code changes them",
                            turns + ": a field that may use the expression where it moves nothing would "
                                    "memorise the track's errors."});
  else
    chosen.parts.push_back(
        {"still", false, false, "they may follow the expression",
         fmt::format("{}; from {:.0f} on, the hair would learn only the track's errors from the expression.",
                     turns, kHardlyTurns * kDegrees)});
}

// -- Torso and background.

void add_torso(const CaptureMeasures& m, ChosenParts& chosen) {
  chosen.torso = m.torso_followed && m.torso_share >= kTorsoShare;
  std::string reason =
      !m.torso_followed
          ? std::string("The track followed no torso: too little of it is in the picture.")
          : fmt::format(
                "Below and beside the neck the person fills {:.0f} % of the picture; {:.0f} % is needed.",
                100 * m.torso_share, 100 * kTorsoShare);
  chosen.parts.push_back({"torso", chosen.torso, false,
                          chosen.torso ? "a field of its own, which follows collar and shoulders" : "none",
                          std::move(reason)});
}

void add_background(const CaptureMeasures& m, ChosenParts& chosen) {
  chosen.plate = m.has_plate;
  const std::string light =
      m.light_drift ? fmt::format(" Its light differs by {:.1f} % between frames.", 100 * *m.light_drift)
                    : "";
  const std::string fault = m.background_fault.empty() ? "" : " " + m.background_fault;
  const auto add = [&](bool on, const char* value, std::string reason) {
    chosen.parts.push_back({"background", on, false, value, std::move(reason)});
  };
  if (chosen.plate && m.has_room)
    add(true, "a picture of the background, and a room for the moving camera",
        fmt::format("The camera rests in {:.0f} % of {} frames and moves in the others.{}{}",
                    100 * m.plate_share, m.frames, light, fault));
  else if (chosen.plate && m.has_mosaic)
    add(true, "one picture of the background, wider than a frame",
        fmt::format("The camera is hand-held: it turns and zooms before a wall in all of {} frames.{}{}",
                    m.frames, light, fault));
  else if (chosen.plate)
    add(true, "one picture of the background",
        fmt::format("The camera rests in {:.0f} % of {} frames.{}{}", 100 * m.plate_share, m.frames, light,
                    fault));
  else if (m.has_room)
    add(true, "a room of its own, seen from where the camera is", "The camera moves throughout.");
  else if (!fault.empty())
    add(false, "none: a plain colour stands behind the person", m.background_fault);
  else
    add(false, "none: the mattes separate the person",
        "The camera moves, or no frame showed the background behind the person.");
}

void add_light(const CaptureMeasures& m, ChosenParts& chosen) {
  if (!m.light_drift || *m.light_drift < kEvenLight || !chosen.plate || m.plate_share < kMostlyPlate) return;
  chosen.exposures = m.exposures;
  chosen.parts.push_back(
      {"light", true, false, "evened out before training",
       fmt::format("The light on the background differs by {:.1f} % between frames (root mean square); from "
                   "{:.1f} % on, a face would have a colour for each of them.",
                   100 * *m.light_drift, 100 * kEvenLight)});
}

void add_proxies(const CaptureMeasures& m, const AskedParts& asked, ChosenParts& chosen) {
  chosen.proxies = !asked.no_proxies && chosen.mode == kDefaultMode;
  if (asked.no_proxies) {
    chosen.parts.push_back({"proxies", false, true, "left to the field", "You asked for --no-proxies."});
    return;
  }
  if (!chosen.proxies) {
    chosen.parts.push_back({"proxies", false, true, "left to the field",
                            fmt::format("Mode {} is as others have it.", mode_name(chosen.mode))});
    return;
  }
  chosen.parts.push_back(
      {"proxies", true, false, "taught by the head model, in the clip's colours",
       fmt::format(
           "The camera sees the head from {:.0f} degrees of sides and {:.0f} of heights; of what lies "
           "beyond, and of what the face never does, only the head model knows. The same for every capture.",
           m.yaw * kDegrees, m.pitch * kDegrees)});
}

// -- Sizes.

void add_sizes(const CaptureMeasures& m, const AskedParts& asked, ChosenParts& chosen) {
  chosen.latent = !asked.no_latent;
  const std::string light =
      m.light_drift ? fmt::format("; the light alone differs by {:.1f} %", 100 * *m.light_drift) : "";
  if (asked.no_latent)
    chosen.parts.push_back({"code", false, true, "none", "You asked for --no-latent."});
  else
    chosen.parts.push_back({"code", true, false, fmt::format("{} numbers", chosen.sizes.code_length),
                            fmt::format("They absorb what differs between {} frames and no expression "
                                        "explains{}. The same for every capture.",
                                        m.frames + m.further_frames, light)});
  const FieldSizes& s = chosen.sizes;
  std::string value =
      fmt::format("{} entries a level, {} cells along an axis", 1 << s.head_log2_entries, s.head_finest);
  if (chosen.torso)
    value += fmt::format("; the torso's {} and {}", 1 << s.torso_log2_entries, s.torso_finest);
  chosen.parts.push_back(
      {"grid", true, false, std::move(value),
       fmt::format("The same for every capture: no other size measured better for pictures of {} px.",
                   m.size)});
}

// -- Parts that are listed only when there is something to say.

void add_others(const CaptureMeasures& m, const AskedParts& asked, ChosenParts& chosen) {
  if (m.further_frames > 0)
    chosen.parts.push_back({"clips", true, true, "teach the head",
                            fmt::format("You added clips; {} of their frames train.", m.further_frames)});
  if (asked.no_occupancy)
    chosen.parts.push_back({"occupancy", false, true, "no", "You asked for --no-occupancy."});
  if (asked.refine_track)
    chosen.parts.push_back(
        {"refine_track", true, true, "through the field", "You asked for --refine-track."});
  if (asked.landmark_weight > 0)
    chosen.parts.push_back({"landmark_loss", true, true, fmt::format("weight {:g}", asked.landmark_weight),
                            fmt::format("You asked for --landmark-loss {:g}.", asked.landmark_weight)});
}

}  // namespace

ChosenParts choose_parts(const CaptureMeasures& measures, const AskedParts& asked) {
  ChosenParts chosen;
  add_mode(measures, asked, chosen);
  add_gaze(measures, chosen);
  add_still(measures, chosen);
  add_torso(measures, chosen);
  add_background(measures, chosen);
  add_light(measures, chosen);
  add_proxies(measures, asked, chosen);
  add_sizes(measures, asked, chosen);
  add_others(measures, asked, chosen);
  return chosen;
}

void apply_parts(const ChosenParts& parts, TrainingSet& set, TrainOptions& options) {
  if (!parts.exposures.empty()) even_exposure(parts.exposures, set);
  if (!parts.torso) set.has_torso = false, set.torso_modes = {};
  if (!parts.plate) {
    set.plate = {}, set.plate_known = {}, set.plate_camera = {};
    for (TrainingView& view : set.views)
      if (view.further_clip == 0) view.has_plate = false;
  }
  set.proxies = parts.proxies ? make_proxy_views(set) : std::vector<TrainingView>();
  options.fields.mode = parts.mode;
  options.fields.use_latent = parts.latent;
  options.fields.use_gaze = parts.gaze;
  options.fields.use_still = parts.still;
  options.fields.sizes = parts.sizes;
}

bool is_evenly_lit(const Avatar& avatar) {
  return std::ranges::any_of(avatar.parts,
                             [](const AvatarPart& part) { return part.name == "light" && part.on; });
}

std::string_view part_title(std::string_view name) {
  const auto found = std::ranges::find(kTitles, name, &std::pair<std::string_view, std::string_view>::first);
  return found == kTitles.end() ? name : found->second;
}

}  // namespace likeness
