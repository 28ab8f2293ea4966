// Claims about rendering.
#include "core/render/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/field/conditioned_field.h"
#include "core/field/evaluate.h"
#include "core/render/composite.h"
#include "core/render/rays.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness {
namespace {

RayRequest ray_of(const Avatar& a, const Camera& camera, const RenderState& state, int x, int y) {
  const Vec3f d = ray_direction(camera.intrinsics, Vec2d(x + 0.5, y + 0.5)).normalized().cast<float>();
  RayRequest ray;
  ray.fields[0] =
      field_ray(unit_from_camera(a.head.cube, camera.cam_from_world, state.pose.world_from_head), d);
  ray.fields[1] =
      field_ray(unit_from_camera(a.torso->cube, camera.cam_from_world, state.pose.world_from_torso), d);
  return ray;
}

TEST(RenderFrame, EqualsCompositingEachPixelSeparately) {
  const Avatar a = tiny_avatar();
  const Camera camera = typical_camera(a);
  const RenderState state = typical_state(a);
  RenderOptions options;
  options.stop_transmittance = options.shade_weight = 0;
  options.max_samples = 16, options.strata = 0;
  const RenderedFrame frame = render_frame(a, camera, state, options);
  const Eigen::VectorXf psi = condition(a.condition, state.pose.articulation);
  const MarchVolumes volumes = march_volumes(a.head, &*a.torso);
  int seen = 0;
  for (int y = 1; y < 24; y += 4)
    for (int x = 1; x < 24; x += 3) {
      const RayRequest ray = ray_of(a, camera, state, x, y);
      SampleBatch batch;
      sample_rays(std::span(&ray, 1), volumes, batch);
      std::array<FieldOutputs, 2> out;
      evaluate_field(a.head.field, batch.fields[0].inputs(psi.data(), nullptr), out[0]);
      evaluate_field(a.torso->field, batch.fields[1].inputs(nullptr, nullptr), out[1]);
      std::vector<float> sigma, colour;
      for (std::size_t i = 0; i < batch.dt.size(); ++i) {
        const FieldOutputs& o = out[batch.field[i]];
        const std::uint32_t at = batch.slot[i];
        sigma.push_back(o.sigma[at]);
        for (const float c : {o.red[at], o.green[at], o.blue[at]}) colour.push_back(c);
      }
      const auto expected = composite_ray(int(sigma.size()), sigma.data(), batch.dt.data(), colour.data());
      const float* pixel = frame.rgba.at(x, y);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], expected.colour[c], 1e-5) << x << ' ' << y;
      EXPECT_NEAR(pixel[3], 1 - expected.transmittance, 1e-5);
      seen += pixel[3] > 0.1f;
    }
  EXPECT_GT(seen, 10);
}

// A field that differs from place to place: a fresh one hardly does.
void roughen(Field& field) {
  for (const ParameterBlock& block : parameter_layout(field.config))
    for (std::size_t i = 0; block.table && i < block.count; ++i)
      field.parameters[block.offset + i] = std::sin(float(i));
}

