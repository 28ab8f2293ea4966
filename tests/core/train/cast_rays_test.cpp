// Claims about core/train/cast_rays.h: rays cast on a device match the processor's in choice and samples; so
// do cell look-ups; a step takes no ray from the host and waits once. The same claims are made of the
// emulated device and, labelled gpu, of a CUDA one.
#include "core/train/cast_rays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/field/device_field.h"
#include "core/train/cell_math.h"
#include "tests/core/device/emulated_device.h"
#include "tests/core/field/relative_l2.h"
#include "tests/core/train/cast_scene.h"

namespace likeness {
namespace {

using testing::HasSubstr;

// What a step's kernels left in the device's batch.
struct CastBatch {
  std::vector<std::uint32_t> begin, slot;
  std::vector<float> dt;
  std::vector<std::uint8_t> field;
  std::vector<Vec3f> target, background;
  std::array<std::array<std::vector<float>, 6>, 2> point;
  std::array<std::vector<std::int32_t>, 2> row;

  explicit CastBatch(const DeviceBatch& batch) {
    const auto read = [&]<class T>(std::vector<T>& to, const T* from, std::size_t count) {
      to.resize(count);
      EXPECT_TRUE(batch.device->copy_out(to.data(), const_cast<T*>(from), count * sizeof(T)).ok());
      EXPECT_TRUE(batch.device->wait().ok());
    };
    const auto rays = std::size_t(CastScene::kRays);
    read(begin, batch.begin, rays + 1);
    const std::size_t all = begin.back();
    read(slot, batch.slot, all), read(dt, batch.dt, all), read(field, batch.of_field, all);
    read(target, reinterpret_cast<const Vec3f*>(batch.target), rays);
    read(background, reinterpret_cast<const Vec3f*>(batch.background), rays);
    for (std::size_t f = 0; f < 2; ++f) {
      std::vector<std::uint32_t> count;
      read(count, batch.fields[f]->count(), 1);
      for (int k = 0; k < 6; ++k) read(point[f][std::size_t(k)], batch.fields[f]->point(k), count[0]);
      read(row[f], batch.fields[f]->rows(), count[0]);
    }
  }
};

struct Trained {
  CastScene scene;
  std::unique_ptr<FieldLearner> learner;
  std::unique_ptr<RayCaster> caster;

  void learn_on(Backend& backend) {
    auto made = make_learner(backend, scene.state, scene.options, scene.set);
    EXPECT_TRUE(made.ok()) << made.error().what;
    learner = std::move(*made);
  }
  void cast_there() {
    auto chosen = make_ray_caster(*learner, scene.state, scene.source, scene.options);
    caster = std::move(chosen.caster);
    EXPECT_NE(caster, nullptr) << chosen.why_not;
  }
  StepResult step() {
    auto result = training_step(scene.state, *learner, scene.source, scene.options, caster.get());
    EXPECT_TRUE(result.ok()) << result.error().what;
    return result ? *result : StepResult{};
  }
};

class CastRaysTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    device_ = tested_device(why);
    if (!device_) GTEST_SKIP() << why;
  }
  void start(Trained& there, Trained& here) {
    there.learn_on(*device_backend(device_, false)), there.cast_there();
    here.learn_on(*cpu_backend(FieldPrecision::exact));
  }
  std::shared_ptr<Device> device_;
};

