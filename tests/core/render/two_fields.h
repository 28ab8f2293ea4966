// A head's and a torso's field that are small, and rays with samples in both, for tests of backends.
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/render/backend.h"
#include "tests/core/field/random_field.h"
#include "tests/core/field/relative_l2.h"

namespace likeness {

inline double length(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += double(v) * double(v);
  return std::sqrt(sum);
}

struct TwoFields {
  static constexpr std::size_t kViews = 3, kRays = 70, kSamplesPerRay = 8;
  std::array<Field, 2> fields;
  std::array<AdamState, 2> adam;
  std::vector<float> codes;
  ArrayAdamState codes_adam;

  explicit TwoFields(std::uint32_t seed) {
    FieldConfig head = small_configs()[0].config, torso = head;
    torso.condition_count = torso.latent_count = 0;
    torso.view_direction = false;
    fields = {trained_like_field(head, seed), trained_like_field(torso, seed + 100)};
    for (std::size_t f = 0; f < 2; ++f) adam[f] = make_adam_state(fields[f]);
    codes.assign(2 * kViews * std::size_t(head.latent_count), 0.0f);
  }
  LearntParts parts() {
    return {{LearntParts::Part{&fields[0], &adam[0]}, {&fields[1], &adam[1]}}, &codes, &codes_adam};
  }
  static LearnerShape shape() { return {kRays, kSamplesPerRay, kViews, kViews - 1}; }
};

// Rays of views in turn, with up to kSamplesPerRay samples each, some without any.
struct RayProblem {
  SampleBatch samples;
  std::vector<Vec3f> target, background;
  std::vector<float> conditions;

  RayProblem(const TwoFields& of, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    const auto vector = [&] { return Vec3f(unit(random), unit(random), unit(random)); };
    samples.begin.push_back(0);
    for (std::size_t r = 0; r < TwoFields::kRays; ++r) {
      const auto view =
          std::int32_t(r * TwoFields::kViews / TwoFields::kRays + (random() % 2 ? TwoFields::kViews : 0));
      const std::size_t count = random() % (TwoFields::kSamplesPerRay + 1);
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t f = random() % 3 == 0 ? 1 : 0;
        FieldSamples& to = samples.fields[f];
        samples.slot.push_back(std::uint32_t(to.count()));
        samples.field.push_back(std::uint8_t(f));
        samples.dt.push_back(0.05f + 0.2f * unit(random));
        const Vec3f at = vector(), d = (vector() - Vec3f::Constant(0.5f)).normalized();
        to.x.push_back(at.x()), to.y.push_back(at.y()), to.z.push_back(at.z());
        to.dx.push_back(d.x()), to.dy.push_back(d.y()), to.dz.push_back(d.z());
        to.view.push_back(view);
      }
      samples.begin.push_back(std::uint32_t(samples.dt.size()));
      target.push_back(vector()), background.push_back(vector());
    }
    const std::size_t k = 2 * TwoFields::kViews * std::size_t(of.fields[0].config.condition_count);
    for (std::size_t i = 0; i < k; ++i) conditions.push_back(2 * unit(random) - 1);
  }
  LearningStep step() const {
    LearningStep step{samples, target, background, conditions, TwoFields::kViews};
    step.table_rate = 1e-2f, step.table_decay = 0.1f, step.network_rate = 3e-3f;
    step.code_rate = 1e-3f, step.code_penalty = 1e-4f;
    return step;
  }
};

}  // namespace likeness
