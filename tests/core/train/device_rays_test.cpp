// Claims about what a device's threads share in casting a training's rays: tries for a ray's pixel may be
// made in any order (ray_choice.h), and a bent neck's cells looked up beforehand (device_rays.h).
#include "core/train/device_rays.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace likeness {
namespace {

// Views whose pixels meet something by chance, one of four with a mask.
struct MadeUpViews {
  static int width(std::size_t) { return 40; }
  static int height(std::size_t) { return 30; }
  static PixelBox face(std::size_t) { return {10, 5, 25, 20}; }
  static bool has_alpha(std::size_t v) { return v % 2 == 0; }
  static std::uint8_t alpha(std::size_t, int x, int) { return x < 20 ? 0 : 200; }
  static bool masked(std::size_t v) { return v % 4 == 3; }
  static bool teaches(std::size_t v, int x, int y) { return !masked(v) || (x * 7 + y) % 5 == 0; }
  static bool further(std::size_t v) { return v >= 6; }
  static void colour(std::size_t v, int x, int y, float (&out)[3]) {
    out[0] = float(x) / 40, out[1] = float(y) / 30, out[2] = float(v) / 8;
  }
  static bool plate(std::size_t v, int, int, float (&out)[3]) {
    out[0] = out[1] = out[2] = 0.5f;
    return v % 3 == 0;
  }
  static bool meets(std::size_t, int x, int y) { return (x * 31 + y * 17) % 7 == 0; }
};

TEST(RayChoice, ParallelTriesChooseWhatSequentialOnesDo) {
  const ChoiceNumbers numbers{11, 5, 8, 6, 8, 0, 500, 1};
  int late = 0, in_vain = 0;
  for (std::size_t n = 0; n < 500; ++n) {
    MadeUpViews views;
    const ChosenRay right = choose_ray(views, numbers, n);
    const RayDraw draw = begin_choice(views, numbers, n);
    int chosen = -1;
    PixelPlace pixel{0, 0};
    RandomStream random = draw.random;
    for (int attempt = draw.tries - 1; attempt >= 0; --attempt) {  // the last one first
      RandomStream own = draw.random;
      own.skip(std::uint64_t(attempt * kDrawsOfTry));
      PixelPlace place;
      const bool met = try_pixel(views, draw, attempt, own, place);
      if (met || chosen < 0) pixel = place, random = own, chosen = attempt;
    }
    const ChosenRay ray = end_choice(views, numbers, draw.view, pixel, random);
    EXPECT_EQ(ray.view, right.view);
    EXPECT_EQ(ray.jitter, right.jitter);
    EXPECT_EQ(ray.nowhere, right.nowhere);
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(ray.target[c], right.target[c]);
      EXPECT_EQ(ray.background[c], right.background[c]);
    }
    late += chosen > 0, in_vain += right.nowhere;
  }
  EXPECT_GT(late, 100);
  EXPECT_GT(in_vain, 0);
}

TEST(NeckTables, MatchALookUpOfEachCell) {
  constexpr int kCells = 24;
  std::mt19937 random(3);
  std::vector<std::uint8_t> bits(kCells * kCells * kCells / 8), opacity(kCells * kCells * kCells);
  for (std::uint8_t& b : bits) b = std::uint8_t(random());
  for (std::uint8_t& o : opacity) o = std::uint8_t(random());
  MarchGrid grid{1, kCells, {0, 0, 0}, 1, bits.data(), nullptr, opacity.data(), nullptr};
  FrameNumbers frame{};
  frame.neck.bends = 1, frame.neck.base = 0.1f, frame.neck.top = 0.7f;
  for (int k = 0; k <= kBendSteps; ++k) {
    for (int a = 0; a < 3; ++a) frame.neck.turn[k][4 * a] = 1;
    frame.neck.shift[k][0] = 0.004f * float(k);
  }
  const int first[3] = {4, 2, 5}, count[3] = {9, 12, 7};
  for (int a = 0; a < 3; ++a) frame.neck_first[a] = first[a], frame.neck_count[a] = count[a];
  const std::size_t cells = neck_cell_count(frame);
  RayView view{};
  for (const std::size_t room : {cells - 1, cells}) {
    std::vector<std::uint8_t> table(2 * room, 77);
    const RayViews views{&view,
                         nullptr,
                         nullptr,
                         reinterpret_cast<unsigned char*>(&frame),
                         1,
                         table.data(),
                         std::uint32_t(room)};
    for (std::size_t i = 0; i < room; ++i) fill_neck({grid, views}, 0, i);
    if (room < cells) {
      EXPECT_EQ(neck_cells_of(views, 0, frame), nullptr);
      for (const std::uint8_t entry : table) ASSERT_EQ(entry, 77);
      continue;
    }
    std::size_t occupied = 0;
    const MarchScene scene{{grid, {}}, nullptr, nullptr, nullptr, 0, 1, 1e-3f};
    const GridContents looked_up(scene, frame, neck_cells_of(views, 0, frame), 0),
        found(scene, frame, nullptr, 0);
    for (int z = 0; z < count[2]; ++z)
      for (int y = 0; y < count[1]; ++y)
        for (int x = 0; x < count[0]; ++x) {
          const int cell[3] = {first[0] + x, first[1] + y, first[2] + z};
          const CellContent own = looked_up.at(cell), right = found.at(cell);
          ASSERT_EQ(own.occupied, right.occupied);
          ASSERT_EQ(own.core, right.core);
          ASSERT_EQ(own.opacity, right.opacity);
          occupied += own.occupied;
        }
    EXPECT_GT(occupied, cells / 4);
    EXPECT_LT(occupied, cells);
  }
}

}  // namespace
}  // namespace likeness
