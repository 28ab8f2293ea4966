// The judgement: see verdict.h.
#include "core/check/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/base/quantile.h"
#include "core/capture/scan_clip.h"

namespace likeness {
namespace {

// Share of the looks that may show a fault before there is a remark, and before it is grave.
constexpr double kSomeLooks = 0.15, kMaxLooks = 0.5;
constexpr double kShortest_s = 6, kShort_s = 14;
constexpr double kBlurred = 20;                       // sharpness of a face, 8-bit units squared
constexpr double kDarkLevel = 45, kDarkShare = 0.35;  // luma; share of a face's pixels
constexpr double kBrightShare = 0.12;                 // burnt out
constexpr double kTinyFace = 80, kSmallFace = 120;    // px across the detector's box
constexpr double kCut = 0.06;                         // of the head's surroundings
constexpr double kFewTurn_deg = 30;                   // from side to side
constexpr double kFewNod_deg = 8;
constexpr double kMinPosed = 0.1;     // of the faces: fewer say nothing about what the clip shows
constexpr double kFrontal_deg = 15;   // the light is compared among looks nearer to the front than this
constexpr double kLightRatio = 1.35;  // of the face's brightness, between calm moments of the clip
constexpr double kFewTracks = 25;     // background features: too few to solve a moving camera from
constexpr double kGap_s = 1.0;        // gaps up to this do not end a stretch

struct KeyExpressionInfo {
  std::string_view words;
  double range;  // of its amount, from which it counts as shown
};
constexpr std::array<KeyExpressionInfo, kKeyExpressions.size()> kKeyExpressionInfo{
    {{"open the mouth wide", 0.18},
     {"smile", 0.25},
     {"purse the lips", 0.25},
     {"raise the brows", 0.25},
     {"blink", 0.3}}};

using Test = std::function<bool(const Look&)>;

struct Findings {
  int asked = 0, found = 0;
  double from_s = 0, to_s = 0;  // the longest stretch
  double share() const { return asked > 0 ? double(found) / asked : 0; }
};

Findings find(const std::vector<Look>& looks, const Test& applies, const Test& test) {
  Findings findings;
  double from = 0, last = -1e9;
  for (const Look& look : looks) {
    if (!applies(look)) continue;
    ++findings.asked;
    if (!test(look)) continue;
    if (look.time_s - last > kGap_s) from = look.time_s;
    last = look.time_s;
    if (findings.found++ == 0 || last - from > findings.to_s - findings.from_s)
      findings.from_s = from, findings.to_s = last;
  }
  return findings;
}

bool any(const Look&) { return true; }
bool has_face(const Look& look) { return look.face.has_value(); }
bool is_posed(const Look& look) { return look.posed; }
bool is_dark(const Look& look) { return look.level < kDarkLevel && look.dark_share > kDarkShare; }
// A dark or small face has no detail that could be sharp; that is a remark of its own.
bool is_blurred(const Look& look) {
  return look.sharpness < kBlurred && !is_dark(look) && look.face->width >= kTinyFace;
}
bool is_burnt(const Look& look) { return look.bright_share > kBrightShare; }
bool is_cut(const Look& look) { return look.cut_share > kCut; }
double yaw_of(const Look& look) { return look.yaw_deg; }
double pitch_of(const Look& look) { return look.pitch_deg; }

template <class F>
std::vector<double> values_of(const std::vector<Look>& looks, const Test& applies, F value) {
  std::vector<double> values;
  for (const Look& look : looks)
    if (applies(look)) values.push_back(value(look));
  return values;
}

template <class F>
double range_of(const std::vector<Look>& looks, const Test& applies, F value) {
  const std::vector<double> values = values_of(looks, applies, value);
  return quantile(values, 0.97) - quantile(values, 0.03);
}

// What of a film that was cut would serve: the rest is judged by nobody.
ClipMeasures serving_part(const ClipMeasures& whole) {
  ClipMeasures part = whole;
  std::erase_if(part.looks, [](const Look& look) { return !look.serves; });
  for (const ClipShot& shot : whole.shots)
    if (!shot.used) part.duration_s -= shot.to_s - shot.from_s;
  part.duration_s = std::max(0.0, part.duration_s);
  return part;
}

class Judge {
 public:
  explicit Judge(const ClipMeasures& clip) : clip_(serving_part(clip)) {}

  CaptureVerdict judge() {
    judge_people();
    if (share_of_faces_ > 0) {
      judge_pictures();
      judge_performance();
      judge_light();
    }
    judge_camera();
    std::stable_sort(out_.remarks.begin(), out_.remarks.end(),
                     [](const Remark& a, const Remark& b) { return a.grave && !b.grave; });
    if (!out_.remarks.empty()) out_.verdict = out_.remarks.front().grave ? Verdict::refilm : Verdict::usable;
    return std::move(out_);
  }

