// See option_table.h.
#include "core/project/option_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/capture/split.h"
#include "core/face/landmarks.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

using O = ProjectOptions;

constexpr OptionVerbs kNewProject{.build = true, .import = true};
constexpr OptionVerbs kTraining{.build = true, .train = true};
constexpr OptionVerbs kShape{.build = true, .fit = true};
constexpr OptionVerbs kAblation{.build = true};
constexpr double kMostSeconds = 1e6;  // of a clip

std::vector<OptionRow> make_table() {
  using enum Stage;
  return {
      {.key = "video",
       .member = [](O& o) -> fs::path& { return o.shared.video; },
       .stale = {import, align},
       .in_every_project = true},
      {.key = "size_px",
       .member = [](O& o) -> int& { return o.import.size; },
       .stale = {import},
       .flag = "--size",
       .help = "Side of the pictures, px",
       .verbs = kNewProject,
       .range = {.low = 64, .high = 2048},
       .choices = {256, 512, 1024},
       .in_every_project = true,
       .of_the_person = true,
       .studio = {.label = "Pictures",
                  .hint = "Larger pictures show more and take about four times as long per step.",
                  .unit = "px",
                  .offered = {256, 512, 1024}}},
      {.key = "split",
       .member = [](O& o) -> Split& { return o.import.split; },
       .stale = {import, align},
       .flag = "--split",
       .help = "What is held out to measure on: the last tenth (tail, the default), a tenth of what a moving "
               "camera filmed, in a row (views), three tenths at random (random30), or what sees the head "
               "from far off its typical side (sides)",
       .verbs = kNewProject},
      {.key = "inside_deg",
       .member = [](O& o) -> double& { return o.import.sides.inside_deg; },
       .flag = "--inside",
       .help = "Of --split sides: frames that see the head from within so many degrees of its typical side "
               "train, but for the last tenth of them, which is held out; default: 10",
       .verbs = kNewProject,
       .range = {.low = 1, .high = 90}},
      {.key = "beyond_deg",
       .member = [](O& o) -> double& { return o.import.sides.beyond_deg; },
       .flag = "--beyond",
       .help = "Of --split sides: frames that see it from farther than so many degrees are held out, and "
               "those between are neither; default: 20",
       .verbs = kNewProject,
       .range = {.low = 1, .high = 90}},
      {.key = "from_s",
       .member = [](O& o) -> double& { return o.import.seconds.from_s; },
       .stale = {import},
       .range = {.low = 0, .high = kMostSeconds}},
      {.key = "to_s",
       .member = [](O& o) -> double& { return o.import.seconds.to_s; },
       .stale = {import},
       .range = {.low = 0, .high = kMostSeconds}},
      {.key = "camera_kind",
       .member = [](O& o) -> std::optional<CameraKind>& { return o.align.camera; },
       .stale = {align},
       .flag = "--camera-kind",
       .help =
           "What the camera does: it rests (resting), is held in a hand and turns or zooms about one place "
           "(handheld), or walks round the head (walking); default: found out from the clip (auto)",
       .verbs = {.build = true, .import = true, .align = true}},
      {.key = "lens_mm",
       .member = [](O& o) -> double& { return o.align.lens_mm; },
       .stale = {align},
       .flag = "--lens",
       .help = "Focal length of a resting or hand-held camera, in mm as on 35 mm film (36 mm the longer "
               "side); default: as the clip says, or a usual one. 0: the default again",
       .verbs = {.build = true, .import = true, .align = true, .fit = true},
       .range = {.low = 8, .high = 2000, .or_zero = true}},
      {.key = "head_model",
       .member = [](O& o) -> fs::path& { return o.shared.head_model; },
       .stale = {fit, matte},
       .flag = "--head-model",
       .help = "A head model: FLAME's .pkl, ICT-FaceKit's folder, or a .npz; default: the built-in head",
       .verbs = {.build = true, .import = true, .fit = true},
       .in_every_project = true,
       .of_the_person = true},
      {.key = "matting_network",
       .member = [](O& o) -> fs::path& { return o.matte.matting_network; },
       .stale = {matte},
       .flag = "--matting-network",
       .help = "A matting or parsing network (.onnx) to tell the person from the background with",
       .verbs = kNewProject,
       .of_the_person = true},
      {.key = "person_network",
       .member = [](O& o) -> fs::path& { return o.shared.person_network; },
       .stale = {align, matte},
       .flag = "--person-network",
       .help =
           "A network (.onnx) to find the person with, or none; default: the installed one, if there is one",
       .verbs = {.build = true, .import = true, .align = true, .fit = true},
       .of_the_person = true,
       .words = {"none"}},
      {.key = "landmark_model",
       .member = [](O& o) -> fs::path& { return o.shared.landmark_model; },
       .stale = {import, align, fit},
       .flag = "--landmark-model",
       .help = kLandmarkModelHelp,
       .verbs = kNewProject,
       .in_every_project = true,
       .of_the_person = true,
       .words = {kNetworkLandmarks, kDlibLandmarks}},
      {.key = "budget_s",
       .member = [](O& o) -> double& { return o.train.budget_s; },
       .stale = {train},
       .flag = "--budget",
       .help = "Seconds of training; placing further clips and --refine-track take theirs on top",
       .verbs = kTraining,
       .range = {.low = 1, .high = 1e6},
       .in_every_project = true,
       .studio = {.label = "Training",
                  .hint = "Longer training sharpens teeth, eyes and hair. It can go on later, too.",
                  .unit = "min",
                  .one_unit = 60,
                  .offered = {120, 300, 900, 3600}}},
      {.key = "full_budget_s", .member = [](O& o) -> double& { return o.train.full_budget_s; }},
      {.key = "checkpoint_every_s",
       .member = [](O& o) -> double& { return o.train.checkpoint_every_s; },
       .flag = "--checkpoint-every",
       .help = "Seconds between checkpoints",
       .verbs = kTraining,
       .range = {.low = 0.1, .high = 3600}},
      {.key = "steps",
       .member = [](O& o) -> std::uint64_t& { return o.train.steps; },
       .stale = {train},
       .flag = "--steps",
       .help = "Exact training steps instead of a budget",
       .verbs = kTraining,
       .in_every_project = true},
      {.key = "mode",
       .member = [](O& o) -> std::optional<FieldMode>& { return o.train.mode; },
       .stale = {train},
       .flag = "--mode",
       .help =
           "What the field knows of the expression: nothing (static), its numbers (concat), a slice chosen "
           "by them (hyper), the head model's deformation and the numbers (warp), or that and the slice "
           "(warp+hyper); default: chosen from the capture (auto)",
       .verbs = kTraining,
       .in_every_project = true},
      {.key = "landmark_loss",
       .member = [](O& o) -> double& { return o.train.landmark_loss; },
       .stale = {train},
       .flag = "--landmark-loss",
       .help = "Weight of a loss on where landmarks lie in the pictures, e.g. 0.1; default: 0, off",
       .verbs = kTraining,
       .range = {.low = 0, .high = 1e3}},
      {.key = "refits",
       .member = [](O& o) -> std::vector<RefitSpan>& { return o.fit.refits; },
       .stale = {fit},
       .flag = "--refit",
       .help = "Fit only these spans of frames again, from the good frames around them: 190-204 or 12,40-60, "
               "in addition to earlier ones; none undoes them all",
       .verbs = {.fit = true},
       .kept_with_clip = true},
      {.key = "rest_frames",
       .member = [](O& o) -> std::vector<int>& { return o.fit.rest_frames; },
       .stale = {fit},
       .flag = "--rest",
       .help = "Frames that show the person's face at rest, mouth closed: 12 or 12,40-60, in place of those "
               "the fit finds; auto: found again",
       .verbs = kShape,
       .kept_with_clip = true,
       .taken_back = "auto"},
      {.key = "identity",
       .member = [](O& o) -> fs::path& { return o.fit.identity; },
       .stale = {fit},
       .flag = "--identity",
       .help = "The person's shape, held instead of fitted: identity coefficients of the head model (MICA's "
               "identity.npy for FLAME) or its vertices in metres, as .npy, .npz or .obj; none: fitted again",
       .verbs = kShape,
       .kept_with_clip = true},
      {.key = "displacement",
       .member = [](O& o) -> fs::path& { return o.fit.displacement; },
       .stale = {fit},
       .flag = "--displacement",
       .help = "A folder of detail maps, one per frame: heights in mm along the normal on the head model's "
               "texture, 000360.npy, .exr or .tif of floats or .png of 16 bits (32768 is zero, one step a "
               "micrometre); none: no maps from now on",
       .verbs = kShape,
       .kept_with_clip = true},
      {.key = "use_latent",
       .member = [](O& o) -> bool& { return o.train.use_latent; },
       .stale = {train},
       .flag = "--no-latent",
       .help = "Ablation: without the per-frame code",
       .verbs = kAblation,
       .in_every_project = true},
      {.key = "refine_track",
       .member = [](O& o) -> bool& { return o.train.refine_track; },
       .stale = {train},
       .flag = "--refine-track",
       .help = "Correct the training frames' poses and faces through the field while it learns",
       .verbs = kAblation},
      {.key = "use_occupancy",
       .member = [](O& o) -> bool& { return o.train.use_occupancy; },
       .stale = {train},
       .flag = "--no-occupancy",
       .help = "Ablation: without the occupancy grid",
       .verbs = kAblation,
       .in_every_project = true},
      {.key = "use_proxies",
       .member = [](O& o) -> bool& { return o.train.use_proxies; },
       .stale = {train},
       .flag = "--no-proxies",
       .help = "Ablation: nothing is taught of what was not filmed",
       .verbs = kAblation},
      {.key = "left_out",
       .member = [](O& o) -> std::vector<int>& { return o.train.left_out; },
       .stale = {train},
       .flag = "--leave-out",
       .help = "Frames left out of training from now on: 12,40-60, or none",
       .verbs = {.train = true},
       .kept_with_clip = true},
      {.key = "seed",
       .member = [](O& o) -> std::uint64_t& { return o.shared.seed; },
       .stale = {align, train},
       .flag = "--seed",
       .help = "Seed of everything random",
       .verbs = {.build = true, .import = true, .align = true, .fit = true, .train = true},
       .in_every_project = true,
       .of_the_person = true},
  };
}

