// Claims about pictures with a stand-in for an avatar's fields.
#include "core/render/stand_in.h"

#include <gtest/gtest.h>

#include "core/field/conditioned_field.h"
#include "core/field/evaluate.h"
#include "core/render/render.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness {
namespace {

// The fields themselves.
class Themselves final : public StandInFields {
 public:
  Themselves(const Avatar& avatar, const Articulation& articulation)
      : psi_(condition(avatar.condition, articulation)),
        fields_{ConditionedField(avatar.head.field, {psi_.data(), std::size_t(psi_.size())},
                                 FieldPrecision::exact),
                ConditionedField(avatar.torso->field, {}, FieldPrecision::exact)} {}
  void densities(int part, const FieldSamples& samples, std::vector<float>& sigma) const override {
    evaluate_density(fields_[std::size_t(part)], samples.inputs(nullptr, nullptr), sigma);
  }
  void colours(const std::array<WeightedSamples, 2>& parts, std::span<Vec3f> rays) const override {
    for (std::size_t f = 0; f < 2; ++f) {
      if (parts[f].slots.empty()) continue;
      std::vector<float> sigma;
      GeometryFeatures geometry;
      FieldOutputs out;
      const FieldInputs inputs = parts[f].samples->inputs(nullptr, nullptr);
      evaluate_density(fields_[f], inputs, sigma, geometry);
      evaluate_colour(fields_[f], inputs, geometry, parts[f].slots, out);
      for (std::size_t k = 0; k < parts[f].slots.size(); ++k)
        rays[parts[f].rays[k]] += parts[f].weights[k] * Vec3f(out.red[k], out.green[k], out.blue[k]);
    }
  }

 private:
  Eigen::VectorXf psi_;
  std::array<ConditionedField, 2> fields_;
};

TEST(StandIn, FieldsStandingInForThemselvesGiveTheSamePicture) {
  const Avatar avatar = tiny_avatar();
  const Camera camera = typical_camera(avatar);
  const RenderState state = typical_state(avatar);
  const Themselves fields(avatar, state.pose.articulation);
  RenderOptions blocks = render_options(RenderQuality::final);
  blocks.precision = FieldPrecision::exact;
  RenderOptions few = render_options(RenderQuality::preview);
  few.precision = FieldPrecision::exact, few.max_rays = 300;
  for (const RenderOptions& options : {RenderOptions{}, blocks, few}) {
    const RenderedFrame own = render_frame(avatar, camera, state, options),
                        other = render_frame(avatar, fields, camera, state, options);
    EXPECT_EQ(own.rgba.data, other.rgba.data);
    EXPECT_EQ(own.samples_per_ray, other.samples_per_ray);
    EXPECT_GT(own.samples_per_ray, 1);
  }
}

TEST(StandIn, NeverReadsTheFields) {
  Avatar avatar = tiny_avatar();
  const Camera camera = typical_camera(avatar);
  const RenderState state = typical_state(avatar);
  const Avatar whole = avatar;
  const Themselves of_whole(whole, state.pose.articulation);
  avatar.head.field.parameters.clear(), avatar.torso->field.parameters.clear();
  EXPECT_EQ(render_frame(avatar, of_whole, camera, state).rgba.data,
            render_frame(whole, camera, state).rgba.data);
}

}  // namespace
}  // namespace likeness
