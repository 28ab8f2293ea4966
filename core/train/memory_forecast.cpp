#include "core/train/memory_forecast.h"

#include <fmt/format.h>

#include "core/head/pose_head.h"
#include "core/scene/warp_lattice.h"
#include "core/train/capture_summary.h"
#include "core/train/proxy_views.h"

namespace likeness {
namespace {

// Independent of the clip: two fields of the usual sizes with gradients and moments, twice (a copy is kept to
// go back to), and the program with its head model.
constexpr std::uint64_t kEngine = 420ull << 20;
constexpr std::uint64_t kEntry =
    8 * 4 * 32;                          // of a grid, all levels: numbers, halves, gradients, moments, copies
constexpr std::uint64_t kSample = 1600;  // of a step: features, hidden layers, gradients, place
constexpr int kMostSamples = 16;         // a ray
constexpr double kMatteByte = 0.2;       // a pixel, in tiles; 0.14 for a plain cut-out, more for wild hair

// Of both grids, as if every level had room for all its entries.
std::uint64_t grid_bytes(const FieldSizes& sizes) {
  return kEntry * ((1ull << sizes.head_log2_entries) + (1ull << sizes.torso_log2_entries));
}

double gib(std::uint64_t bytes) { return double(bytes) / double(1ull << 30); }

std::size_t proxies_for(std::size_t own_views, const TrainOptions& options) {
  return options.fields.mode == kDefaultMode ? most_proxies(own_views) : 0;
}

MemoryForecast forecast(std::uint64_t views, std::uint64_t size, const HeadModel& model,
                        const PersonShape& person, const Articulation& rest, bool warps,
                        const TrainOptions& options) {
  MemoryForecast forecast;
  forecast.pictures = views * std::uint64_t(double(size * size) * (3 + kMatteByte));
  if (warps) {
    // How a face moves hardly changes how many nodes a lattice keeps: one that moves everywhere represents
    // all.
    Articulation moved = rest;
    moved.expression.array() += 0.1f;
    moved.jaw.x() += 0.05f;
    const HeadShape shape = shape_head(model, person);
    if (const auto warp = make_warp_frame(model, shape, rest))  // else training says what is wrong
      forecast.lattices = views * make_warp_lattice(*warp, pose_head(model, shape, moved)).bytes();
  }
  forecast.engine = kEngine + grid_bytes(options.fields.sizes) - grid_bytes({}) +
                    std::uint64_t(options.rays.per_step) * kMostSamples * kSample;
  return forecast;
}

}  // namespace

MemoryForecast forecast_memory(const TrainingSet& set, const TrainOptions& options) {
  const Articulation rest = set.views.empty() ? set.neutral : typical_articulation(set);
  const bool warps = mode_parts(options.fields.mode).warp && !set.views.empty();
  return forecast(set.views.size() + proxies_for(own_views(set).size(), options), std::uint64_t(set.size),
                  set.model, set.person, rest, warps, options);
}

MemoryForecast forecast_memory(std::size_t views, int size, const HeadModel& model,
                               const TrainOptions& options) {
  PersonShape person;
  person.identity = Eigen::VectorXf::Zero(model.identity_count());
  return forecast(views + proxies_for(views, options), std::uint64_t(size), model, person,
                  neutral_articulation(model), mode_parts(options.fields.mode).warp, options);
}

Result<void> check_memory(const MemoryForecast& forecast, std::uint64_t available) {
  if (forecast.total() <= available) return {};
  return Error{
      ErrorCode::failed,
      fmt::format("Training would take about {:.1f} GiB of memory ({:.1f} for the pictures, {:.1f} for the "
                  "face's motion), and {:.1f} GiB are free.",
                  gib(forecast.total()), gib(forecast.pictures), gib(forecast.lattices), gib(available)),
      "Close other programs, build with a smaller --size, or use a shorter clip.", "training"};
}

}  // namespace likeness