// The rays of a step, which moves nothing, here and there.
void expect_the_same_rays(Trained& there, Trained& here) {
  TrainingState& state = here.scene.state;
  cast_rays(state, here.scene.source, here.scene.options);
  LearningStep step{{}, {}, {}, there.scene.state.conditions, CastScene::kViews};
  step.cast = there.caster.get(), step.cast_rays = CastScene::kRays;
  ASSERT_TRUE(there.caster->set_step(state.step).ok());
  const auto learnt = there.learner->step(step);
  ASSERT_TRUE(learnt.ok()) << learnt.error().what;
  EXPECT_TRUE(std::isfinite(learnt->loss));
  const CastBatch got(*there.learner->device_batch());
  const SampleBatch& truth = state.samples;

  // At the edge of a cell rounding decides: of a CUDA device's samples a few may be others.
  const auto rays = std::size_t(CastScene::kRays);
  std::size_t other_pixels = 0, other_counts = 0, samples = 0, apart = 0, other_rows = 0;
  for (std::size_t r = 0; r < rays; ++r) {
    const bool same_pixel = (got.target[r] - state.rays.target[r]).norm() < 1e-5f &&
                            (got.background[r] - state.rays.background[r]).norm() < 1e-5f;
    const std::uint32_t count = truth.begin[r + 1] - truth.begin[r];
    other_pixels += !same_pixel;
    if (got.begin[r + 1] - got.begin[r] != count || !same_pixel) {
      ++other_counts;
      continue;
    }
    for (std::uint32_t k = 0; k < count; ++k, ++samples) {
      const std::size_t i = truth.begin[r] + k, j = got.begin[r] + k;
      const std::size_t f = truth.field[i], a = truth.slot[i], b = got.slot[j];
      const FieldSamples& s = truth.fields[f];
      const float* const axes[6] = {s.x.data(),  s.y.data(),  s.z.data(),
                                    s.dx.data(), s.dy.data(), s.dz.data()};
      float off = std::abs(got.dt[j] - truth.dt[i]) + (got.field[j] == f ? 0.f : 1.f);
      for (std::size_t c = 0; c < 6 && got.field[j] == f; ++c)
        off = std::max(off, std::abs(got.point[f][c][b] - axes[c][a]));
      apart += off > 1e-4f;
      other_rows += got.field[j] == f && got.row[f][b] != s.view[a];
    }
  }
  EXPECT_GT(samples, 3000u);
  EXPECT_GT(truth.fields[0].count(), 1500u);
  EXPECT_GT(truth.fields[1].count(), 500u);
  EXPECT_LE(other_pixels, rays / 200);
  EXPECT_LE(other_counts, rays / 100);
  EXPECT_LE(apart, samples / 200);
  // Random numbers go by a sample's place in the batch: behind another count others are drawn.
  if (other_counts == 0) {
    EXPECT_LE(other_rows, samples / 500);
  }
  for (std::size_t f = 0; f < 2; ++f) {
    const auto own = double(truth.fields[f].count());
    EXPECT_NEAR(double(learnt->samples[f]), own, 0.005 * own);
  }
}

TEST_F(CastRaysTest, RaysMatchTheProcessor) {
  Trained there, here;
  start(there, here);
  for (const std::uint64_t step : {0, 7}) {
    here.scene.state.step = step;
    expect_the_same_rays(there, here);
  }
}

TEST_F(CastRaysTest, CoverEveryKindOfView) {
  // The test above would not notice what no ray met.
  Trained there, here;
  start(there, here);
  cast_rays(here.scene.state, here.scene.source, here.scene.options);
  std::array<int, 2 * CastScene::kViews> rays{};
  int nowhere = 0;
  for (const RayRequest& ray : here.scene.state.rays.requests) {
    ++rays[std::size_t(ray.view)];
    const bool head = ray.fields[0].origin.x() != 3, torso = ray.fields[1].origin.x() != 3;
    nowhere += !head && !torso;
    const std::size_t view = std::size_t(ray.view) % CastScene::kViews;
    if (view + 2 >= CastScene::kViews && (head || torso)) {
      EXPECT_EQ(torso, view + 1 == CastScene::kViews) << "each proxy shows its part alone";
      EXPECT_NE(head, torso);
    }
  }
  for (std::size_t v = 0; v < 2 * CastScene::kViews; ++v) {
    // Own views with and without their code, a further clip's with it, proxies without one.
    const std::size_t view = v % CastScene::kViews;
    const bool with_code = v < CastScene::kViews, own = view < CastScene::kOwn,
               proxy = view >= CastScene::kOwn + CastScene::kFurther;
    EXPECT_EQ(rays[v] > 10, own || with_code != proxy) << v << " " << rays[v];
  }
  EXPECT_GT(nowhere, 0);
  EXPECT_LT(nowhere, 300);
}