TEST(RenderFrame, DeferredShadingLooksUpOneColourForTheMeanOfARaysFeatures) {
  Avatar a = tiny_avatar();
  roughen(a.head.field), roughen(a.torso->field);
  const Camera camera = typical_camera(a);
  const RenderState state = typical_state(a);
  RenderOptions options;
  options.stop_transmittance = options.shade_weight = 0;
  options.max_samples = 16, options.strata = 0;
  const Image each = render_frame(a, camera, state, options).rgba;
  options.deferred = true;
  const Image deferred = render_frame(a, camera, state, options).rgba;
  const Eigen::VectorXf psi = condition(a.condition, state.pose.articulation);
  const ConditionedField fields[] = {{a.head.field, {psi.data(), 2}, FieldPrecision::exact},
                                     {a.torso->field, {}, FieldPrecision::exact}};
  const MarchVolumes volumes = march_volumes(a.head, &*a.torso);
  int seen = 0;
  float most = 0;
  for (int y = 1; y < 24; y += 4)
    for (int x = 1; x < 24; x += 3) {
      const RayRequest ray = ray_of(a, camera, state, x, y);
      SampleBatch batch;
      sample_rays(std::span(&ray, 1), volumes, batch);
      std::array<std::vector<float>, 2> sigma;
      std::array<GeometryFeatures, 2> geometry, mean;
      std::array<float, 2> weight{};
      for (std::size_t f = 0; f < 2; ++f) {
        if (batch.fields[f].count() == 0) continue;
        evaluate_density(fields[f], batch.fields[f].inputs(nullptr, nullptr), sigma[f], geometry[f]);
        mean[f].values.assign(geometry[f].values.size() / sigma[f].size(), 0.0f);
      }
      float transmittance = 1;
      for (std::size_t i = 0; i < batch.dt.size(); ++i) {
        const std::size_t f = batch.field[i], at = batch.slot[i], stride = mean[f].values.size();
        const float after = transmittance * std::exp(-sigma[f][at] * batch.dt[i]);
        weight[f] += transmittance - after;
        for (std::size_t k = 0; k < stride; ++k)
          mean[f].values[k] += (transmittance - after) * geometry[f].values[at * stride + k];
        transmittance = after;
      }
      Vec3f expected = Vec3f::Zero();
      for (std::size_t f = 0; f < 2; ++f) {
        if (weight[f] == 0) continue;
        for (float& value : mean[f].values) value /= weight[f];
        FieldInputs one = batch.fields[f].inputs(nullptr, nullptr);
        one.count = 1;
        FieldOutputs out;
        const std::uint32_t first = 0;
        evaluate_colour(fields[f], one, mean[f], {&first, 1}, out);
        expected += weight[f] * Vec3f(out.red[0], out.green[0], out.blue[0]);
      }
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(deferred.at(x, y)[c], expected[c], 1e-5) << x << ' ' << y;
        most = std::max(most, std::abs(deferred.at(x, y)[c] - each.at(x, y)[c]));
      }
      EXPECT_EQ(deferred.at(x, y)[3], each.at(x, y)[3]);
      seen += deferred.at(x, y)[3] > 0.1f;
    }
  EXPECT_GT(seen, 10);
  EXPECT_GT(most, 1e-3f);  // it is another picture,
  EXPECT_LT(most, 0.1f);   // and nearly the same
}

TEST(RenderFrame, StoppingEarlyAndShadingWhatCountsChangesNoPixelVisibly) {
  const Avatar a = tiny_avatar();
  RenderOptions exact;
  exact.stop_transmittance = exact.shade_weight = 0;
  const RenderedFrame fast = render_frame(a, typical_camera(a), typical_state(a));
  const RenderedFrame full = render_frame(a, typical_camera(a), typical_state(a), exact);
  for (std::size_t i = 0; i < full.rgba.data.size(); ++i)
    EXPECT_NEAR(fast.rgba.data[i], full.rgba.data[i], 1e-3f);
  EXPECT_LE(fast.samples_per_ray, full.samples_per_ray);
}

TEST(RenderPixels, MatchTheFrame) {
  const Avatar a = tiny_avatar();
  RenderOptions options;
  options.block = 1;  // a listed pixel is its own block
  const Image whole = render_frame(a, typical_camera(a), typical_state(a), options).rgba;
  std::vector<std::uint32_t> pixels;
  for (std::uint32_t p = 3; p < whole.pixels(); p += 7) pixels.push_back(p);
  const std::vector<float> some = render_pixels(a, typical_camera(a), typical_state(a), pixels, options);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(some[4 * i + c], whole.data[4 * pixels[i] + c]);
}

