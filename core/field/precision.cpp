// Rounding tables: see precision.h and rounded_tables.h.
#include "core/field/precision.h"

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/field/field_bf16.h"
#include "core/field/field_layout.h"
#include "core/field/rounded_tables.h"

namespace likeness {

bool has_bf16(const FieldConfig& config) {
  const bool ambient = config.ambient && config.condition_count > 0;
  return cpu_has_bf16() && grid_has_bf16(config.position) && (!ambient || grid_has_bf16(config.ambient_grid));
}

void round_tables(const Field& field, std::size_t count, RoundedTables& rounded) {
  constexpr std::size_t kChunk = 1 << 16;
  rounded.count = count;
  rounded.memory.reserve((count + 1) / 2);
  parallel_ranges(count, kChunk, [&](std::size_t begin, std::size_t end) {
    round_table(field.parameters.data() + begin, end - begin, rounded.values() + begin);
  });
}

std::shared_ptr<const RoundedTables> tables_of(const Field& field, std::size_t count) {
  if (field.rounded) {
    LIKENESS_CHECK(field.rounded->count == count, "%zu rounded entries for tables of %zu",
                   field.rounded->count, count);
    return field.rounded;
  }
  auto rounded = std::make_shared<RoundedTables>();
  round_tables(field, count, *rounded);
  return rounded;
}

void round_tables(Field& field) {
  if (!has_bf16(field.config)) return;
  field.rounded = nullptr;
  field.rounded = tables_of(field, make_layout(field.config).table_count);
}

}  // namespace likeness