 private:
  void remark(Fault fault, bool grave, double from_s, double to_s, std::string what, std::string remedy) {
    out_.remarks.push_back({fault, grave, from_s, to_s, std::move(what), std::move(remedy)});
  }
  void remark_all(Fault fault, bool grave, std::string what, std::string remedy) {
    remark(fault, grave, 0, clip_.duration_s, std::move(what), std::move(remedy));
  }
  // A fault of individual pictures.
  void remark_looks(Fault fault, const Findings& findings, double grave_share, std::string_view what,
                    std::string remedy) {
    if (findings.share() < kSomeLooks) return;
    remark(fault, findings.share() >= grave_share, findings.from_s, findings.to_s,
           fmt::format("{} in {:.0f} % of the pictures {}.", what, 100 * findings.share(),
                       fault == Fault::no_face ? "looked at" : "with a face"),
           std::move(remedy));
  }

  void judge_people() {
    if (clip_.duration_s < kShort_s)
      remark_all(Fault::too_short,
                 clip_.duration_s<kShortest_s, clip_.shots.size()> 1
                     ? fmt::format("Of the clip {:.0f} s serve.", clip_.duration_s)
                     : fmt::format("The clip is {:.0f} s long.", clip_.duration_s),
                 "Film about a minute: turn the head slowly to both sides, up and down, then speak and show "
                 "expressions.");
    if (clip_.fault) remark_all(Fault::incomplete, false, clip_.fault->what, clip_.fault->fix);
    const Findings faceless = find(clip_.looks, any, [](const Look& look) { return !look.face; });
    share_of_faces_ = clip_.looks.empty() ? 0 : 1 - faceless.share();
    remark_looks(Fault::no_face, faceless, kMaxLooks, "No face was found",
                 "Keep the face in the picture and free of hands, hair and sunglasses; film upright, in good "
                 "light, and turn the head no further than to a half profile.");
    const Findings crowd = find(clip_.looks, any, [](const Look& look) { return look.second_face; });
    if (crowd.found > 1 && crowd.share() > 0.03)
      remark(Fault::second_person, crowd.share() > 0.2, crowd.from_s, crowd.to_s,
             fmt::format("A second face of comparable size is in {:.0f} % of the pictures looked at.",
                         100 * crowd.share()),
             "Film one person alone; keep mirrors, posters and screens with faces out of the picture.");
  }

  void judge_pictures() {
    remark_looks(Fault::blurred, find(clip_.looks, has_face, is_blurred), kMaxLooks, "The face is blurred",
                 "Wipe the lens, tap the face on the screen to focus on it, film in brighter light and move "
                 "slowly.");
    remark_looks(Fault::too_dark, find(clip_.looks, has_face, is_dark), kMaxLooks, "The face is too dark",
                 "Face a window or a lamp behind the camera; do not film against the light.");
    remark_looks(Fault::too_bright, find(clip_.looks, has_face, is_burnt), kMaxLooks,
                 "Parts of the face are burnt out",
                 "Move away from the lamp or the sun, or tap the face on the screen so that the camera "
                 "exposes for it.");
    const double width =
        median(values_of(clip_.looks, has_face, [](const Look& l) { return l.face->width; }));
    if (width < kSmallFace)
      remark_all(Fault::small_face, width < kTinyFace,
                 fmt::format("The face is about {:.0f} px wide.", width),
                 "Film from nearer, or at a higher resolution: head and shoulders should fill the picture.");
    remark_looks(Fault::head_cut, find(clip_.looks, has_face, is_cut), kMaxLooks,
                 "The picture's edge cuts the head",
                 "Leave room above and beside the head, even while it turns.");
  }

  void judge_performance() {
    if (find(clip_.looks, has_face, is_posed).share() < kMinPosed) {
      remark_all(Fault::few_angles, false,
                 "Eyes, nose and mouth could not be made out, so the angles and expressions are not known.",
                 "Film in better light, from nearer, and hold the camera still.");
      return;
    }
    const double turn = range_of(clip_.looks, is_posed, yaw_of),
                 nod = range_of(clip_.looks, is_posed, pitch_of);
    if (turn < kFewTurn_deg || nod < kFewNod_deg)
      remark_all(
          Fault::few_angles, false,
          fmt::format("The head is seen from {:.0f} degrees side to side and {:.0f} up and down.", turn, nod),
          "Turn the head slowly to both sides as far as to a half profile, then raise and lower it; or "
          "walk round the resting head.");
    const auto shown = key_expressions_shown(clip_);
    std::string missing;
    for (std::size_t d = 0; d < kKeyExpressions.size(); ++d)
      if (shown[d].range < shown[d].needed)
        missing += (missing.empty() ? "" : ", ") + std::string(shown[d].words);
    if (!missing.empty())
      remark_all(Fault::few_expressions, false,
                 "From this clip the avatar will not learn to: " + missing + ".",
                 "Speak a few sentences, smile with and without teeth, purse the lips, raise the brows and "
                 "blink.");
  }

