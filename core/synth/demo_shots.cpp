// Cuts at about even distances, of each kind in turn.
#include "core/synth/demo_shots.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/synth/noise.h"

namespace likeness {
namespace {

constexpr int kAngles = 3;  // places of the camera
constexpr double kLeastDropped_s = 0.7, kMostDropped_s = 1.6;

// What the next cut does; each kind in turn. Where the picture is close already, it goes back instead.
CutKind next_cut(int turn, const DemoShot& before) {
  switch (turn % 3) {
    case 0:
      return CutKind::jump;
    case 1:
      return before.close ? CutKind::punch_out : CutKind::punch_in;
    default:
      return CutKind::angle;
  }
}

}  // namespace

const char* cut_name(CutKind kind) {
  switch (kind) {
    case CutKind::opening:
      return "opening";
    case CutKind::jump:
      return "jump";
    case CutKind::punch_in:
      return "punch-in";
    case CutKind::punch_out:
      return "punch-out";
    case CutKind::angle:
      return "angle";
  }
  return "";
}

std::vector<DemoShot> demo_shots(const DemoOptions& options) {
  LIKENESS_CHECK(options.cuts >= 0 && options.cuts < std::max(1, options.frames), "%d cuts in %d frames",
                 options.cuts, options.frames);
  RandomStream random{hash_u32(std::uint32_t(options.seed) + 9001)};
  const int count = options.cuts + 1, turn = options.seed % 3;
  const double length = double(options.frames) / count;
  std::vector<DemoShot> shots(1);
  for (int i = 1; i < count; ++i) {
    DemoShot shot = shots.back();
    const double jitter = 0.3 * (double(random.unit()) - 0.5);
    const double seconds = random.between(float(kLeastDropped_s), float(kMostDropped_s));
    shot.first = std::clamp(int(std::lround(length * (i + jitter))), shots.back().first + 1,
                            options.frames - (count - i));
    shot.dropped += std::max(1, int(std::lround(seconds * options.frames_per_second)));
    shot.kind = next_cut(i - 1 + std::abs(turn), shots.back());
    if (shot.kind == CutKind::punch_in) shot.close = true;
    if (shot.kind == CutKind::punch_out) shot.close = false;
    if (shot.kind == CutKind::angle) shot.place = (shot.place + 1) % kAngles, shot.close = false;
    shot.camera = 2 * shot.place + int(shot.close);
    shots.back().last = shot.first - 1;
    shots.push_back(shot);
  }
  shots.back().last = options.frames - 1;
  return shots;
}

const DemoShot& shot_of(const std::vector<DemoShot>& shots, int frame) {
  const auto after = std::upper_bound(shots.begin(), shots.end(), frame,
                                      [](int f, const DemoShot& shot) { return f < shot.first; });
  return after == shots.begin() ? shots.front() : *(after - 1);
}

DemoOptions uncut(const DemoOptions& options, const std::vector<DemoShot>& shots) {
  DemoOptions whole = options;
  whole.frames += shots.back().dropped;
  whole.cuts = 0;
  return whole;
}

}  // namespace likeness
