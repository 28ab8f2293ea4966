// Claims about the demo's light.
#include "core/synth/shade.h"

#include <gtest/gtest.h>

#include "core/base/rigid.h"

namespace likeness {
namespace {

LightRig dark_rig() {
  LightRig rig = make_light_rig();
  rig.key.radiance = rig.fill.radiance = rig.rim.radiance = Vec3f::Zero();
  return rig;
}

const Visible kAllFree = [](const Vec3f&, const Vec3f&, float) { return true; };
const Visible kAllBlocked = [](const Vec3f&, const Vec3f&, float) { return false; };

TEST(GatherLight, OpenSkyOfOneColourGivesThatColour) {
  LightRig rig = dark_rig();
  rig.ceiling = rig.walls = rig.floor = Vec3f(0.2f, 0.3f, 0.4f);
  const Received r = gather_light(rig, Vec3f::UnitY(), Vec3f::Zero(), Vec3f::UnitX(), kAllFree, {}, 7);
  EXPECT_LT((r.diffuse - Vec3f(0.2f, 0.3f, 0.4f)).norm(), 1e-4f);
  EXPECT_FLOAT_EQ(r.sky_open, 1);
}

TEST(GatherLight, BlockedPointReceivesNothing) {
  const Received r =
      gather_light(make_light_rig(), Vec3f::UnitY(), Vec3f::Zero(), Vec3f::UnitZ(), kAllBlocked, {}, 7);
  EXPECT_EQ(r.diffuse, Vec3f::Zero());
  EXPECT_EQ(r.key_open, 0);
}

TEST(GatherLight, FarSmallLightObeysTheInverseSquareAndTheCosine) {
  LightRig rig = dark_rig();
  rig.ceiling = rig.walls = rig.floor = Vec3f::Zero();
  rig.key.half_u = Vec3f(0.05f, 0, 0);
  rig.key.half_v = Vec3f(0, -0.05f, 0);  // shines towards -z
  rig.key.radiance = Vec3f::Ones();
  const auto at = [&](float distance, const Vec3f& normal) {
    rig.key.centre = Vec3f(0, 0, distance);
    return gather_light(rig, Vec3f::UnitY(), Vec3f::Zero(), normal, kAllFree, {}, 3).diffuse.x();
  };
  const float near = at(2, Vec3f::UnitZ());
  EXPECT_NEAR(near, 0.01f / (3.14159265f * 4), 0.02f * near);  // area / (pi d^2)
  EXPECT_NEAR(at(4, Vec3f::UnitZ()) / near, 0.25f, 0.01f);
  EXPECT_NEAR(at(2, Vec3f(0.8f, 0, 0.6f)) / near, 0.6f, 0.02f);
  EXPECT_EQ(at(2, -Vec3f::UnitZ()), 0);
}

TEST(TransformRig, LightOnAMovedSurfaceIsTheSame) {
  const LightRig rig = make_light_rig();
  Pose m = Pose::Identity();
  m.linear() = rotation_about(Vec3d(1, 2, -1).normalized(), 0.7);
  m.translation() = Vec3d(0.3, -0.2, 0.5);
  const Vec3f p(0.02f, 0.05f, 0.1f), n = Vec3f(0.2f, 0.1f, 1).normalized();
  const Eigen::Isometry3f f = m.cast<float>();
  GatherOptions options;
  options.sky_rays = 0;
  const Vec3f here = gather_light(rig, Vec3f::UnitY(), p, n, kAllFree, options, 5).diffuse;
  const Vec3f there = gather_light(transform_rig(rig, m), f.linear() * Vec3f::UnitY(), f * p, f.linear() * n,
                                   kAllFree, options, 5)
                          .diffuse;
  EXPECT_LT((here - there).norm(), 1e-4f * here.norm());
}

TEST(Glossy, IsBrightestInTheMirrorDirection) {
  AreaLight light{Vec3f(0, 1, 1), Vec3f(0.05f, 0, 0), Vec3f(0, -0.035f, 0.035f), Vec3f::Ones()};
  if (light.half_u.cross(light.half_v).dot(light.centre) > 0) light.half_v = -light.half_v;
  const Vec3f mirror = Vec3f(0, -1, 1).normalized();
  const float best = glossy(light, Vec3f::Zero(), Vec3f::UnitZ(), mirror, 0.3f, 0.04f).x();
  for (const float off : {-0.4f, 0.4f}) {
    const Vec3f eye = (mirror + off * Vec3f::UnitX()).normalized();
    EXPECT_LT(glossy(light, Vec3f::Zero(), Vec3f::UnitZ(), eye, 0.3f, 0.04f).x(), best);
  }
}

TEST(Develop, RisesFromBlackToWhiteAndInvertsLinearColourInTheMidtones) {
  float last = -1;
  for (float x = 0; x < 6; x += 0.01f) {
    const float y = develop(Vec3f::Constant(x)).x();
    EXPECT_GE(y, last);
    EXPECT_LE(y, 1.0f);
    last = y;
  }
  EXPECT_NEAR(develop(linear_colour(0.5f, 0.25f, 0.7f)).x(), 0.5f, 1e-3f);
}

}  // namespace
}  // namespace likeness
