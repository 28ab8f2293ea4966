// Claims about fitting a torso's modes to all frames at once.
#include "core/track/torso/torso_refine.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/track/torso/torso_rows.h"
#include "tests/core/track/torso/torso_board.h"

namespace likeness {
namespace {

TorsoGrid grid_of(const TorsoTemplate& body) {
  Vec2d low = Vec2d::Constant(1e9), high = -low;
  for (const TorsoPixel& t : body.levels[0])
    low = low.cwiseMin(t.place.head<2>()), high = high.cwiseMax(t.place.head<2>());
  constexpr float kCell = 0.04f;
  const Vec2d extent = (high - low) / double(kCell);
  return {low.cast<float>(), kCell, int(std::ceil(extent.x())) + 1, int(std::ceil(extent.y())) + 1};
}

// 30 frames of the sagging board. The one mode that moves anything lowers one half of the board evenly, as
// the true one does not, by coefficients a third as large; the other modes are zero.
struct Fixture {
  BoardClip clip = sagging_clip();
  TorsoTemplate body = make_torso_template(clip.frames[0], kChin);
  std::vector<std::vector<GreyLevel>> pictures;
  std::vector<TorsoView> views;
  std::vector<TorsoState> states = std::vector<TorsoState>(30);
  std::vector<TorsoState*> pointers;
  TorsoModes modes;

  Fixture() {
    for (std::size_t i = 0; i < 30; ++i) pictures.push_back(relief_pyramid(clip.images[i]));
    for (std::size_t i = 0; i < 30; ++i) {
      views.push_back({&pictures[i][0], &clip.frames[i], clip.frames[0].world_from_head});
      states[i].shape[0] = float(sag_of(int(i)) - sag_of(0)) * 0.3f;
      pointers.push_back(&states[i]);
    }
    modes.grid = grid_of(body);
    const std::size_t size = 2 * std::size_t(modes.grid.nodes());
    modes.mean.assign(size, 0.f);
    for (auto& mode : modes.modes) mode.assign(size, 0.f);
    for (int node = 0; node < modes.grid.nodes(); ++node) {
      const float x = modes.grid.origin.x() + modes.grid.cell * float(node % modes.grid.columns);
      modes.modes[0][2 * std::size_t(node) + 1] = x > 0 ? -0.003f : 0.f;
    }
  }
  TorsoRefinement refine(int steps) {
    return refine_torso_modes(body.levels[0], views, body.pivot, steps, {}, pointers, &modes);
  }
  // Of a canonical point that the first frame shows at x on the board, world.
  Vec3d place(std::size_t frame, double x) const {
    const Vec3d canonical = inverse(clip.frames[0].world_from_head) * Vec3d(x, 0.1, kDepth);
    const TorsoState& state = states[frame];
    return views[frame].reference *
           (motion_pose(state.motion, body.pivot) * displaced(modes.grid, state.displacement, canonical));
  }
};

TEST(TorsoRow, DerivativesAgreeWithFiniteDifferences) {
  Fixture f;
  TorsoState state;
  state.motion = {0.02, {0.003, -0.002}};
  state.displacement.assign(2 * std::size_t(f.modes.grid.nodes()), 0.0007f);
  const auto row = [&](const TorsoPixel& pixel, const TorsoState& at, TorsoRow* made) {
    return torso_row(pixel, f.views[9], motion_pose(at.motion, f.body.pivot), f.body.pivot, f.modes.grid, at,
                     made);
  };
  int checked = 0;
  for (std::size_t p = 50; p < f.body.levels[0].size(); p += 97) {
    const TorsoPixel& pixel = f.body.levels[0][p];
    TorsoRow here;
    if (!row(pixel, state, &here)) continue;
    // Bilinear pictures have a kink at pixel centres; steps across one are passed over.
    const auto compare = [&](auto change, double h, double derivative) {
      TorsoState less = state, more = state;
      change(less, -h), change(more, h);
      TorsoRow low, high;
      if (!row(pixel, less, &low) || !row(pixel, more, &high)) return;
      const double left = (here.residual - low.residual) / h, right = (high.residual - here.residual) / h;
      if (std::abs(left - right) > 0.02 * (std::abs(left) + std::abs(right)) + 1) return;
      EXPECT_NEAR((left + right) / 2, derivative, 0.02 * std::abs(derivative) + 1);
      ++checked;
    };
    compare([](TorsoState& s, double h) { s.motion.angle += h; }, 1e-4, here.by[0]);
    compare([](TorsoState& s, double h) { s.motion.shift.x() += h; }, 1e-5, here.by[1]);
    compare([](TorsoState& s, double h) { s.motion.shift.y() += h; }, 1e-5, here.by[2]);
    for (const int k : {0, 3, 6})
      compare([&](TorsoState& s, double h) { s.displacement[std::size_t(here.node_index(k))] += float(h); },
              1e-5, here.by_node(k));
  }
  EXPECT_GT(checked, 100);
}

TEST(TorsoRefine, LearnsTheTrueSagFromAModeOfTheWrongShape) {
  Fixture f;
  const TorsoRefinement report = f.refine(12);
  EXPECT_GT(report.steps, 2);
  EXPECT_LT(report.cost_after, 0.2 * report.cost_before);
  for (const double x : {-0.1, 0.03, 0.12})
    for (const std::size_t i : {std::size_t(7), std::size_t(16), std::size_t(25)}) {
      const Vec3d moved = f.place(i, x) - f.place(2, x);
      EXPECT_NEAR(moved.x(), shift_of(int(i)) - shift_of(2), 4e-4) << "frame " << i << " at " << x;
      EXPECT_NEAR(moved.y(), (sag_of(int(i)) - sag_of(2)) * sunk(x), 6e-4) << "frame " << i << " at " << x;
    }
}

TEST(TorsoRefine, EveryStepLowersTheCost) {
  Fixture f;
  double first = 0, last = 1e300;
  for (int i = 0; i < 5; ++i) {
    const TorsoRefinement report = f.refine(1);
    ASSERT_EQ(report.steps, 1);
    EXPECT_LT(report.cost_after, report.cost_before);
    EXPECT_LT(report.cost_before, 1.01 * last);  // what is seen changes a little between calls
    if (i == 0) first = report.cost_before;
    last = report.cost_after;
  }
  EXPECT_LT(last, 0.3 * first);
}

TEST(TorsoRefine, ThreadsDoNotChangeTheBits) {
  Fixture one, all;
  {
    const ThreadLimit limit(1);
    one.refine(3);
  }
  all.refine(3);
  EXPECT_EQ(one.modes.mean, all.modes.mean);
  EXPECT_EQ(one.modes.modes, all.modes.modes);
  for (std::size_t i = 0; i < 30; ++i) EXPECT_EQ(one.states[i].shape, all.states[i].shape);
}

TEST(TorsoRefine, AViewThatShowsNoTorsoIsLeftAlone) {
  Fixture f;
  f.views[4].reference.translation().x() += 3;  // beside the picture
  const TorsoState before = f.states[4];
  EXPECT_GT(f.refine(3).steps, 0);
  EXPECT_EQ(f.states[4].motion.angle, before.motion.angle);
  EXPECT_EQ(f.states[4].motion.shift, before.motion.shift);
  EXPECT_EQ(f.states[4].shape, before.shape);
  EXPECT_EQ(f.states[4].displacement, before.displacement);
}

}  // namespace
}  // namespace likeness
