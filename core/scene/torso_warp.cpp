#include "core/scene/torso_warp.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace likeness {
namespace {

constexpr int kInversionSteps = 12;  // each shrinks the error by the strain, which is a few percent

Vec2f at(const TorsoGrid& grid, const std::vector<float>& values, const Vec2f& p) {
  const GridPlace place = place_in(grid, p.x(), p.y());
  Vec2f sum = Vec2f::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t i = 2 * std::size_t(place.node[k]);
    sum += place.weight[k] * Vec2f(values[i], values[i + 1]);
  }
  return sum;
}

}  // namespace

GridPlace place_in(const TorsoGrid& grid, float x, float y) {
  const float u = std::clamp((x - grid.origin.x()) / grid.cell, 0.f, float(grid.columns - 1));
  const float v = std::clamp((y - grid.origin.y()) / grid.cell, 0.f, float(grid.rows - 1));
  const int column = std::min(int(u), grid.columns - 2), row = std::min(int(v), grid.rows - 2);
  const float a = u - float(column), b = v - float(row);
  const int first = row * grid.columns + column;
  return {{first, first + 1, first + grid.columns, first + grid.columns + 1},
          {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b}};
}

bool take_modes(std::vector<std::vector<float>> from_file, TorsoModes& modes) {
  if (from_file.size() > modes.modes.size()) return false;
  modes.modes.fill(std::vector<float>(modes.mean.size(), 0.0f));
  std::ranges::move(from_file, modes.modes.begin());
  return true;
}

std::optional<TorsoShape> take_shape(std::span<const float> from_file) {
  TorsoShape shape{};
  if (from_file.size() > shape.size()) return std::nullopt;
  std::ranges::copy(from_file, shape.begin());
  return shape;
}

bool is_consistent(const TorsoModes& modes) {
  const TorsoGrid& grid = modes.grid;
  if (grid.empty()) return true;
  const bool sizes = grid.columns >= 2 && grid.rows >= 2 && grid.columns <= 1024 && grid.rows <= 1024 &&
                     grid.cell > 0 && std::isfinite(grid.cell) && grid.origin.allFinite();
  const auto fits = [&](const std::vector<float>& values) {
    return values.size() == 2 * std::size_t(grid.nodes()) &&
           std::ranges::all_of(values, [](float v) { return std::isfinite(v); });
  };
  return sizes && fits(modes.mean) && std::ranges::all_of(modes.modes, fits);
}

std::vector<float> posed_displacement(const TorsoModes& modes, const TorsoShape& shape) {
  std::vector<float> sum = modes.mean;
  for (std::size_t k = 0; k < shape.size(); ++k) {
    LIKENESS_CHECK(modes.modes[k].size() == sum.size(), "torso mode of %zu numbers, mean of %zu",
                   modes.modes[k].size(), sum.size());
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += shape[k] * modes.modes[k][i];
  }
  return sum;
}

TorsoField torso_field(const TorsoModes& modes, const TorsoShape& shape) {
  TorsoField field;
  field.hem = modes.hem;
  if (modes.empty()) return field;
  field.grid = modes.grid;
  const std::vector<float> posed = posed_displacement(modes, shape);
  field.displacement.resize(posed.size());
  for (int row = 0; row < modes.grid.rows; ++row)
    for (int column = 0; column < modes.grid.columns; ++column) {
      const Vec2f p = modes.grid.origin + modes.grid.cell * Vec2f(float(column), float(row));
      Vec2f canonical = p;
      for (int step = 0; step < kInversionSteps; ++step) canonical = p - at(modes.grid, posed, canonical);
      const std::size_t i = 2 * (std::size_t(row) * modes.grid.columns + column);
      field.displacement[i] = canonical.x() - p.x();
      field.displacement[i + 1] = canonical.y() - p.y();
    }
  return field;
}

Vec3f torso_displacement(const TorsoField& field, const Vec3f& point) {
  Vec2f d = Vec2f::Zero();
  if (!field.grid.empty()) d = at(field.grid, field.displacement, point.head<2>());
  if (field.hem) d.y() = std::max(d.y(), field.hem->at(point.x() + d.x(), point.z()) - point.y());
  return {d.x(), d.y(), 0};
}

}  // namespace likeness
