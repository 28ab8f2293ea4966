// Solid cells are joined across small gaps; what is not joined to the most of them is dropped.
#include "core/train/loose_cells.h"

#include <algorithm>
#include <vector>

namespace likeness {
namespace {

constexpr int kGap = 2, kBeside = 2;  // cells: between two pieces that are one; of soft hair about the solid
constexpr double kLarge = 0.1;        // of the largest piece: another as large is the person, too
constexpr double kMostStays = 0.8;    // of the opacity, summed over the cells

class Cells {
 public:
  explicit Cells(int resolution) : n_(resolution) {}
  std::size_t count() const { return std::size_t(n_) * std::size_t(n_) * std::size_t(n_); }
  // Those up to `reach` away along each axis.
  template <typename Visit>
  void around(std::size_t cell, int reach, const Visit& visit) const {
    const int n = n_, x = int(cell) % n, y = int(cell) / n % n, z = int(cell) / (n * n);
    for (int w = std::max(0, z - reach); w <= std::min(n - 1, z + reach); ++w)
      for (int v = std::max(0, y - reach); v <= std::min(n - 1, y + reach); ++v)
        for (int u = std::max(0, x - reach); u <= std::min(n - 1, x + reach); ++u)
          visit((std::size_t(w) * std::size_t(n) + std::size_t(v)) * std::size_t(n) + std::size_t(u));
  }

 private:
  int n_;
};

// The piece of each cell, from 1 on; 0: not solid. sizes: of the pieces, from 1 on.
std::vector<int> find_pieces(const Cells& cells, const std::vector<std::uint8_t>& solid,
                             std::vector<std::size_t>& sizes) {
  std::vector<int> piece(cells.count(), 0);
  std::vector<std::size_t> open;
  sizes.assign(1, 0);
  for (std::size_t first = 0; first < cells.count(); ++first) {
    if (!solid[first] || piece[first] != 0) continue;
    const int own = int(sizes.size());
    sizes.push_back(0);
    piece[first] = own, open.assign(1, first);
    while (!open.empty()) {
      const std::size_t cell = open.back();
      open.pop_back(), ++sizes.back();
      cells.around(cell, kGap, [&](std::size_t other) {
        if (solid[other] && piece[other] == 0) piece[other] = own, open.push_back(other);
      });
    }
  }
  return piece;
}

}  // namespace

std::size_t drop_loose_cells(FieldPart& part, int solid_from) {
  const Cells cells(part.occupancy.resolution);
  if (part.opacity.size() != cells.count()) return 0;
  const auto occupied = [&](std::size_t cell) { return part.occupancy.bits[cell >> 3] >> (cell & 7) & 1; };
  std::vector<std::uint8_t> solid(cells.count());
  for (std::size_t i = 0; i < solid.size(); ++i) solid[i] = occupied(i) && part.opacity[i] >= solid_from;
  std::vector<std::size_t> sizes;
  const std::vector<int> piece = find_pieces(cells, solid, sizes);
  const std::size_t largest = *std::ranges::max_element(sizes);
  if (largest == 0) return 0;
  std::vector<std::uint8_t> stays(cells.count(), 0);
  for (std::size_t i = 0; i < piece.size(); ++i)
    if (piece[i] != 0 && double(sizes[std::size_t(piece[i])]) >= kLarge * double(largest))
      cells.around(i, kBeside, [&](std::size_t other) { stays[other] = 1; });
  double all = 0, kept = 0;
  for (std::size_t i = 0; i < stays.size(); ++i)
    if (occupied(i)) all += part.opacity[i], kept += stays[i] ? part.opacity[i] : 0;
  if (kept < kMostStays * all) return 0;
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < stays.size(); ++i) {
    if (stays[i] || !occupied(i)) continue;
    part.occupancy.bits[i >> 3] = std::uint8_t(part.occupancy.bits[i >> 3] & ~(1u << (i & 7)));
    part.opacity[i] = 0, ++dropped;
  }
  return dropped;
}

}  // namespace likeness
