// Repeats among a clip's frames: see repeated_frames.h.
#include "core/capture/repeated_frames.h"

#include <algorithm>
#include <cstdlib>

namespace likeness {
namespace {

constexpr int kEvery = 4;          // px along both axes that are compared
constexpr std::size_t kReach = 4;  // frames: a picture is shown four times at most, as 15 a second are in 60
constexpr float kHardly = 0.5f;    // 8-bit units: what a codec changes in a picture that it repeats
constexpr float kShare = 0.2f;     // of the neighbours' differences
constexpr double kFewest = 0.05;   // of the frames

}  // namespace

float DifferenceMeter::add(const Image8& picture) {
  const int channel = picture.channels >= 3 ? 1 : 0;  // most of the luma
  std::vector<std::uint8_t> now;
  for (int y = 0; y < picture.height; y += kEvery)
    for (int x = 0; x < picture.width; x += kEvery) now.push_back(picture.at(x, y)[channel]);
  double sum = 0;
  if (before_.size() == now.size())
    for (std::size_t i = 0; i < now.size(); ++i) sum += std::abs(int(now[i]) - int(before_[i]));
  before_ = std::move(now);
  return before_.empty() ? 0 : float(sum / double(before_.size()));
}

std::vector<char> repeated_frames(const std::vector<float>& differences) {
  const std::size_t count = differences.size();
  std::vector<char> repeats(count, 0);
  for (std::size_t i = 1; i < count; ++i) {
    const float own = differences[i];
    float before = 0, after = 0;  // the largest near it
    for (std::size_t j = i > kReach ? i - kReach : 1; j < i; ++j) before = std::max(before, differences[j]);
    for (std::size_t j = i + 1; j <= i + kReach && j < count; ++j) after = std::max(after, differences[j]);
    // Where the clip begins or ends within reach, one side has to do.
    if (i <= kReach) before = std::max(before, after);
    if (i + kReach >= count) after = std::max(before, after);
    repeats[i] = own <= kHardly && own < kShare * std::min(before, after);
  }
  if (double(std::ranges::count(repeats, 1)) < kFewest * double(count)) repeats.assign(count, 0);
  return repeats;
}

}  // namespace likeness