TEST(RenderFrame, EachQualityIsNearTheExactPictureAndOfItsSize) {
  const Avatar a = tiny_avatar();
  Camera camera = typical_camera(a);
  const RenderState state = typical_state(a);
  for (double* v :
       {&camera.intrinsics.fx, &camera.intrinsics.fy, &camera.intrinsics.cx, &camera.intrinsics.cy})
    *v *= 2;
  camera.intrinsics.width *= 2, camera.intrinsics.height *= 2;
  camera.intrinsics.width -= 1;  // odd sizes, too
  const Image whole = render_frame(a, camera, state, {}).rgba;
  const auto middle = [](const Image& image) {
    Vec2d sum(0, 0);
    double weight = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        sum += image.at(x, y)[3] * Vec2d(x, y), weight += double(image.at(x, y)[3]);
    EXPECT_GT(weight, 30);
    return Vec2d(sum / weight);
  };
  // Hard edges, a few pixels in all.
  for (const auto& [quality, most] :
       {std::pair(RenderQuality::final, 0.06), {RenderQuality::preview, 0.15}}) {
    RenderOptions options = render_options(quality);
    if (options.max_rays > 0) options.max_rays = camera.intrinsics.width * camera.intrinsics.height / 6;
    const Image quick = render_frame(a, camera, state, options).rgba;
    ASSERT_EQ(quick.width, whole.width);
    ASSERT_EQ(quick.height, whole.height);
    double squares = 0;
    for (std::size_t i = 0; i < whole.data.size(); ++i) squares += std::pow(whole.data[i] - quick.data[i], 2);
    EXPECT_LT(std::sqrt(squares / double(whole.data.size())), most);
    EXPECT_LT((middle(whole) - middle(quick)).norm(), 1);  // less than half a ray
  }
}

// Fields whose tables and networks are rounded give a visually identical picture.
TEST(RenderFrame, InBf16DiffersByLessThanOneByteStep) {
  const Avatar a = tiny_avatar();
  RenderOptions rounded;
  rounded.precision = FieldPrecision::bf16;
  const Image exact = render_frame(a, typical_camera(a), typical_state(a)).rgba;
  const Image quick = render_frame(a, typical_camera(a), typical_state(a), rounded).rgba;
  for (std::size_t i = 0; i < exact.data.size(); ++i) EXPECT_NEAR(quick.data[i], exact.data[i], 1.0 / 255);
  const bool has = has_bf16(a.head.field.config);
  EXPECT_EQ(exact.data != quick.data, has);  // or they would be the same arithmetic
}

TEST(RenderFrame, RepeatsBitForBitWithAnyNumberOfThreads) {
  const Avatar a = tiny_avatar();
  for (const RenderQuality quality : {RenderQuality::final, RenderQuality::preview}) {
    const auto render = [&] {
      RenderOptions options = render_options(quality);
      if (options.max_rays > 0) options.max_rays = 200;  // of 24 x 24 pixels
      return render_frame(a, typical_camera(a), typical_state(a), options).rgba.data;
    };
    const std::vector<float> many = render();
    const ThreadLimit one(1);
    EXPECT_EQ(many, render());
  }
}

// A reduced picture takes every pixel at an edge from a ray of its own.
TEST(RenderFrame, EdgesOfAReducedPictureMatchTheFullOne) {
  const Avatar a = tiny_avatar();
  Camera camera = typical_camera(a);
  Intrinsics& k = camera.intrinsics;
  for (double* v : {&k.fx, &k.fy, &k.cx, &k.cy}) *v *= 4;
  k.width *= 4, k.height *= 4;
  RenderOptions whole, edges, none;
  edges.reduce = none.reduce = 2;
  edges.edge_contrast = 0.3f * float(kUsualPixels) / float(k.width * k.height);
  none.edge_contrast = 1e6f;
  const auto render = [&](const RenderOptions& options) {
    return render_frame(a, camera, typical_state(a), options).rgba;
  };
  const Image truth = render(whole), sharp = render(edges), blurred = render(none);
  const auto wrong = [&](const Image& picture) {
    int count = 0;
    for (std::size_t i = 3; i < truth.data.size(); i += 4)
      count += std::abs(picture.data[i] - truth.data[i]) > 0.2f;
    return count;
  };
  EXPECT_GT(wrong(blurred), 40);
  EXPECT_LT(wrong(sharp), wrong(blurred) / 2);
}

