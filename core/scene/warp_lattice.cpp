// Vertices are splatted onto the nodes near them; nodes further off take the mean of their neighbours, layer
// by layer, fading out.
#include "core/scene/warp_lattice.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/lending_pool.h"
#include "core/base/parallel.h"
#include "core/scene/splat.h"

namespace likeness {
namespace {

constexpr float kSoftness = 0.003f;      // m
constexpr float kReach = 0.012f;         // m around a vertex in which the field is its neighbours' mean
constexpr float kFadeEnd = 0.035f;       // m from the surface
constexpr float kStillVertex = 0.0003f;  // m; vertices that never move further are left out
constexpr float kAnchorSpacing = 0.02f;  // m around moving vertices in which still ones hold the field down

bool carries(HeadPart part) {
  // Sockets and eyeballs move against the skin in front of them: gaze is a condition, not a warp.
  return part == HeadPart::face || part == HeadPart::scalp_neck || part == HeadPart::teeth ||
         part == HeadPart::gums_tongue || part == HeadPart::unknown;
}

// Largest displacement of each vertex over the model's expressions and the jaw, m.
std::vector<float> reach_of_vertices(const HeadModel& model, const HeadShape& shape) {
  std::vector<float> reach(shape.vertices.size(), 0.f);
  for (Eigen::Index e = 0; e < model.expression_basis.cols(); ++e)
    for (std::size_t v = 0; v < reach.size(); ++v)
      reach[v] = std::max(reach[v], model.expression_basis.block<3, 1>(3 * Eigen::Index(v), e).norm());
  Articulation open = neutral_articulation(model);
  open.jaw.x() = 0.3f;
  const std::vector<Vec3f> opened = pose_head(model, shape, open);
  for (std::size_t v = 0; v < reach.size(); ++v)
    reach[v] = std::max(reach[v], (opened[v] - shape.vertices[v]).norm());
  return reach;
}

// Adds the largest displacement by the detail's components.
void add_reach(const ExpressionDetail& detail, std::vector<float>& reach) {
  if (detail.empty()) return;
  const Eigen::VectorXf most = detail.low.cwiseAbs().cwiseMax(detail.high.cwiseAbs());
  const Eigen::VectorXf moved = detail.basis.cwiseAbs() * most;
  for (std::size_t k = 0; k < detail.vertices.size(); ++k)
    reach[std::size_t(detail.vertices[k])] += moved[Eigen::Index(k)];
}

constexpr std::size_t kLayers = 4;  // of nodes along z, a thread's share

// The field at the nodes. Arrays of (z, y, row): a group of nodes may begin at any node of a row.
struct Nodes {
  std::size_t row = 0, plane = 0;
  std::vector<float> x, y, z, weight;  // m; first sums over the vertices and their weights, then their means
  std::vector<std::uint8_t> known;     // 0: no vertex is near, nor a known neighbour
};

void clear_nodes(const WarpFrame& frame, Nodes& nodes) {
  nodes.row = std::size_t(frame.nodes[0] + kSplatGroup - 1);
  nodes.plane = nodes.row * std::size_t(frame.nodes[1]);
  const std::size_t count = nodes.plane * std::size_t(frame.nodes[2]);
  for (std::vector<float>* array : {&nodes.x, &nodes.y, &nodes.z, &nodes.weight}) array->assign(count, 0.f);
  nodes.known.assign(count, 0);
}

LendingPool<Nodes>& nodes_pool() {
  static LendingPool<Nodes> pool;
  return pool;
}

std::vector<Pull> pulls_of(const WarpFrame& frame, std::span<const Vec3f> posed) {
  std::vector<Pull> pulls(frame.vertices.size());
  for (std::size_t k = 0; k < pulls.size(); ++k) {
    const Vec3f& p = posed[std::size_t(frame.vertices[k])];
    pulls[k] = {(p - frame.origin) / frame.cell, frame.rest[k] - p};
  }
  return pulls;
}

// Adds every vertex's displacement to the nodes of layers [z0, z1) within reach, and takes the means.
void splat(const WarpFrame& frame, std::span<const Pull> pulls, int z0, int z1, Nodes& nodes) {
  const SplatGrid grid{frame.nodes,         nodes.row,           nodes.plane,
                       nodes.x.data(),      nodes.y.data(),      nodes.z.data(),
                       nodes.weight.data(), kReach / frame.cell, kSoftness / frame.cell};
  splat_pulls(grid, pulls, z0, z1);
  for (std::size_t i = std::size_t(z0) * nodes.plane; i < std::size_t(z1) * nodes.plane; ++i) {
    if (!(nodes.weight[i] > 0)) continue;
    nodes.x[i] /= nodes.weight[i], nodes.y[i] /= nodes.weight[i], nodes.z[i] /= nodes.weight[i];
    nodes.known[i] = 1;
  }
}

struct Found {
  std::size_t node;
  Vec3f value;
};

// Which nodes of row (y, z) are unknown and have a known neighbour. edge: (nx)
void find_edge(const WarpFrame& frame, const Nodes& nodes, int y, int z, std::vector<std::uint8_t>& edge) {
  const auto [nx, ny, nz] = frame.nodes;
  const std::uint8_t* const own =
      nodes.known.data() + std::size_t(z) * nodes.plane + std::size_t(y) * nodes.row;
  // Beyond the lattice this row itself is used, whose known nodes are excluded anyway.
  const std::uint8_t* const below = y > 0 ? own - nodes.row : own;
  const std::uint8_t* const above = y + 1 < ny ? own + nodes.row : own;
  const std::uint8_t* const before = z > 0 ? own - nodes.plane : own;
  const std::uint8_t* const behind = z + 1 < nz ? own + nodes.plane : own;
  std::uint8_t* const out = edge.data();
  const int last = nx - 1;
  for (int x = 0; x < nx; ++x) out[x] = below[x] | above[x] | before[x] | behind[x];
  for (int x = 0; x < last; ++x) out[x] |= own[x + 1];
  for (int x = 1; x < nx; ++x) out[x] |= own[x - 1];
  for (int x = 0; x < nx; ++x) out[x] &= own[x] ^ 1;
}

// Unknown nodes of layers [z0, z1) that have known neighbours, with `keep` of their mean.
void neighbours_mean(const WarpFrame& frame, const Nodes& nodes, int z0, int z1, float keep,
                     std::vector<Found>& found) {
  const auto [nx, ny, nz] = frame.nodes;
  std::vector<std::uint8_t> edge(static_cast<std::size_t>(nx));
  for (int z = z0; z < z1; ++z)
    for (int y = 0; y < ny; ++y) {
      find_edge(frame, nodes, y, z, edge);
      for (int x = 0; x < nx; ++x) {
        if (!edge[std::size_t(x)]) continue;
        const std::size_t i = std::size_t(z) * nodes.plane + std::size_t(y) * nodes.row + std::size_t(x);
        Vec3f sum = Vec3f::Zero();
        int count = 0;
        const auto look = [&](bool inside, std::size_t j) {
          if (inside && nodes.known[j]) sum += Vec3f(nodes.x[j], nodes.y[j], nodes.z[j]), ++count;
        };
        look(x > 0, i - 1), look(x + 1 < nx, i + 1);
        look(y > 0, i - nodes.row), look(y + 1 < ny, i + nodes.row);
        look(z > 0, i - nodes.plane), look(z + 1 < nz, i + nodes.plane);
        found.push_back({i, sum * (keep / float(count))});
      }
    }
}

// body(z0, z1, index) over the threads' shares of the layers.
template <class Body>
void over_layers(int nz, const Body& body) {
  parallel_ranges(std::size_t(nz), kLayers,
                  [&](std::size_t begin, std::size_t end) { body(int(begin), int(end), begin / kLayers); });
}

// Nodes beyond the reach take the mean of known neighbours, one layer after another.
void spread(const WarpFrame& frame, Nodes& nodes) {
  const int layers = std::max(1, int(std::round((kFadeEnd - kReach) / frame.cell)));
  std::vector<std::vector<Found>> found((std::size_t(frame.nodes[2]) + kLayers - 1) / kLayers);
  for (int layer = 1; layer <= layers; ++layer) {
    const float keep = float(layers + 1 - layer) / float(layers + 2 - layer);  // linear fade over the layers
    over_layers(frame.nodes[2], [&](int z0, int z1, std::size_t share) {
      found[share].clear();
      neighbours_mean(frame, nodes, z0, z1, keep, found[share]);
    });
    for (const std::vector<Found>& list : found)
      for (const Found& f : list) {
        nodes.x[f.node] = f.value.x(), nodes.y[f.node] = f.value.y(), nodes.z[f.node] = f.value.z();
        nodes.known[f.node] = 1;
      }
  }
}

// A displacement in whole counts.
inline std::int16_t counts(float way, float per_unit) {
  return std::int16_t(way * per_unit + std::copysign(0.5f, way));
}

// Finds the first and last node of every column that is moved by a count or more. Those near still skin are
// known, but not moved.
void measure_columns(const Nodes& nodes, float per_unit, WarpLattice& lattice) {
  const auto nx = std::size_t(lattice.nodes[0]), ny = std::size_t(lattice.nodes[1]);
  const int nz = lattice.nodes[2];
  lattice.columns.assign(nx * ny, {});
  parallel_ranges(ny, kLayers, [&](std::size_t begin, std::size_t end) {
    for (int z = 0; z < nz; ++z)
      for (std::size_t c = begin * nx; c < end * nx; ++c) {
        const std::size_t i = std::size_t(z) * nodes.plane + c / nx * nodes.row + c % nx;
        const float most = std::max({std::abs(nodes.x[i]), std::abs(nodes.y[i]), std::abs(nodes.z[i])});
        if (!nodes.known[i] || counts(most, per_unit) == 0) continue;
        WarpLattice::Column& column = lattice.columns[c];
        if (column.stored == 0) column.first = std::int16_t(z);
        column.stored = std::int16_t(z + 1 - column.first);
      }
  });
}

// Whole counts of the largest displacement's 32767th part; nodes not known are zero.
void store(const Nodes& nodes, WarpLattice& lattice) {
  float largest = 1e-6f;
  for (std::size_t i = 0; i < nodes.known.size(); ++i)
    if (nodes.known[i])
      largest = std::max({largest, std::abs(nodes.x[i]), std::abs(nodes.y[i]), std::abs(nodes.z[i])});
  lattice.unit = largest / 32767;
  const float per_unit = 1 / lattice.unit;

  measure_columns(nodes, per_unit, lattice);
  std::int32_t rows = 2;
  for (WarpLattice::Column& column : lattice.columns) {
    column.base = rows - column.first;
    if (column.stored > 0) rows += column.stored + 1;
  }
  lattice.displacement.assign(3 * std::size_t(rows), 0);
  const auto nx = std::size_t(lattice.nodes[0]);
  parallel_ranges(std::size_t(lattice.nodes[1]), kLayers, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin * nx; c < end * nx; ++c) {
      const WarpLattice::Column& column = lattice.columns[c];
      std::int16_t* to = lattice.displacement.data() + 3 * (column.base + column.first);
      for (int z = column.first; z < column.first + column.stored; ++z, to += 3) {
        const std::size_t i = std::size_t(z) * nodes.plane + c / nx * nodes.row + c % nx;
        if (!nodes.known[i]) continue;
        to[0] = counts(nodes.x[i], per_unit);
        to[1] = counts(nodes.y[i], per_unit);
        to[2] = counts(nodes.z[i], per_unit);
      }
    }
  });
}

