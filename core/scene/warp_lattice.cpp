// Vertices are splatted onto the nodes near them; what lies further off takes the mean of its neighbours,
// layer by layer, and fades.
#include "core/scene/warp_lattice.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace likeness {
namespace {

constexpr float kSoftness = 0.003f;      // m
constexpr float kReach = 0.012f;         // m around a vertex in which the field is its neighbours' mean
constexpr float kFadeEnd = 0.035f;       // m from the surface
constexpr float kStillVertex = 0.0003f;  // m; a vertex that never moves further pulls nothing
constexpr float kAnchorSpacing = 0.02f;  // m around moving vertices in which still ones hold the field down

bool carries(HeadPart part) {
  // Sockets and eyeballs move against the skin in front of them: gaze is a condition, not a warp.
  return part == HeadPart::face || part == HeadPart::scalp_neck || part == HeadPart::teeth ||
         part == HeadPart::gums_tongue || part == HeadPart::unknown;
}

// Largest way of each vertex over the model's expressions and the jaw, m.
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

struct Nodes {
  std::vector<Vec3f> sum;
  std::vector<float> weight;
};

// Adds every vertex's displacement to the nodes within reach.
Nodes splat(const WarpFrame& frame, std::span<const Vec3f> posed) {
  const auto [nx, ny, nz] = frame.nodes;
  Nodes nodes;
  nodes.sum.assign(std::size_t(nx) * ny * nz, Vec3f::Zero());
  nodes.weight.assign(nodes.sum.size(), 0.f);
  const float reach2 = kReach * kReach, soft2 = kSoftness * kSoftness;
  const float r = kReach / frame.cell;
  for (std::size_t k = 0; k < frame.vertices.size(); ++k) {
    const Vec3f& p = posed[std::size_t(frame.vertices[k])];
    const Vec3f way = frame.rest[k] - p;
    const Vec3f c = (p - frame.origin) / frame.cell;
    const auto first = [&](int axis) { return std::max(0, int(std::ceil(c[axis] - r))); };
    const auto last = [&](int axis) {
      return std::min(frame.nodes[std::size_t(axis)] - 1, int(std::floor(c[axis] + r)));
    };
    const int x0 = first(0), x1 = last(0);
    for (int z = first(2); z <= last(2); ++z)
      for (int y = first(1); y <= last(1); ++y) {
        const float dy = (float(y) - c.y()) * frame.cell, dz = (float(z) - c.z()) * frame.cell;
        const float d0 = dy * dy + dz * dz;
        if (d0 >= reach2) continue;
        const std::size_t row = (std::size_t(z) * ny + y) * nx;
        for (int x = x0; x <= x1; ++x) {
          const float dx = (float(x) - c.x()) * frame.cell, d = d0 + dx * dx;
          if (d >= reach2) continue;
          const float near = 1 / (d + soft2), end = 1 - d / reach2;
          const float w = near * near * end * end;
          nodes.sum[row + x] += w * way;
          nodes.weight[row + x] += w;
        }
      }
  }
  for (std::size_t i = 0; i < nodes.sum.size(); ++i)
    if (nodes.weight[i] > 0) nodes.sum[i] /= nodes.weight[i];
  return nodes;
}

// Nodes beyond the reach take the mean of known neighbours, one layer after another.
void spread(const WarpFrame& frame, Nodes& nodes) {
  const auto [nx, ny, nz] = frame.nodes;
  const int layers = std::max(1, int(std::round((kFadeEnd - kReach) / frame.cell)));
  std::vector<std::size_t> next;
  std::vector<Vec3f> value;
  for (int layer = 1; layer <= layers; ++layer) {
    next.clear(), value.clear();
    const float keep = float(layers + 1 - layer) / float(layers + 2 - layer);  // linear fade over the layers
    for (int z = 0; z < nz; ++z)
      for (int y = 0; y < ny; ++y)
        for (int x = 0; x < nx; ++x) {
          const std::size_t i = (std::size_t(z) * ny + y) * nx + x;
          if (nodes.weight[i] > 0) continue;
          Vec3f sum = Vec3f::Zero();
          int count = 0;
          const auto look = [&](bool inside, std::size_t j) {
            if (inside && nodes.weight[j] > 0) sum += nodes.sum[j], ++count;
          };
          look(x > 0, i - 1), look(x + 1 < nx, i + 1);
          look(y > 0, i - nx), look(y + 1 < ny, i + nx);
          look(z > 0, i - std::size_t(nx) * ny), look(z + 1 < nz, i + std::size_t(nx) * ny);
          if (count == 0) continue;
          next.push_back(i);
          value.push_back(sum * (keep / float(count)));
        }
    for (std::size_t k = 0; k < next.size(); ++k) {
      nodes.sum[next[k]] = value[k];
      nodes.weight[next[k]] = 1;
    }
  }
}

}  // namespace

