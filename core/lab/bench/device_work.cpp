// Operations and bytes, counted: see device_work.h.
#include "core/lab/bench/device_work.h"

#include <algorithm>

#include "core/lab/bench/field_work.h"

namespace likeness {
namespace {

constexpr double kInputBytes = 7 * 4, kOutputBytes = 4 * 4;  // per sample
constexpr double kAdamBytes = 8 * 4;  // per parameter: value, gradient and moments, both read and written

// The number of table parameters that `samples` can touch at most.
double touched_parameters(const FieldConfig& config, std::size_t samples) {
  double all = 0;
  for (const TableWork& table : field_work(config).tables)
    all += std::min(double(table.bytes) / 4, double(samples) * table.updates * double(kTableLine));
  return all;
}

double needed_entries(const FieldConfig& config, std::size_t samples) {
  double all = 0;
  for (const TableWork& table : field_work(config).tables)
    all += std::min(double(table.bytes),
                    double(samples) * table.forward_reads * 4 * double(config.position.features));
  return all;
}

double network_parameters(const FieldConfig& config) {
  double all = 0;
  for (const ParameterBlock& block : parameter_layout(config))
    if (!block.table) all += double(block.count);
  return all;
}

}  // namespace

DeviceWork inference_work(const FieldConfig& config, std::size_t samples) {
  return {double(samples) * field_work(config).forward_flops, double(samples) * (kInputBytes + kOutputBytes) +
                                                                  needed_entries(config, samples) +
                                                                  4 * network_parameters(config)};
}

DeviceWork training_work(const FieldConfig& config, std::size_t samples) {
  return {double(samples) * field_work(config).training_flops,
          double(samples) * (kInputBytes + kOutputBytes) + needed_entries(config, samples) +
              kAdamBytes * (touched_parameters(config, samples) + network_parameters(config))};
}

double floor_seconds(const DeviceWork& work, const DeviceCeilings& ceilings) {
  const double moving = work.bytes / (1e9 * ceilings.bandwidth_gbs);
  return ceilings.matrix_tflops > 0 ? std::max(moving, work.flops / (1e12 * ceilings.matrix_tflops)) : moving;
}

}  // namespace likeness
