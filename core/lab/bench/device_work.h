// Floors for the times of the field's passes on a device: the work that they cannot do without, at the most
// that the device can do.
#pragma once

#include <cstddef>

#include "core/field/field.h"

namespace likeness {

struct DeviceCeilings {
  double bandwidth_gbs = 0;  // read and written
  double matrix_tflops = 0;  // products in bfloat16, sums in single precision; 0 without matrix units
};

// Least work of a pass over a batch: operations, and bytes that cannot but move: inputs and outputs of
// samples, every table entry that is needed once, every parameter that Adam touches and its moments.
struct DeviceWork {
  double flops = 0, bytes = 0;
};
DeviceWork inference_work(const FieldConfig& config, std::size_t samples);
DeviceWork training_work(const FieldConfig& config, std::size_t samples);
// Operations and bytes at once: the longer of the two. s
double floor_seconds(const DeviceWork& work, const DeviceCeilings& ceilings);

}  // namespace likeness
