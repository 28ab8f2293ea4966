// Heights from the tracked head to the true one, drawn as maps: see true_detail.h.
#include "core/lab/truth/true_detail.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/align_points.h"
#include "core/base/files.h"
#include "core/base/parallel.h"
#include "core/head/expression_detail.h"
#include "core/head/texture_corners.h"
#include "core/lab/truth/track_truth.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/scene/head_regions.h"
#include "core/synth/cast.h"
#include "core/synth/personal_shape.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr float kMaxHeight = 0.999f * kHighestDetail;  // m; rounding must not take a map over the limit

// NumPy's own format, version 1.0.
std::string npy_of(const std::vector<float>& values, int side) {
  std::string header =
      fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}", side, side);
  while ((header.size() + 11) % 64 != 0) header += ' ';
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += char(header.size() & 255), bytes += char(header.size() >> 8);
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  return bytes;
}

// Heights of the vertices drawn into their triangles' texels. (side, side), row 0 at the top.
std::vector<float> draw_map(const HeadModel& model, const TextureCorners& corners,
                            const std::vector<std::uint8_t>& skin, const Eigen::VectorXf& height, int side) {
  std::vector<float> map(std::size_t(side) * std::size_t(side), 0.f);
  for (std::size_t f = 0; f < corners.size(); ++f) {
    if (!skin[f]) continue;
    Vec2f at[3];
    for (int c = 0; c < 3; ++c)
      at[c] = {corners[f][std::size_t(c)].x() * float(side),
               (1 - corners[f][std::size_t(c)].y()) * float(side)};
    const Vec2f a = at[1] - at[0], b = at[2] - at[0];
    const float area = a.x() * b.y() - a.y() * b.x();
    if (std::abs(area) < 1e-12f) continue;
    const Vec2f low = at[0].cwiseMin(at[1]).cwiseMin(at[2]), high = at[0].cwiseMax(at[1]).cwiseMax(at[2]);
    for (int y = std::max(0, int(low.y())); y < std::min(side, int(high.y()) + 1); ++y)
      for (int x = std::max(0, int(low.x())); x < std::min(side, int(high.x()) + 1); ++x) {
        const Vec2f p = Vec2f(float(x) + 0.5f, float(y) + 0.5f) - at[0];
        const float v = (p.x() * b.y() - p.y() * b.x()) / area, w = (a.x() * p.y() - a.y() * p.x()) / area;
        if (v < 0 || w < 0 || v + w > 1) continue;
        const Triangle& t = model.triangles[f];
        map[std::size_t(y) * std::size_t(side) + std::size_t(x)] =
            (1 - v - w) * height[t[0]] + v * height[t[1]] + w * height[t[2]];
      }
  }
  return map;
}

// Similarity that maps these vertices of one head to the other's, least squares (Umeyama, TPAMI 1991). From
// the faces themselves: cameras of an unknown focal length do not fix the scale.
Eigen::Matrix4f similarity(const std::vector<Vec3f>& from, const std::vector<Vec3f>& to,
                           const std::vector<int>& vertices) {
  Eigen::Matrix3Xd a(3, Eigen::Index(vertices.size())), b = a;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    a.col(Eigen::Index(k)) = from[std::size_t(vertices[k])].cast<double>();
    b.col(Eigen::Index(k)) = to[std::size_t(vertices[k])].cast<double>();
  }
  return similarity_between(a, b).cast<float>();
}

}  // namespace

Result<TrueDetailReport> write_true_detail(const Project& project, const fs::path& demo, const fs::path& out,
                                           const TrueDetailOptions& options, const Progress& progress,
                                           std::stop_token stop) {
  const auto read = read_tracked_capture(project);
  if (!read) return read.error();
  const auto model = project_head_model(project.options);
  if (!model) return model.error();
  if (const auto fits = check_track_fits(read->track, *model); !fits) return fits.error();
  if (model->uvs.empty())
    return Error{ErrorCode::bad_input, fmt::format("The {} head has no texture coordinates.", model->name),
                 "Fit the demo with the built-in head.", project.folder.string()};
  const auto truth = read_track_truth(demo);
  if (!truth) return truth.error();
  if (truth->model.hash != model->hash)
    return Error{ErrorCode::bad_input, "The demo and the project are of different head models.",
                 "Fit the demo with the built-in head.", project.folder.string()};
  if (const auto made = make_writable_folder(out); !made) return made.error();

  const HeadShape shape = shape_head(*model, read->track.person),
                  true_shape = shape_head(truth->model, truth->track.person);
  const PersonalPlay play(truth->model, true_shape, demo_person(options.person));
  const HeadRegions regions = head_regions(*model);
  std::vector<std::uint8_t> face_skin(model->triangles.size());
  for (std::size_t f = 0; f < face_skin.size(); ++f) face_skin[f] = regions.face[f] && regions.skin[f];
  const std::vector<int> vertices = region_vertices(*model, face_skin);
  const Eigen::Matrix4f to_truth = similarity(shape.vertices, true_shape.vertices, vertices);
  const Eigen::Matrix3f turned = to_truth.topLeftCorner<3, 3>();
  const Vec3f shift = to_truth.topRightCorner<3, 1>();
  const float scale = turned.col(0).norm();
  const TextureCorners corners = own_corners(*model);

  TrueDetailReport report;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(Eigen::Index(vertices.size()));
  double squares = 0;
  for (std::size_t i = 0; i < read->track.frames.size(); ++i) {
    if (stop.stop_requested()) return cancelled_error();
    const TrackedFrame& frame = read->track.frames[i];
    const TrackedFrame* played = find_tracked(truth->track, frame.frame);
    if (frame.status == FrameStatus::lost || played == nullptr) continue;
    progress.report(double(i) / double(read->track.frames.size()), fmt::format("frame {}", frame.frame));
    const std::vector<Vec3f> there = play.pose(played->pose.articulation),
                             posed = pose_head(*model, shape, frame.pose.articulation),
                             normals = vertex_normals(posed, model->triangles);
    Eigen::VectorXf height = Eigen::VectorXf::Zero(model->vertex_count());
    parallel_ranges(vertices.size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const auto v = std::size_t(vertices[k]);
        const Vec3f at = turned * posed[v] + shift, out_of = (turned * normals[v]).normalized();
        // The two heads share their topology: there[v] is the true place of the same skin.
        height[Eigen::Index(v)] = std::clamp(out_of.dot(there[v] - at) / scale, -kMaxHeight, kMaxHeight);
      }
    });
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const double h = double(height[vertices[k]]);
      sum[Eigen::Index(k)] += h, squares += h * h;
    }
    ++report.frames;
    std::vector<float> map = draw_map(*model, corners, face_skin, height, options.side);
    for (float& value : map) value *= 1000;
    if (const auto written =
            write_text(out / fmt::format("{:06}.npy", frame.frame), npy_of(map, options.side));
        !written)
      return written.error();
  }
  if (report.frames == 0)
    return Error{ErrorCode::failed, "No tracked frame is one of the demo's.",
                 "Fit the project to the demo's own clip, demo.mp4.", project.folder.string()};
  const double n = double(report.frames) * double(vertices.size());
  report.rms_mm = 1000 * std::sqrt(squares / n);
  report.varying_mm =
      1000 * std::sqrt(std::max(0.0, (squares - sum.squaredNorm() / double(report.frames)) / n));
  progress.report(1);
  return report;
}

}  // namespace likeness
