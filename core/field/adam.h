// Adam (Kingma & Ba 2015) on a field: dense for the networks, lazy for the hash tables, where only lines with
// a gradient are updated and each line counts its own steps.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/field/field.h"
#include "core/field/train_fields.h"

namespace likeness {

struct AdamOptions {
  float table_rate = 1e-2f, network_rate = 2e-3f;  // learning rates; decay them from outside
  float beta1 = 0.9f, beta2 = 0.99f;
  float table_epsilon = 1e-15f,
        network_epsilon = 1e-10f;  // tiny: table gradients are tiny and must not be damped
  float network_l2 = 0;            // adds network_l2 * weight to the gradient of weights
  // Decoupled decay (Loshchilov & Hutter 2019): each step of a line also takes table_decay * table_rate of
  // its values. Entries moved only by noise return to zero instead of drifting.
  float table_decay = 0;

  // Factor on a table's values for a step's decay, in [0, 1].
  float table_keep() const { return std::max(0.0f, 1 - table_decay * table_rate); }
};

struct AdamState {
  std::vector<float> first, second;       // moments, laid out as Field::parameters
  std::vector<std::uint32_t> line_steps;  // (tables / kTableLine) steps each line has taken
  std::uint64_t step = 0;                 // of the networks
};
AdamState make_adam_state(const Field& field);

// One step. Clears what it consumes: gradients.parameters and touched; latents and conditions are left alone.
void adam_step(Field& field, FieldGradients& gradients, AdamState& state, const AdamOptions& options);

// The same for a plain array, e.g. latent codes: steps `values` and clears `gradients`.
struct ArrayAdamState {
  std::vector<float> first, second;
  std::uint64_t step = 0;
};
void adam_step(std::vector<float>& values, std::vector<float>& gradients, ArrayAdamState& state, float rate,
               const AdamOptions& options);

}  // namespace likeness
