// Claims about FrameRenderer in core/render/backend.h: a device's samples and pictures match the processor's,
// it keeps its buffers from frame to frame, and fails cleanly. The same claims are made of the emulated
// device and, labelled gpu, of a CUDA one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rigid.h"
#include "core/field/device_field.h"
#include "core/render/backend.h"
#include "core/render/canonical_samples.h"
#include "core/render/device_frame.h"
#include "core/render/device_picture.h"
#include "core/render/pose_avatar.h"
#include "tests/core/device/emulated_device.h"
#include "tests/core/render/posed_tiny_avatar.h"

namespace likeness {
namespace {

using testing::HasSubstr;

struct Difference {
  double mean = 0, share_over = 0;  // absolute, over all channels; of pixels that differ by a hundredth
};

Difference difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.data.size(), b.data.size());
  Difference d;
  for (std::size_t i = 0; i < a.data.size(); i += 4) {
    float worst = 0;
    for (std::size_t c = i; c < i + 4; ++c) {
      EXPECT_TRUE(std::isfinite(b.data[c])) << c;
      d.mean += double(std::abs(a.data[c] - b.data[c]));
      worst = std::max(worst, std::abs(a.data[c] - b.data[c]));
    }
    d.share_over += worst > 0.01f;
  }
  d.mean /= double(a.data.size()), d.share_over /= double(a.pixels());
  return d;
}

class FrameRendererTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    device_ = tested_device(why);
    if (!device_) GTEST_SKIP() << why;
  }
  static Image picture(FrameRenderer& renderer, const Avatar& avatar, const RenderState& state,
                       const RenderOptions& options) {
    auto frame = renderer.render(typical_camera(avatar), state, options);
    EXPECT_TRUE(frame.ok()) << frame.error().what;
    return frame ? frame->rgba : Image();
  }
  std::unique_ptr<FrameRenderer> renderer(const Avatar& avatar, bool halves = false) const {
    auto made = device_backend(device_, halves)->make_renderer(avatar);
    EXPECT_TRUE(made.ok()) << made.error().what;
    return std::move(*made);
  }
  std::shared_ptr<Device> device_;
};

RenderOptions with_strata(int strata, int block) {
  RenderOptions options;
  options.strata = strata, options.block = block, options.max_samples = 14;
  return options;
}

TEST_F(FrameRendererTest, PicturesMatchTheProcessor) {
  const Avatar avatar = posable_avatar();
  const auto on_device = renderer(avatar);
  const RenderState state = posed_state(avatar, 0);
  for (const RenderOptions& options :
       {with_strata(0, 1), with_strata(8, 1), with_strata(8, 2), with_strata(5, 3), RenderOptions{}}) {
    const RenderedFrame here = render_frame(avatar, typical_camera(avatar), state, options);
    const auto there = on_device->render(typical_camera(avatar), state, options);
    ASSERT_TRUE(there.ok()) << there.error().what;
    double light = 0;
    for (const float v : here.rgba.data) light += double(v);
    EXPECT_GT(light, 0.05 * double(here.rgba.data.size()));
    const Difference d = difference(here.rgba, there->rgba);
    EXPECT_LT(d.mean, 2e-5) << options.strata << " " << options.block;
    EXPECT_LT(d.share_over, 1e-3) << options.strata << " " << options.block;
    EXPECT_NEAR(there->samples_per_ray, here.samples_per_ray, 0.01 * here.samples_per_ray);
  }
}

TEST_F(FrameRendererTest, AvatarsWithAttributesFallBackToTheProcessorAndSaySo) {
  Avatar avatar = posable_avatar();
  avatar.attributes.resize(1);
  const auto backend = device_backend(device_, false);
  const auto refused = backend->make_renderer(avatar);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().what, HasSubstr("only on the processor"));
  std::string said;
  const auto made = make_renderer({backend, true, [&](const std::string& words) { said = words; }}, avatar);
  ASSERT_TRUE(made.ok());
  EXPECT_EQ((*made)->backend(), "cpu");
  EXPECT_THAT(said, HasSubstr("Continuing on the processor"));
}