// "a, b or c"
template <class Names>
std::string one_of(const Names& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text.append(i == 0 ? "" : i + 1 < names.size() ? ", " : " or ").append(names[i]);
  return text;
}

std::string number_words(const char* kind, const OptionRange& range) {
  std::string words = std::isinf(range.high) ? fmt::format("{} of at least {}", kind, range.low)
                                             : fmt::format("{} from {} to {}", kind, range.low, range.high);
  if (range.or_zero) words += ", or 0";
  return words;
}

}  // namespace

const std::vector<OptionRow>& option_table() {
  static const std::vector<OptionRow> table = make_table();
  return table;
}

const OptionRow& option_row(std::string_view key) {
  const auto& table = option_table();
  const auto row = std::ranges::find(table, key, [](const OptionRow& r) { return std::string_view(r.key); });
  LIKENESS_CHECK(row != table.end(), "no option has this key");
  return *row;
}

void copy_option(const OptionRow& row, const ProjectOptions& from, ProjectOptions& to) {
  std::visit([&](auto member) { member(to) = member(const_cast<ProjectOptions&>(from)); }, row.member);
}

bool is_in_range(const OptionRow& row, double value) {
  const auto& [low, high, or_zero] = row.range;
  return (std::isfinite(value) && value >= low && value <= high) || (or_zero && value == 0);
}