TEST_F(CastRaysTest, FollowsChangedPoses) {
  Trained there, here;
  start(there, here);
  expect_the_same_rays(there, here);
  for (CastScene* scene : {&there.scene, &here.scene}) {
    scene->place_poses(2);  // tables of other sizes
    scene->source.drawn = CastScene::kOwn;
  }
  ASSERT_TRUE(there.caster->place_views(there.scene.source).ok());
  here.scene.state.step = 3;
  expect_the_same_rays(there, here);
}

TEST_F(CastRaysTest, CellLookUpsMatchTheProcessor) {
  Trained there, here;
  start(there, here);
  TrainingState &own = there.scene.state, &truth = here.scene.state;
  for (const std::uint64_t step : {128, 160}) {
    truth.step = step;
    ASSERT_TRUE(refresh_fields(truth, *here.learner, here.scene.source, here.scene.options.seed).ok());
    // Conditions come with a step.
    LearningStep nothing{{}, {}, {}, own.conditions, CastScene::kViews};
    nothing.cast = there.caster.get(), nothing.cast_rays = CastScene::kRays;
    ASSERT_TRUE(there.caster->set_step(step).ok());
    ASSERT_TRUE(there.learner->step(nothing).ok());
    ASSERT_TRUE(there.caster->refresh(step).ok());
    ASSERT_TRUE(there.caster->fetch_cells(own).ok());
    for (int f = 0; f < 2; ++f) {
      const TrainedField &a = f == 0 ? own.head : *own.torso, &b = f == 0 ? truth.head : *truth.torso;
      std::size_t moved = 0;
      for (std::size_t i = 0; i < b.learnt.density.size(); ++i) moved += b.learnt.density[i] > kCellThreshold;
      EXPECT_GT(moved, b.learnt.density.size() / 20) << f;
      EXPECT_TRUE(f == 1 || moved < b.learnt.density.size());
      EXPECT_LE(relative_l2(a.learnt.density, b.learnt.density), 1e-3) << f;
      std::size_t bits = 0, opacities = 0;
      for (std::size_t i = 0; i < b.part.occupancy.bits.size(); ++i)
        bits += a.part.occupancy.bits[i] != b.part.occupancy.bits[i];
      for (std::size_t i = 0; i < b.part.opacity.size(); ++i)
        opacities += std::abs(int(a.part.opacity[i]) - int(b.part.opacity[i])) > 1;
      EXPECT_LE(bits, b.part.occupancy.bits.size() / 200) << f;
      EXPECT_LE(opacities, b.part.opacity.size() / 200) << f;
    }
    // The grids on the device, bricks and the boxes of the necks among them, are those that came back.
    expect_the_same_rays(there, here);
  }
}

TEST_F(CastRaysTest, StepsMatchTheProcessor) {
  Trained there, here;
  start(there, here);
  for (int k = 0; k < 6; ++k) {
    const StepResult one = here.step(), other = there.step();
    EXPECT_NEAR(other.loss, one.loss, 0.01 * one.loss) << k;
    EXPECT_NEAR(double(other.samples), double(one.samples), 0.005 * double(one.samples)) << k;
  }
  ASSERT_TRUE(there.learner->fetch().ok());
  for (int f = 0; f < 2; ++f) {
    const TrainedField &a = f == 0 ? there.scene.state.head : *there.scene.state.torso,
                       &b = f == 0 ? here.scene.state.head : *here.scene.state.torso;
    EXPECT_EQ(a.adam.step, b.adam.step);
    EXPECT_LE(relative_l2(a.adam.first, b.adam.first), 0.1) << f;
  }
}

// -- What only the emulated device shows