TEST_F(FrameRendererTest, EachPartOfThePoseChangesThePicture) {
  // The test above would not notice a warp, bend or deformation missing on both sides.
  const Avatar avatar = posable_avatar();
  const RenderState posed = posed_state(avatar, 0);
  const auto on_device = renderer(avatar);
  const Image whole = picture(*on_device, avatar, posed, with_strata(8, 1));
  RenderState other = posed;
  other.warp.mouth.open = 0;
  EXPECT_GT(difference(whole, picture(*on_device, avatar, other, with_strata(8, 1))).mean, 1e-4);
  other.warp.displacement.assign(other.warp.displacement.size(), 0);
  EXPECT_GT(difference(whole, picture(*on_device, avatar, other, with_strata(8, 1))).mean, 1e-3);
  other = posed, other.torso.hem.reset();
  EXPECT_GT(difference(whole, picture(*on_device, avatar, other, with_strata(8, 1))).mean, 1e-4);
  other = posed, other.torso = {};
  EXPECT_GT(difference(whole, picture(*on_device, avatar, other, with_strata(8, 1))).mean, 1e-4);
  Avatar stiff = avatar;
  stiff.neck = {};
  EXPECT_GT(difference(whole, picture(*renderer(stiff), stiff, posed, with_strata(8, 1))).mean, 1e-4);
}

TEST_F(FrameRendererTest, AvatarsWithoutATorsoOrGridMatchTheProcessor) {
  Avatar avatar = tiny_avatar();
  avatar.torso.reset();
  for (const bool grid : {true, false}) {
    if (!grid) avatar.head.occupancy = {};
    const Image here = render_frame(avatar, typical_camera(avatar), typical_state(avatar)).rgba;
    const Image there = picture(*renderer(avatar), avatar, typical_state(avatar), {});
    EXPECT_LT(difference(here, there).mean, 2e-5) << grid;
  }
}

TEST_F(FrameRendererTest, QualitiesMatchTheProcessorAtOneRayPerPixel) {
  const Avatar avatar = posable_avatar();
  const auto on_device = renderer(avatar, true);
  for (const RenderQuality quality : {RenderQuality::final, RenderQuality::preview}) {
    RenderOptions exact = device_options(render_options(quality));
    EXPECT_EQ(exact.reduce, 1);
    exact.precision = FieldPrecision::exact;
    const Image here = picture(*cpu_renderer(avatar), avatar, posed_state(avatar, 1), exact);
    // Products in bfloat16 on the device, in single precision here.
    const Image there = picture(*on_device, avatar, posed_state(avatar, 1), render_options(quality));
    EXPECT_LT(difference(here, there).mean, 2e-3);
  }
}

TEST_F(FrameRendererTest, PosesAndSizesMayChangeBetweenFrames) {
  const Avatar avatar = posable_avatar();
  const auto on_device = renderer(avatar);
  const RenderOptions options = with_strata(8, 2);
  for (const int number : {0, 3, 1}) {  // tables that grow and shrink
    const RenderState state = posed_state(avatar, number);
    EXPECT_LT(difference(picture(*cpu_renderer(avatar), avatar, state, options),
                         picture(*on_device, avatar, state, options))
                  .mean,
              2e-5)
        << number;
  }
  Camera camera = typical_camera(avatar);
  camera.intrinsics = {33, 20, 45, 45, 16, 10, 0, 0, 0, 0};
  const auto smaller = on_device->render(camera, posed_state(avatar, 1), options);
  ASSERT_TRUE(smaller.ok());
  EXPECT_LT(
      difference(render_frame(avatar, camera, posed_state(avatar, 1), options).rgba, smaller->rgba).mean,
      2e-5);
}