std::string option_domain(const OptionRow& row) {
  struct Words {
    const OptionRow& row;
    std::string operator()(OptionMember<fs::path>) const { return "a path"; }
    std::string operator()(OptionMember<bool>) const { return "true or false"; }
    std::string operator()(OptionMember<int>) const { return number_words("a whole number", row.range); }
    std::string operator()(OptionMember<std::uint64_t>) const {
      return number_words("a whole number", row.range);
    }
    std::string operator()(OptionMember<double>) const { return number_words("a number", row.range); }
    std::string operator()(OptionMember<Split>) const {
      std::vector<std::string> names;
      for (const Split split : kSplits) names.emplace_back(split_name(split));
      return one_of(names);
    }
    std::string operator()(OptionMember<std::optional<CameraKind>>) const {
      return "auto, resting, handheld or walking";
    }
    std::string operator()(OptionMember<std::optional<FieldMode>>) const {
      std::vector<std::string> names;
      for (const FieldMode mode : kFieldModes) names.emplace_back(mode_name(mode));
      return one_of(names);
    }
    std::string operator()(OptionMember<std::vector<int>>) const { return "a list of frames"; }
    std::string operator()(OptionMember<std::vector<RefitSpan>>) const {
      return "a list of spans, each its first and its last frame";
    }
  };
  return std::visit(Words{row}, row.member);
}

}  // namespace likeness