  // The face's brightness seen from the front, second by second.
  void judge_light() {
    struct Moment {
      double time_s, level;
    };
    std::vector<Moment> moments;
    std::vector<double> second;
    double start = -1;
    const auto close = [&] {
      if (second.size() >= 2) moments.push_back({start, median(second)});
      second.clear();
    };
    for (const Look& look : clip_.looks) {
      if (!look.posed || std::abs(look.yaw_deg) > kFrontal_deg) continue;
      if (start < 0 || look.time_s - start >= 1) close(), start = look.time_s;
      second.push_back(look.level);
    }
    close();
    if (moments.size() < 2) return;
    const auto [low, high] = std::ranges::minmax_element(moments, {}, &Moment::level);
    if (high->level < kLightRatio * std::max(1.0, low->level)) return;
    remark(
        Fault::light_changes, false, std::min(low->time_s, high->time_s),
        std::max(low->time_s, high->time_s) + 1,
        fmt::format("The light on the face changes: it is {:.1f} times as bright at {:.0f} s as at {:.0f} s.",
                    high->level / std::max(1.0, low->level), high->time_s, low->time_s),
        "Lock the camera's exposure, and film where no clouds, screens or passing people change the light.");
  }

  void judge_camera() {
    const CameraMeasures& camera = clip_.camera;
    if (camera.rests) return;
    if (is_shaking(camera.sway))
      remark_all(Fault::camera_shakes, false,
                 fmt::format("The camera shakes: the background moves by {:.0f} % of the picture's width, to "
                             "and fro {:.1f} times a second.",
                             camera.sway.reach / 10, camera.sway.crossings),
                 "Rest the camera on something; or first walk round the resting head, then rest the camera.");
    else if (camera.kind == CameraKind::walking && camera.tracks < kFewTracks)
      remark_all(
          Fault::plain_background, true,
          fmt::format("The camera moves in front of a background with hardly any features ({:.0f} followed).",
                      camera.tracks),
          "Rest the camera on something, or film in front of a background with detail.");
  }

  const ClipMeasures clip_;
  double share_of_faces_ = 0;
  CaptureVerdict out_;
};

}  // namespace

std::string_view fault_name(Fault fault) {
  static constexpr std::array<std::string_view, 14> kNames{
      "no_face",         "second_person", "too_short",     "incomplete",      "blurred",
      "too_dark",        "too_bright",    "small_face",    "head_cut",        "few_angles",
      "few_expressions", "light_changes", "camera_shakes", "plain_background"};
  return kNames[static_cast<std::size_t>(fault)];
}

std::string_view verdict_name(Verdict verdict) {
  static constexpr std::array<std::string_view, 3> kNames{"ready", "usable", "refilm"};
  return kNames[static_cast<std::size_t>(verdict)];
}

std::string_view verdict_words(const CaptureVerdict& verdict) {
  if (verdict.faceless) return "Film again: this clip shows no face, so no avatar can be made of it.";
  static constexpr std::array<std::string_view, 3> kWords{
      "Ready: this clip will make a good avatar.", "Usable, but the avatar will show these faults.",
      "Film again: this clip will not make a good avatar."};
  return kWords[static_cast<std::size_t>(verdict.verdict)];
}

std::array<KeyExpressionShown, kKeyExpressions.size()> key_expressions_shown(const ClipMeasures& measures) {
  std::array<KeyExpressionShown, kKeyExpressions.size()> shown;
  for (std::size_t d = 0; d < kKeyExpressions.size(); ++d) {
    shown[d] = {kKeyExpressionInfo[d].words, 0, kKeyExpressionInfo[d].range};
    const std::vector<double> amounts = values_of(
        measures.looks, [](const Look& look) { return look.posed && look.serves; },
        [&](const Look& look) { return look.expressions[d]; });
    if (amounts.size() < 2) continue;
    // In at least two looks: one may be an error of the fit, and a blink is hardly ever in more.
    const double most = quantile(amounts, 1 - 1.0 / static_cast<double>(amounts.size() - 1));
    shown[d].range = std::max(0.0, most - quantile(amounts, 0.1));
  }
  return shown;
}

bool shows_fault(const Look& look, Fault fault) {
  switch (fault) {
    case Fault::no_face:
      return !look.face;
    case Fault::second_person:
      return look.second_face;
    case Fault::blurred:
      return look.face && is_blurred(look);
    case Fault::too_dark:
      return look.face && is_dark(look);
    case Fault::too_bright:
      return look.face && is_burnt(look);
    case Fault::head_cut:
      return look.face && is_cut(look);
    default:
      return true;
  }
}

CaptureVerdict judge_capture(const ClipMeasures& measures) {
  CaptureVerdict verdict = Judge(measures).judge();
  verdict.faceless =
      1 - find(measures.looks, any, [](const Look& l) { return !l.face; }).share() < kLeastFaceShare;
  if (verdict.faceless) verdict.verdict = Verdict::refilm;
  return verdict;
}

}  // namespace likeness