// Positions and directions of the samples of all pixels, by field, ray after ray.
std::array<std::vector<Vec3f>, 4> processors_samples(const Avatar& avatar, const RenderState& state,
                                                     const PictureTiles& tiles, int most) {
  const NeckBend bend =
      make_neck_bend(avatar.neck, inverse(state.pose.world_from_head) * state.pose.world_from_torso,
                     avatar.head.cube.origin, avatar.head.cube.side);
  MarchVolumes volumes = march_volumes(avatar.head, &*avatar.torso, {&bend, 1});
  volumes.max_samples = most;
  const Pose cam = typical_camera(avatar).cam_from_world;
  const UnitFromCamera maps[2] = {unit_from_camera(avatar.head.cube, cam, state.pose.world_from_head),
                                  unit_from_camera(avatar.torso->cube, cam, state.pose.world_from_torso)};
  std::vector<RayRequest> rays(tiles.place.size());
  for (std::size_t r = 0; r < rays.size(); ++r)
    for (std::size_t f = 0; f < 2; ++f)
      rays[r].fields[f] = field_ray(maps[f], Eigen::Map<const Vec3f>(tiles.directions.data() + 3 * r));
  SampleBatch batch;
  sample_rays(rays, volumes, batch);
  warp_samples(std::span(&state.warp, 1), avatar.head.cube, batch.fields[0]);
  straighten_samples({&bend, 1}, batch.fields[0]);
  warp_samples(std::span(&state.torso, 1), avatar.torso->cube, batch.fields[1]);
  std::array<std::vector<Vec3f>, 4> out;
  for (std::size_t f = 0; f < 2; ++f)
    for (std::size_t i = 0; i < batch.fields[f].count(); ++i) {
      const FieldSamples& s = batch.fields[f];
      out[f].push_back({s.x[i], s.y[i], s.z[i]}), out[2 + f].push_back({s.dx[i], s.dy[i], s.dz[i]});
    }
  return out;
}