// How many nodes span a box, m; an Error where they are too many.
Result<std::array<int, 3>> spanning_nodes(const Vec3f& low, const Vec3f& high, float cell) {
  std::array<int, 3> nodes{};
  double count = 1;
  const Vec3f cells = (high - low) / cell;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(cells[axis] >= 0 && cells[axis] < float(kMostWarpNodesAlong - 1))) count = HUGE_VAL;
    if (count > kMostWarpNodes) break;
    nodes[std::size_t(axis)] = int(std::ceil(cells[axis])) + 1;
    count *= nodes[std::size_t(axis)];
  }
  if (count <= kMostWarpNodes) return nodes;
  const Vec3f extent = high - low;
  return Error{
      ErrorCode::bad_input,
      fmt::format("The moving part of this head is {:.3g} x {:.3g} x {:.3g} m, too much for a lattice "
                  "with a node every {:.3g} mm.",
                  extent.x(), extent.y(), extent.z(), 1000 * cell),
      "Its file is damaged: restore it from a backup, or build the project again.", ""};
}

}  // namespace

Result<WarpFrame> make_warp_frame(const HeadModel& model, const HeadShape& shape, const Articulation& rest,
                                  float cell, const ExpressionDetail* detail) {
  LIKENESS_CHECK(cell > 1e-4f, "warp lattice with cells of %g m", double(cell));
  WarpFrame frame;
  frame.cell = cell;
  const ExpressionDetail none;
  if (detail == nullptr) detail = &none;
  std::vector<float> reach = reach_of_vertices(model, shape);
  add_reach(*detail, reach);
  const std::vector<Vec3f> posed = pose_detailed_head(model, shape, rest, *detail);
  Vec3f low = Vec3f::Constant(1e9f), high = -low;
  std::vector<std::size_t> still;
  for (std::size_t v = 0; v < reach.size(); ++v) {
    if (!model.parts.empty() && !carries(model.parts[v])) continue;
    if (reach[v] < kStillVertex) {
      still.push_back(v);
      continue;
    }
    frame.vertices.push_back(int(v));
    low = low.cwiseMin(posed[v]), high = high.cwiseMax(posed[v]);
  }
  if (frame.vertices.empty()) return frame;
  // Still skin beside moving skin makes the field end there.
  for (const std::size_t v : still)
    if (((posed[v] - low).array() > -kAnchorSpacing).all() &&
        ((high - posed[v]).array() > -kAnchorSpacing).all())
      frame.vertices.push_back(int(v));
  for (const int v : frame.vertices) frame.rest.push_back(posed[std::size_t(v)]);
  frame.mouth = make_mouth_frame(model, shape, posed);
  // Margin for the widest jaw, and for the fading.
  low.array() -= kFadeEnd, high.array() += kFadeEnd;
  low.y() -= 0.02f;
  frame.origin = low;
  const auto nodes = spanning_nodes(low, high, cell);
  if (!nodes) return nodes.error();
  frame.nodes = *nodes;
  return frame;
}