TEST(EmulatedCasting, StepWaitsOnceAndAllocatesNothing) {
  Trained there;
  const auto device = emulated_device();
  there.learn_on(*device_backend(device, false)), there.cast_there();
  there.step();
  const EmulatedCounts before = emulated_counts();
  for (int k = 0; k < 3; ++k) there.step();
  const EmulatedCounts after = emulated_counts();
  EXPECT_EQ(after.waits - before.waits, 3u);
  EXPECT_EQ(after.replays - before.replays, 3u);
  EXPECT_EQ(after.bytes, before.bytes);
  EXPECT_EQ(after.waits_while_recording, 0u);
  // Conditions and numbers go in; no ray does.
  EXPECT_LE(after.bytes_in - before.bytes_in,
            3 * (sizeof(float) * there.scene.state.conditions.size() + 128));
  ASSERT_TRUE(there.caster->refresh(4).ok());
  EXPECT_EQ(emulated_counts().waits, after.waits);
}

TEST(EmulatedCasting, PicturesTooLargeForTheDeviceLeaveTheRaysToTheProcessor) {
  const std::size_t free = std::size_t{64} << 20;
  Trained there, here;
  there.learn_on(*device_backend(emulated_device({.memory_bytes = free}), false));
  here.learn_on(*cpu_backend(FieldPrecision::exact));
  for (int k = 0; k < 3; ++k) there.scene.set.views[std::size_t(k)].rgb = Image8(1900, 1900, 3, 9);
  EXPECT_GT(picture_bytes(there.scene.set), free / 2);
  const auto chosen =
      make_ray_caster(*there.learner, there.scene.state, there.scene.source, there.scene.options);
  EXPECT_EQ(chosen.caster, nullptr);
  EXPECT_THAT(chosen.why_not, HasSubstr("GiB"));
  EXPECT_THAT(chosen.why_not, HasSubstr("processor casts"));
  there.scene.set.views = {};
  for (const TrainingView& view : here.scene.set.views) there.scene.set.views.push_back(view);
  const StepResult one = here.step(), other = there.step();
  EXPECT_NEAR(other.loss, one.loss, 1e-5 * one.loss);
  EXPECT_EQ(other.samples, one.samples);
}

TEST(EmulatedCasting, PatchesAndTheProcessorBackendUseNoRayCaster) {
  Trained there, here;
  there.learn_on(*device_backend(emulated_device(), false));
  here.learn_on(*cpu_backend(FieldPrecision::exact));
  const LandmarkPatches patches;
  there.scene.source.patches = &patches;
  const auto with_patches =
      make_ray_caster(*there.learner, there.scene.state, there.scene.source, there.scene.options);
  EXPECT_EQ(with_patches.caster, nullptr);
  EXPECT_THAT(with_patches.why_not, HasSubstr("landmark loss"));
  const auto processor =
      make_ray_caster(*here.learner, here.scene.state, here.scene.source, here.scene.options);
  EXPECT_EQ(processor.caster, nullptr);
  EXPECT_EQ(processor.why_not, "");
}

TEST(EmulatedCasting, FullDeviceStillTrains) {
  Trained there, here;
  there.learn_on(*device_backend(emulated_device(), false));
  here.learn_on(*cpu_backend(FieldPrecision::exact));
  const std::size_t taken = emulated_counts().bytes;
  there.learner.reset();
  there.learn_on(*device_backend(emulated_device({.memory_bytes = taken + 200000}), false));
  const auto chosen =
      make_ray_caster(*there.learner, there.scene.state, there.scene.source, there.scene.options);
  EXPECT_EQ(chosen.caster, nullptr);
  EXPECT_THAT(chosen.why_not, HasSubstr("out of memory"));
  EXPECT_EQ(emulated_counts().bytes, taken);
  const StepResult one = here.step(), other = there.step();
  EXPECT_NEAR(other.loss, one.loss, 1e-5 * one.loss);
}

}  // namespace
}  // namespace likeness
