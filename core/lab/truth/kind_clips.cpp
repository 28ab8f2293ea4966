// The list, and the rules: see kind_clips.h.
#include "core/lab/truth/kind_clips.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/synth/demo_camera.h"

namespace likeness {
namespace {

struct Format {
  int width, height;
};
constexpr Format kSmall{320, 180}, kWide{400, 224}, kUpright{224, 400};

// Who is filmed in which light; `seed` also draws a hand's sway and a film's cuts.
struct Cast {
  int person, light, seed;
};

DemoOptions film(DemoCamera camera, Format format, int frames, Cast cast) {
  DemoOptions options;
  options.camera = camera;
  options.width = format.width, options.height = format.height;
  options.frames = frames;
  options.samples_per_pixel = 2;
  options.person = cast.person, options.light = cast.light, options.seed = cast.seed;
  return options;
}

DemoOptions held(double turn_deg, double shift_mm, Format format, int frames, Cast cast) {
  DemoOptions options = film(DemoCamera::handheld, format, frames, cast);
  options.hand_turn_deg = turn_deg, options.hand_shift_m = shift_mm / 1000;
  return options;
}

DemoOptions before(DemoWall wall, DemoOptions options) {
  options.wall = wall;
  return options;
}

DemoOptions with(bool DemoOptions::*fault, DemoOptions options) {
  options.*fault = true;
  return options;
}

// Which kind of cut the only one is follows from the seed (core/synth/demo_shots.h): of those that three
// divides a jump, of the next ones a closer crop.
DemoOptions cut(DemoOptions options) {
  options.cuts = 1;
  return options;
}

std::vector<KindClip> make_clips() {
  using enum DemoCamera;
  constexpr DemoWall kPlain = DemoWall::plain, kTextured = DemoWall::textured;
  constexpr auto kDrift = &DemoOptions::drift, kBlur = &DemoOptions::motion_blur,
                 kTag = &DemoOptions::lens_tag;
  return {
      {"rest-furnished", film(resting, kSmall, 75, {0, 0, 1})},
      {"rest-textured", before(kTextured, film(resting, kUpright, 75, {1, 1, 2}))},
      {"rest-plain", before(kPlain, film(resting, kSmall, 75, {2, 2, 3}))},
      {"rest-drift", with(kTag, with(kDrift, film(resting, kWide, 75, {3, 0, 4})))},
      {"hand-small", held(1, 1.5, kSmall, 90, {4, 1, 5})},
      {"hand-small-textured", before(kTextured, held(1, 1.5, kUpright, 90, {5, 2, 6}))},
      {"hand-large", with(kTag, held(6, 1.5, kWide, 90, {0, 1, 7}))},
      {"hand-large-textured", with(kBlur, before(kTextured, held(6, 1.5, kSmall, 75, {1, 2, 8})))},
      {"hand-large-plain", before(kPlain, held(6, 1.5, kSmall, 75, {2, 0, 9}))},
      {"hand-small-aside", held(1, 10, kSmall, 90, {3, 2, 10})},
      {"hand-aside-textured", before(kTextured, held(3, 10, kUpright, 90, {4, 0, 11}))},
      {"hand-large-aside", with(kDrift, held(6, 10, kWide, 90, {5, 1, 12}))},
      {"zoom-furnished", film(zoom, kSmall, 100, {0, 2, 13})},
      {"zoom-textured", with(kDrift, before(kTextured, film(zoom, kUpright, 100, {1, 0, 14})))},
      {"slide-furnished", film(slide, kWide, 90, {2, 1, 15})},
      {"slide-textured", with(kBlur, before(kTextured, film(slide, kUpright, 75, {3, 2, 16})))},
      {"walk-furnished", film(walking, kSmall, 100, {4, 0, 17})},
      {"walk-upright", with(kTag, with(kBlur, film(walking, kUpright, 80, {5, 1, 18})))},
      {"walk-textured", before(kTextured, film(walking, kSmall, 100, {0, 2, 19}))},
      {"walk-plain", before(kPlain, film(walking, kSmall, 75, {1, 0, 20}))},
      {"guided-upright", with(kDrift, film(guided, kUpright, 100, {2, 1, 23}))},
      {"cut-rest", cut(film(resting, kSmall, 75, {3, 2, 21}))},
      {"cut-closer", cut(film(resting, kWide, 75, {4, 0, 22}))},
      {"cut-hand", cut(held(3, 1.5, kSmall, 90, {5, 1, 24}))},
  };
}

}  // namespace

const std::vector<KindClip>& kind_clips() {
  static const std::vector<KindClip> clips = make_clips();
  return clips;
}

Result<std::vector<KindClip>> kind_clips_named(const std::vector<std::string>& names) {
  if (names.empty()) return kind_clips();
  const auto is_named = [&](const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  };
  for (const std::string& name : names)
    if (std::ranges::find(kind_clips(), name, &KindClip::name) == kind_clips().end()) {
      std::vector<std::string> known;
      for (const KindClip& clip : kind_clips()) known.push_back(clip.name);
      return Error{ErrorCode::bad_input, fmt::format("There is no made clip \"{}\".", name),
                   fmt::format("Choose of: {}.", fmt::join(known, ", ")), name};
    }
  std::vector<KindClip> chosen;
  for (const KindClip& clip : kind_clips())
    if (is_named(clip.name)) chosen.push_back(clip);
  return chosen;
}

const char* demo_wall_name(DemoWall wall) {
  constexpr const char* kNames[] = {"furnished", "plain", "textured"};
  return kNames[int(wall)];
}

std::string demo_words(const DemoOptions& film) {
  std::string words = fmt::format("--camera {} --wall {} --size {} --height {} --frames {} --samples {}",
                                  demo_camera_names()[std::size_t(film.camera)], demo_wall_name(film.wall),
                                  film.width, film.height, film.frames, film.samples_per_pixel);
  words += fmt::format(" --person {} --light {} --seed {}", film.person, film.light, film.seed);
  if (film.camera == DemoCamera::guided) words += fmt::format(" --moving-share {}", film.moving_share);
  if (film.camera == DemoCamera::handheld || film.camera == DemoCamera::zoom)
    words += fmt::format(" --hand-turn {} --hand-shift {:.6g}", film.hand_turn_deg, 1000 * film.hand_shift_m);
  if (film.cuts > 0) words += fmt::format(" --cuts {}", film.cuts);
  if (film.hair == DemoHair::loose) words += " --hair loose";
  const std::pair<bool, const char*> flags[] = {
      {film.restless_head, " --restless-head"}, {film.habit, " --habit"},
      {film.still_torso, " --still-torso"},     {film.drift, " --drift"},
      {film.motion_blur, " --motion-blur"},     {film.lens_tag, " --lens-tag"}};
  for (const auto& [set, word] : flags)
    if (set) words += word;
  return words;
}

const char* kind_outcome_name(KindOutcome outcome) {
  constexpr const char* kNames[] = {"right", "by default", "untold", "wrong"};
  return kNames[int(outcome)];
}

KindOutcome judge_kind(DemoWall wall, CameraKind truth, const std::optional<KindFound>& found) {
  if (!found) return KindOutcome::wrong;
  if (wall == DemoWall::plain && found->kind == CameraKind::resting && found->assumed)
    return KindOutcome::untold;
  if (wall == DemoWall::textured && truth == CameraKind::walking && found->kind == CameraKind::handheld)
    return KindOutcome::untold;
  if (found->kind != truth) return KindOutcome::wrong;
  return found->assumed ? KindOutcome::by_default : KindOutcome::right;
}

const std::vector<std::string>& kind_rules() {
  static const std::vector<std::string> rules = {
      "right: the true kind, which the pictures showed",
      "by default: the true kind, but it was assumed, though the pictures show it",
      "untold: no picture shows the kind. Before a plain wall the camera was taken to rest; a walk along a "
      "flat, textured one was called hand-held",
      "wrong: anything else"};
  return rules;
}

void KindCount::add(KindOutcome outcome) {
  int* const counts[] = {&right, &by_default, &untold, &wrong};
  ++*counts[int(outcome)];
}

std::string kind_count_words(const KindCount& count) {
  std::string words =
      fmt::format("{} of {} right", count.right, count.right + count.by_default + count.wrong);
  if (count.by_default > 0) words += fmt::format(", {} by default", count.by_default);
  if (count.wrong > 0) words += fmt::format(", {} wrong", count.wrong);
  if (count.untold > 0) words += fmt::format("; of {} more nothing can be told", count.untold);
  return words;
}

}  // namespace likeness