WarpLattice make_warp_lattice(const WarpFrame& frame, std::span<const Vec3f> posed) {
  WarpLattice lattice{frame.origin, frame.cell, frame.nodes, 0, {}, {}, {}};
  if (frame.vertices.empty()) return lattice;
  lattice.mouth = make_mouth_gap(frame.mouth, posed);
  std::unique_ptr<Nodes> lent = nodes_pool().take();
  Nodes& nodes = *lent;
  clear_nodes(frame, nodes);
  const std::vector<Pull> pulls = pulls_of(frame, posed);
  over_layers(frame.nodes[2], [&](int z0, int z1, std::size_t) { splat(frame, pulls, z0, z1, nodes); });
  spread(frame, nodes);
  store(nodes, lattice);
  nodes_pool().give(std::move(lent));
  return lattice;
}

Vec3f displacement_at(const WarpLattice& lattice, const Vec3f& point) {
  if (lattice.empty()) return Vec3f::Zero();
  if (in_gap(lattice.mouth, point)) return way_to_pocket(lattice.mouth, point);
  const Vec3f p = (point - lattice.origin) / lattice.cell;
  const int x = int(std::floor(p.x())), y = int(std::floor(p.y())), z = int(std::floor(p.z()));
  const auto [nx, ny, nz] = lattice.nodes;
  if (x < 0 || y < 0 || z < 0 || x + 1 >= nx || y + 1 >= ny || z + 1 >= nz) return Vec3f::Zero();
  const float u = p.x() - float(x), v = p.y() - float(y), w = p.z() - float(z);
  const std::int16_t* rows = lattice.displacement.data();
  const auto nodes_at = [&](const WarpLattice::Column& column) {
    const bool kept = unsigned(z + 1 - column.first) <= unsigned(column.stored);
    return rows + (kept ? 3 * std::ptrdiff_t(column.base + z) : 0);
  };
  const WarpLattice::Column* column = &lattice.columns[std::size_t(y) * std::size_t(nx) + std::size_t(x)];
  const std::array<const std::int16_t*, 4> at{nodes_at(column[0]), nodes_at(column[1]), nodes_at(column[nx]),
                                              nodes_at(column[nx + 1])};
  Vec3f sum = Vec3f::Zero();
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const float weight = (corner & 1 ? u : 1 - u) * (corner & 2 ? v : 1 - v) * (corner & 4 ? w : 1 - w);
    const std::int16_t* d = at[corner & 3] + (corner & 4 ? 3 : 0);
    sum += weight * Vec3f(d[0], d[1], d[2]);
  }
  return sum * lattice.unit;
}

}  // namespace likeness