WarpFrame make_warp_frame(const HeadModel& model, const HeadShape& shape, const Articulation& rest,
                          float cell) {
  LIKENESS_CHECK(cell > 1e-4f, "warp lattice with cells of %g m", double(cell));
  WarpFrame frame;
  frame.cell = cell;
  const std::vector<float> reach = reach_of_vertices(model, shape);
  const std::vector<Vec3f> posed = pose_head(model, shape, rest);
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
  // Still skin beside moving skin says that the field ends there.
  for (const std::size_t v : still)
    if (((posed[v] - low).array() > -kAnchorSpacing).all() &&
        ((high - posed[v]).array() > -kAnchorSpacing).all())
      frame.vertices.push_back(int(v));
  for (const int v : frame.vertices) frame.rest.push_back(posed[std::size_t(v)]);
  frame.mouth = make_mouth_frame(model, shape, posed);
  // Room for the widest jaw, and for the fading.
  low.array() -= kFadeEnd, high.array() += kFadeEnd;
  low.y() -= 0.02f;
  frame.origin = low;
  for (int axis = 0; axis < 3; ++axis)
    frame.nodes[std::size_t(axis)] = int(std::ceil((high[axis] - low[axis]) / cell)) + 1;
  return frame;
}

WarpLattice make_warp_lattice(const WarpFrame& frame, std::span<const Vec3f> posed) {
  WarpLattice lattice{frame.origin, frame.cell, frame.nodes, 0, {}, {}};
  if (frame.vertices.empty()) return lattice;
  lattice.mouth = make_mouth_gap(frame.mouth, posed);
  Nodes nodes = splat(frame, posed);
  spread(frame, nodes);
  float largest = 0;
  for (std::size_t i = 0; i < nodes.sum.size(); ++i)
    if (nodes.weight[i] > 0) largest = std::max(largest, nodes.sum[i].cwiseAbs().maxCoeff());
  lattice.unit = std::max(largest, 1e-6f) / 32767;
  lattice.displacement.resize(3 * nodes.sum.size());
  for (std::size_t i = 0; i < nodes.sum.size(); ++i)
    for (int c = 0; c < 3; ++c)
      lattice.displacement[3 * i + std::size_t(c)] =
          nodes.weight[i] > 0 ? std::int16_t(std::lround(nodes.sum[i][c] / lattice.unit)) : std::int16_t(0);
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
  const std::int16_t* d = lattice.displacement.data() + 3 * ((std::size_t(z) * ny + y) * nx + x);
  const std::size_t up = 3 * std::size_t(nx), back = up * std::size_t(ny);
  Vec3f sum = Vec3f::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const float weight = (corner & 1 ? u : 1 - u) * (corner & 2 ? v : 1 - v) * (corner & 4 ? w : 1 - w);
    const std::int16_t* at = d + (corner & 1 ? 3 : 0) + (corner & 2 ? up : 0) + (corner & 4 ? back : 0);
    sum += weight * Vec3f(at[0], at[1], at[2]);
  }
  return sum * lattice.unit;
}

}  // namespace likeness
