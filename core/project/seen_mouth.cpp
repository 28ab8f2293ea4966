// Widths and teeth: see seen_mouth.h.
#include "core/project/seen_mouth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/quantile.h"
#include "core/project/project_views.h"
#include "core/track/fit/face_measures.h"

namespace likeness {
namespace {

constexpr double kRaised = 0.03;      // corners over their height at rest, in eye gaps: a smile's
constexpr double kWider = 1.06;       // than at rest: not by the landmarks' noise alone
constexpr std::size_t kLooked = 12;   // frames whose teeth are looked for
constexpr double kTeethShare = 0.15;  // of the area between the lips, in half of these
constexpr double kBright = 0.65;      // of the skin's brightness
constexpr double kPale = 0.6;         // of the skin's saturation, at most
constexpr int kFewestPixels = 12;     // between the lips

struct MouthSeen {
  int frame = 0;
  FaceMeasures face;
  const TrackedFrame* tracked = nullptr;
};

struct Tone {
  double value = 0, saturation = 0;  // 0..1, of HSV
};

Tone tone_at(const Image8& rgb, int x, int y) {
  const std::uint8_t* p = rgb.at(x, y);
  const int high = std::max({p[0], p[1], p[2]}), low = std::min({p[0], p[1], p[2]});
  return {high / 255.0, high > 0 ? double(high - low) / high : 0};
}

// The skin beside nose and mouth: the middle of a few places.
std::optional<Tone> skin_tone(const Image8& rgb, const std::array<Vec2d, kLandmarkCount>& p) {
  std::vector<double> values, saturations;
  for (const auto& [a, b] : {std::pair{31, 48}, {35, 54}, {48, 4}, {54, 12}, {33, 51}, {57, 8}, {30, 29}}) {
    const Vec2d at = 0.5 * (p[a] + p[b]);
    const int x = int(std::floor(at.x())), y = int(std::floor(at.y()));
    if (x < 0 || y < 0 || x >= rgb.width || y >= rgb.height) continue;
    const Tone tone = tone_at(rgb, x, y);
    values.push_back(tone.value), saturations.push_back(tone.saturation);
  }
  if (values.size() < 3) return std::nullopt;
  return Tone{median(values), median(saturations)};
}

// Whether the point lies in the polygon of the inner lips' edge, by crossings.
bool between_lips(const std::array<Vec2d, kLandmarkCount>& p, const Vec2d& at) {
  bool inside = false;
  for (int i = 60, j = kLandmarkCount - 1; i < kLandmarkCount; j = i++)
    if ((p[i].y() > at.y()) != (p[j].y() > at.y()) &&
        at.x() < (p[j].x() - p[i].x()) * (at.y() - p[i].y()) / (p[j].y() - p[i].y()) + p[i].x())
      inside = !inside;
  return inside;
}

// The training frames' mouths, in the order of the capture.
std::vector<MouthSeen> mouths(const Capture& capture, const CameraSet& cameras, const Track& track,
                              const ReducedHead& head, const ReducedPerson& person) {
  std::vector<MouthSeen> seen;
  for (const CaptureFrame& frame : capture.frames) {
    if (!frame.used) continue;
    const TrackedFrame* tracked = find_tracked(track, frame.frame);
    const Camera* camera = find_camera(cameras, frame.frame);
    if (!tracked || !camera || tracked->status == FrameStatus::lost || tracked->landmarks[48].isZero())
      continue;
    Pose cam_from_world = camera->cam_from_world;
    cam_from_world.translation() *= track.metres_per_unit;
    std::array<Vec2d, kLandmarkCount> rays;
    std::array<double, kLandmarkCount> sigma{};
    for (int k = 0; k < kLandmarkCount; ++k)
      rays[k] = ray_direction(camera->intrinsics, tracked->landmarks[k]).head<2>();
    seen.push_back({frame.frame,
                    measure_face(head, person, rays, sigma, cam_from_world * tracked->pose.world_from_head),
                    tracked});
  }
  return seen;
}

// The mouth at rest: that of the frames the rest was read from, or as the neutral has it.
FaceMeasures at_rest(const std::vector<MouthSeen>& seen, const Track& track, const ReducedHead& head,
                     const ReducedPerson& person) {
  std::vector<double> widths, lifts;
  for (const MouthSeen& m : seen)
    if (std::ranges::binary_search(track.rest.frames, m.frame))
      widths.push_back(m.face.mouth_width), lifts.push_back(m.face.corner_lift);
  FaceMeasures rest =
      measure_state(head, person, track.neutral.expression.cast<double>(), double(track.neutral.jaw.x()));
  if (!widths.empty()) rest.mouth_width = median(widths), rest.corner_lift = median(lifts);
  return rest;
}

// By what a full smile of both sides widens this person's mouth at rest.
double full_smile(const HeadModel& model, const Track& track, const ReducedHead& head,
                  const ReducedPerson& person) {
  Articulation smile = track.neutral;
  for (const char* side : {"mouthSmile_L", "mouthSmile_R"})
    if (const NamedAction* action = find_action(model, side)) add_action(smile, *action, 1);
  const auto width = [&](const Articulation& a) {
    return measure_state(head, person, a.expression.cast<double>(), double(a.jaw.x())).mouth_width;
  };
  return width(smile) / std::max(1e-6, width(track.neutral));
}

}  // namespace

double teeth_share(const Image8& rgb, const std::array<Vec2d, kLandmarkCount>& landmarks) {
  const auto skin = skin_tone(rgb, landmarks);
  if (!skin) return 0;
  Vec2d low = landmarks[60], high = landmarks[60];
  for (int k = 60; k < kLandmarkCount; ++k)
    low = low.cwiseMin(landmarks[k]), high = high.cwiseMax(landmarks[k]);
  int pixels = 0, teeth = 0;
  for (int y = std::max(0, int(low.y())); y < std::min<double>(rgb.height, high.y() + 1); ++y)
    for (int x = std::max(0, int(low.x())); x < std::min<double>(rgb.width, high.x() + 1); ++x) {
      if (!between_lips(landmarks, Vec2d(x + 0.5, y + 0.5))) continue;
      const Tone tone = tone_at(rgb, x, y);
      ++pixels;
      teeth += tone.value >= kBright * skin->value && tone.saturation <= kPale * skin->saturation;
    }
  return pixels >= kFewestPixels ? double(teeth) / pixels : 0;
}

SeenMouth seen_mouth(const Capture& capture, const CameraSet& cameras, const Track& track,
                     const HeadModel& model, const FramePictures& pictures) {
  SeenMouth result;
  if (track.neutral.expression.size() != model.expression_count()) return result;
  const ReducedHead head = reduce_head(model, model.identity_count(), track.person);
  const ReducedPerson person = reduced_person(head, track.person.identity.cast<double>());
  std::vector<MouthSeen> smiles = mouths(capture, cameras, track, head, person);
  const FaceMeasures rest = at_rest(smiles, track, head, person);
  const std::size_t all = smiles.size();
  std::erase_if(smiles, [&](const MouthSeen& m) { return m.face.corner_lift < rest.corner_lift + kRaised; });
  if (smiles.empty() || rest.mouth_width <= 0) return result;
  std::ranges::sort(smiles, std::ranges::greater(), [](const MouthSeen& m) { return m.face.mouth_width; });
  const double widest = smiles[std::min(smiles.size() - 1, all / 50)].face.mouth_width / rest.mouth_width;
  if (widest < kWider) return result;
  result.widest = widest;
  if (const double full = full_smile(model, track, head, person); full > 1)
    result.smile = std::clamp((widest - 1) / (full - 1), 0.0, 1.0);
  const double scale = capture.crop.side > 0 ? double(capture.size) / capture.crop.side : 1;
  std::size_t looked = 0, toothy = 0;
  for (const MouthSeen& m : smiles) {
    if (looked >= kLooked || m.face.mouth_width < kWider * rest.mouth_width) break;
    const auto picture = pictures(m.frame);
    if (!picture || picture->channels != 3) continue;
    std::array<Vec2d, kLandmarkCount> points = m.tracked->landmarks;
    for (Vec2d& p : points) p = scale * (p - Vec2d(capture.crop.x, capture.crop.y));
    ++looked;
    toothy += teeth_share(*picture, points) >= kTeethShare;
  }
  result.teeth = looked > 0 && 2 * toothy >= looked;
  return result;
}

SeenMouth seen_mouth(const std::filesystem::path& folder, const Capture& capture, const CameraSet& cameras,
                     const Track& track, const HeadModel& model) {
  return seen_mouth(capture, cameras, track, model, [&](int frame) -> std::optional<Image8> {
    auto read = read_own_picture(folder / "frames", fmt::format("{:06}.png", frame), capture.size, 3);
    return read ? std::optional(std::move(*read)) : std::nullopt;
  });
}

}  // namespace likeness