TEST_F(FrameRendererTest, MarchedSamplesMatchTheProcessor) {
  const Avatar avatar = posable_avatar();
  const RenderState state = posed_state(avatar, 2);
  const int most = 12;
  const PictureTiles tiles = picture_tiles(avatar.intrinsics, 1, 1000);
  const std::size_t rays = tiles.place.size(), lanes = 300, capacity = rays * most;
  const auto truth = processors_samples(avatar, state, tiles, most);

  const auto send = [&]<class T>(const std::vector<T>& from) {
    auto array = DeviceArray<T>::make(device_, from.size());
    EXPECT_TRUE(array.ok() && device_->copy_in(array->data(), from.data(), from.size() * sizeof(T)).ok());
    return std::move(*array);
  };
  const auto room = [&](std::size_t count) {
    auto array = DeviceArray<float>::make(device_, count);
    EXPECT_TRUE(array.ok() && device_->clear(array->data(), count * sizeof(float)).ok());
    return std::move(*array);
  };
  const MarchVolume head = march_volume(avatar.head.occupancy, avatar.head.core),
                    torso = march_volume(avatar.torso->occupancy, avatar.torso->core);
  const auto head_bits = send(avatar.head.occupancy.bits), head_core = send(avatar.head.core.bits),
             head_opacity = send(avatar.head.opacity), head_bricks = send(head.bricks),
             torso_bits = send(avatar.torso->occupancy.bits), torso_bricks = send(torso.bricks);
  const auto depths = send(std::vector<float>(depth_of_opacity().begin(), depth_of_opacity().end()));
  std::vector<unsigned char> packed;
  pack_frame(avatar, typical_camera(avatar), state, head, packed);
  const auto frame = send(packed);
  const auto directions = send(tiles.directions);
  const auto neck_cells = room(24 * 24 * 24);
  const auto near = room(96 * lanes), far = room(96 * lanes), depth = room(96 * lanes), t = room(capacity),
             dt = room(capacity), counts = room(2 * rays), offsets = room(2 * rays),
             list_count = room(2 * lanes), totals = room(4), points = room(12 * capacity);
  const auto ints = [](const DeviceArray<float>& array) {
    return reinterpret_cast<std::uint32_t*>(array.data());
  };
  auto* cells = reinterpret_cast<std::uint8_t*>(neck_cells.data());
  MarchScene scene{};
  scene.grid[0] = {1,
                   24,
                   {-0.1f, -0.1f, -0.1f},
                   0.2f,
                   head_bits.data(),
                   head_core.data(),
                   head_opacity.data(),
                   head_bricks.data()};
  scene.grid[1] = {1,       8,       {-0.15f, -0.35f, -0.15f}, 0.3f, torso_bits.data(),
                   nullptr, nullptr, torso_bricks.data()};
  scene.depth_of_opacity = depths.data(), scene.neck_cells = cells;
  scene.frame = reinterpret_cast<const FrameNumbers*>(frame.data());
  scene.near = MarchVolumes().near, scene.far = MarchVolumes().far, scene.min_step = MarchVolumes().min_step;
  const PlacedRays placed{t.data(), dt.data(), ints(counts), std::uint32_t(rays), most};
  const ListMemory lists{near.data(), far.data(), depth.data(), ints(list_count), std::uint32_t(lanes), 72};
  RayOffsetsArgs scan{
      placed, ints(offsets), {ints(totals), ints(totals) + 1}, ints(totals) + 2, ints(totals) + 3};
  GatherArgs gather{scene, placed, ints(offsets), directions.data(), {}};
  for (std::size_t k = 0; k < 12; ++k) gather.point[k / 6][k % 6] = points.data() + k * capacity;
  ASSERT_TRUE(device_->launch(Kernel::neck_cells, NeckCellsArgs{scene, cells}, 24 * 24 * 24).ok());
  ASSERT_TRUE(device_
                  ->launch(Kernel::march_rays,
                           MarchRaysArgs{scene, lists, directions.data(), nullptr, nullptr, placed}, lanes)
                  .ok());
  ASSERT_TRUE(device_->launch(Kernel::ray_offsets, scan, rays).ok());
  ASSERT_TRUE(device_->launch(Kernel::gather_samples, gather, capacity).ok());
  std::vector<float> got(12 * capacity);
  std::vector<std::uint32_t> sums(4), ray_counts(2 * rays), ray_offsets(2 * rays);
  ASSERT_TRUE(device_->copy_out(got.data(), points.data(), got.size() * 4).ok());
  ASSERT_TRUE(device_->copy_out(sums.data(), totals.data(), 16).ok());
  ASSERT_TRUE(device_->copy_out(ray_counts.data(), counts.data(), 8 * rays).ok());
  ASSERT_TRUE(device_->copy_out(ray_offsets.data(), offsets.data(), 8 * rays).ok());
  ASSERT_TRUE(device_->wait().ok());

  EXPECT_EQ(sums[2], sums[0] + sums[1]);
  std::size_t met = 0;
  for (std::size_t f = 0; f < 2; ++f) {
    ASSERT_EQ(sums[f], truth[f].size()) << f;
    EXPECT_GT(sums[f], 1000u) << f;
    // Groups of rays take their places in any order; within the ray and the group all is in order.
    std::size_t apart = 0, i = 0;
    for (std::size_t r = 0; r < rays; ++r) {
      if (f == 0) met += ray_counts[r] + ray_counts[rays + r] > 0;
      for (std::uint32_t k = 0; k < ray_counts[f * rays + r]; ++k, ++i) {
        const std::size_t at = 6 * f * capacity + ray_offsets[f * rays + r] + k;
        float off = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          off = std::max(off, std::abs(got[at + c * capacity] - truth[f][i][Eigen::Index(c)]));
          EXPECT_NEAR(got[at + (3 + c) * capacity], truth[2 + f][i][Eigen::Index(c)], 1e-5f);
        }
        apart += off > 1e-4f;
      }
    }
    // At the edge of a lip, or of a cell, rounding decides.
    EXPECT_LE(apart, sums[f] / 500) << f;
  }
  EXPECT_EQ(sums[3], met);
}

// -- What only a device that fails on request shows

