// Damaged files of dlib's shape predictor, read and then used.
#include <gtest/gtest.h>

#include "core/face/landmarks.h"
#include "tests/core/face/tiny_predictor.h"
#include "tests/fuzz/fuzz.h"

namespace likeness {
namespace {

TEST(FuzzLandmarkModel, LandmarkModel) {
  const ScratchFolder scratch;
  FuzzTarget target;
  target.name = "landmark model";
  target.seeds = {tiny_predictor(2)};
  Image8 picture(32, 32, 1);
  for (std::size_t i = 0; i < picture.data.size(); ++i) picture.data[i] = std::uint8_t(31 * i);
  target.read = [&](std::span<const std::byte> bytes) {
    const auto detector = FaceDetector::load(scratch.put("model.dat", bytes));
    if (!detector) return false;
    const Landmarks found = detector->landmarks(picture, {8, 8, 16, 16}, 0, nullptr, {1, 1});
    for (const Vec2d& p : found.points) EXPECT_TRUE(p.allFinite());
    return true;
  };
  fuzz(target);
}

}  // namespace
}  // namespace likeness