// The same, as far as the rays suffice; with a ray for each pixel it is the whole picture.
TEST(RenderFrame, ExtraRaysGoWhereThePictureVariesTheMost) {
  const Avatar a = tiny_avatar();
  Camera camera = typical_camera(a);
  Intrinsics& k = camera.intrinsics;
  for (double* v : {&k.fx, &k.fy, &k.cx, &k.cy}) *v *= 4;
  k.width *= 4, k.height *= 4;
  const int pixels = k.width * k.height;
  const auto render = [&](int max_rays, float edge_contrast) {
    RenderOptions options;
    options.edge_contrast = edge_contrast, options.max_rays = max_rays;
    return render_frame(a, camera, typical_state(a), options).rgba;
  };
  const Image truth = render_frame(a, camera, typical_state(a)).rgba;
  const auto error = [&](const Image& picture) {
    double squares = 0;
    for (std::size_t i = 0; i < truth.data.size(); ++i)
      squares += std::pow(picture.data[i] - truth.data[i], 2);
    return squares;
  };
  EXPECT_EQ(render(pixels, 0).data, truth.data);
  for (const int rays : {pixels / 2, pixels / 8}) {  // the same reduction, without edges and with them
    const double without = error(render(rays, 1e6f));
    EXPECT_GT(without, 0);
    const double with = error(render(rays, 0));
    EXPECT_LT(with, 0.7 * without) << rays;
    EXPECT_GT(with, 0) << rays;  // they do not suffice for all
  }
}

// A larger picture may take more: a preview of 512 px and more has a ray for 3 x 3 pixels.
TEST(RenderFrame, RaysOfAPreviewGrowWithThePicture) {
  const Avatar a = tiny_avatar();
  const auto takes_a_third = [&](int side) {
    Camera camera = typical_camera(a);
    Intrinsics& k = camera.intrinsics;
    const double scale = double(side) / k.width;
    for (double* v : {&k.fx, &k.fy, &k.cx, &k.cy}) *v *= scale;
    k.width = k.height = side;
    RenderOptions preview = render_options(RenderQuality::preview);
    preview.edge_contrast = 1e6f;
    RenderOptions third = preview;
    third.max_rays = 0, third.reduce = 3;
    const RenderState state = typical_state(a);
    return render_frame(a, camera, state, third).rgba.data ==
           render_frame(a, camera, state, preview).rgba.data;
  };
  for (const int side : {512, 514, 640}) EXPECT_TRUE(takes_a_third(side)) << side;
  EXPECT_FALSE(takes_a_third(256));
}

TEST(RenderFrame, IsTransparentWhereNoCellIsSeen) {
  Avatar a = tiny_avatar();
  a.head.occupancy = make_occupancy(8, false);
  a.torso.reset();
  const RenderedFrame frame = render_frame(a, typical_camera(a), typical_state(a));
  for (const float v : frame.rgba.data) EXPECT_EQ(v, 0.f);
  EXPECT_EQ(frame.samples_per_ray, 0.0);
}

TEST(RenderFrame, TurningTheHeadMovesNoPixelOfTheTorsoAlone) {
  Avatar a = tiny_avatar();
  a.head.occupancy = make_occupancy(8, false);
  RenderState turned = typical_state(a);
  turned.pose.world_from_head.rotate(rotation_about(Vec3d::UnitY(), 0.5));
  const RenderedFrame before = render_frame(a, typical_camera(a), typical_state(a));
  const RenderedFrame after = render_frame(a, typical_camera(a), turned);
  EXPECT_EQ(before.rgba.data, after.rgba.data);
}

TEST(Composite, PutsThePictureOverPlateOrColour) {
  Image rgba(2, 1, 4);
  rgba.data = {0.25f, 0.5f, 0, 0.5f, 0, 0, 0, 0};
  const Image white = composite(rgba, {});
  EXPECT_FLOAT_EQ(white.data[0], 0.75f);
  EXPECT_FLOAT_EQ(white.data[3], 1.f);
  const Image over = composite(rgba, Image8(2, 1, 3, 51));
  EXPECT_NEAR(over.data[0], 0.25f + 0.5f * 0.2f, 1e-6);
  EXPECT_NEAR(over.data[4], 0.2f, 1e-6);
}

}  // namespace
}  // namespace likeness