TEST(EmulatedFrames, WaitOnceAndAllocateNothing) {
  const Avatar avatar = posable_avatar();
  const auto made = device_backend(emulated_device(), false)->make_renderer(avatar);
  const auto frame = [&](int number) {
    return (*made)->render(typical_camera(avatar), posed_state(avatar, number), with_strata(8, 2)).ok();
  };
  ASSERT_TRUE(frame(1));
  const EmulatedCounts first = emulated_counts();
  ASSERT_TRUE(frame(0) && frame(1));
  const EmulatedCounts third = emulated_counts();
  EXPECT_EQ(third.waits, first.waits + 2);
  EXPECT_EQ(third.replays, first.replays + 2);
  EXPECT_EQ(third.max_bytes, first.max_bytes);
  EXPECT_EQ(third.bytes, first.bytes);
  EXPECT_EQ(third.waits_while_recording, 0u);
}

TEST(EmulatedFrames, LittleMemoryCutsThePictureIntoBands) {
  const Avatar avatar = posable_avatar();
  const RenderState state = posed_state(avatar, 0);
  const auto rendered = [&](std::size_t memory, std::size_t& most) {
    const auto made = device_backend(emulated_device({.memory_bytes = memory}), false)->make_renderer(avatar);
    auto frame = (*made)->render(typical_camera(avatar), state, with_strata(8, 2));
    EXPECT_TRUE(frame.ok());
    most = emulated_counts().max_bytes;
    return frame ? frame->rgba : Image();
  };
  std::size_t much = 0, little = 0;
  const Image whole = rendered(std::size_t{1} << 30, much);
  const Image bands = rendered(std::size_t{24} << 20, little);
  EXPECT_LT(little, much / 2);
  EXPECT_EQ(bands.data, whole.data);
}

TEST(EmulatedFrames, FullDeviceIsReportedAndTheProcessorContinues) {
  const Avatar avatar = posable_avatar();
  const RenderState state = posed_state(avatar, 0);
  const RenderOptions options = with_strata(8, 1);
  const Image here = render_frame(avatar, typical_camera(avatar), state, options).rgba;
  for (const EmulatedFaults& faults :
       {EmulatedFaults{.memory_bytes = 1 << 19}, EmulatedFaults{.memory_bytes = 1 << 10},
        EmulatedFaults{.lost_after = 40}}) {
    const auto backend = device_backend(emulated_device(faults), false);
    const char* const words = faults.lost_after >= 0 ? "stopped responding" : "out of memory";
    Error error{};
    {
      const auto made = make_renderer({backend, false, {}}, avatar);
      if (made) {
        Result<RenderedFrame> frame = (*made)->render(typical_camera(avatar), state, options);
        for (int k = 0; frame && k < 9; ++k) frame = (*made)->render(typical_camera(avatar), state, options);
        ASSERT_FALSE(frame.ok());
        error = frame.error();
      } else {
        error = made.error();
      }
    }
    EXPECT_THAT(error.what, HasSubstr(words));
    EXPECT_THAT(error.fix, HasSubstr("--backend cpu"));
    EXPECT_EQ(emulated_counts().bytes, 0u);
    std::vector<std::string> said;
    const auto made =
        make_renderer({backend, true, [&](const std::string& text) { said.push_back(text); }}, avatar);
    ASSERT_TRUE(made.ok());
    for (int k = 0; k < 9; ++k) {
      const auto frame = (*made)->render(typical_camera(avatar), state, options);
      ASSERT_TRUE(frame.ok());
      EXPECT_LT(difference(here, frame->rgba).mean, 2e-5);
    }
    EXPECT_EQ((*made)->backend(), "cpu");
    ASSERT_EQ(said.size(), 1u);
    EXPECT_THAT(said.front(), HasSubstr("Continuing on the processor"));
  }
}

TEST(RenderPlace, WithoutABackendItIsTheProcessor) {
  const Avatar avatar = tiny_avatar();
  const auto made = make_renderer({}, avatar);
  ASSERT_TRUE(made.ok());
  const auto frame = (*made)->render(typical_camera(avatar), typical_state(avatar), {});
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->rgba.data, render_frame(avatar, typical_camera(avatar), typical_state(avatar)).rgba.data);
}

}  // namespace
}  // namespace likeness
