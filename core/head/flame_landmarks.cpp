// FLAME's landmark embeddings: see flame_landmarks.h.
#include "core/head/flame_landmarks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/base/npz.h"
#include "core/head/pickle.h"
#include "core/head/pickle_arrays.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kInnerCount = kLandmarkCount - kContourCount;  // 51
constexpr std::size_t kMaxRows = 361;                        // one per degree, all round

Error bad_embedding(const std::string& where, const std::string& what) {
  return {ErrorCode::bad_input, "The landmark embedding cannot be used: " + what,
          "Get a fresh copy of landmark_embedding.npy, or of flame_static_embedding.pkl with "
          "flame_dynamic_embedding.npy.",
          where};
}

// One pair of keys: triangle indices (...), barycentric coordinates (..., 3).
Result<std::vector<SurfacePoint>> read_points(const PickleDocument& document, PickleRef dict,
                                              const char* index_key, const char* weight_key,
                                              const std::string& where) {
  const PickleRef *index_ref = find_key(document, dict, index_key),
                  *weight_ref = find_key(document, dict, weight_key);
  std::vector<SurfacePoint> points;
  if (!index_ref || !weight_ref) return points;
  const auto indices = pickle_array(document, *index_ref), weights = pickle_array(document, *weight_ref);
  if (!indices) return bad_embedding(where, fmt::format("{}: {}", index_key, indices.error().what));
  if (!weights) return bad_embedding(where, fmt::format("{}: {}", weight_key, weights.error().what));
  // Some writers keep the indices as floating-point numbers.
  const std::vector<float> index = indices->as_float(), weight = weights->as_float();
  if (weight.size() != 3 * index.size() || index.size() > kMaxRows * kContourCount)
    return bad_embedding(where, fmt::format("{} has {} numbers and {} has {}.", index_key, index.size(),
                                            weight_key, weight.size()));
  for (std::size_t i = 0; i < index.size(); ++i) {
    const Vec3f w(weight[3 * i], weight[3 * i + 1], weight[3 * i + 2]);
    if (!(index[i] >= 0 && index[i] < 1e7f) || !w.allFinite() || std::abs(w.sum() - 1) > 1e-2f ||
        w.minCoeff() < -0.5f)
      return bad_embedding(where, fmt::format("entry {} of {} is not a point of a triangle.", i, index_key));
    points.push_back({int(index[i]), w / w.sum()});
  }
  return points;
}

std::vector<ContourRow> as_rows(const std::vector<SurfacePoint>& points) {
  std::vector<ContourRow> rows(points.size() / kContourCount);
  for (std::size_t i = 0; i < rows.size() * kContourCount; ++i)
    rows[i / kContourCount][i % kContourCount] = points[i];
  return rows;
}

// File order 0, 1 .. L, -1 .. -L to -L .. L.
DynamicContour by_yaw(const std::vector<ContourRow>& rows) {
  const std::size_t limit = (rows.size() - 1) / 2;
  DynamicContour contour;
  contour.rows.resize(2 * limit + 1);
  for (std::size_t degree = 0; degree <= limit; ++degree) {
    contour.rows[limit + degree] = rows[degree];
    if (degree > 0) contour.rows[limit - degree] = rows[limit + degree];
  }
  return contour;
}

Vec3f position(const HeadModel& model, const SurfacePoint& point) {
  const Triangle& t = model.triangles[std::size_t(point.triangle)];
  return point.barycentric[0] * model.vertices[std::size_t(t[0])] +
         point.barycentric[1] * model.vertices[std::size_t(t[1])] +
         point.barycentric[2] * model.vertices[std::size_t(t[2])];
}

using Names = std::vector<const char*>;
const Names kTogether{"landmark_embedding.npy", "landmark_embedding.pkl"};
const Names kFixed{"flame_static_embedding.pkl", "flame_static_embedding_68.pkl"};
const Names kTable{"flame_dynamic_embedding.npy"};

std::vector<fs::path> folders_of(const fs::path& model_file) {
  const fs::path beside = model_file.has_parent_path() ? model_file.parent_path() : fs::path(".");
  return {beside, beside / ".."};
}

// The first of the candidates that exists, parsed; nullopt if none exists.
Result<std::optional<LandmarkEmbedding>> first_present(const std::vector<fs::path>& folders,
                                                       const Names& names) {
  for (const fs::path& folder : folders)
    for (const char* name : names) {
      const fs::path file = folder / name;
      std::error_code ignored;
      if (!fs::is_regular_file(file, ignored)) continue;
      const auto bytes = read_file(file);
      if (!bytes) return bytes.error();
      auto embedding = parse_landmark_embedding(*bytes, file.string());
      if (!embedding) return embedding.error();
      return std::optional<LandmarkEmbedding>(std::move(*embedding));
    }
  return std::optional<LandmarkEmbedding>();
}

Error missing(const fs::path& model_file, const char* name) {
  const fs::path folder = model_file.has_parent_path() ? model_file.parent_path() : ".";
  return {
      ErrorCode::not_found,
      fmt::format("FLAME's model file does not say where the landmarks are, and {} is not beside it.", name),
      fmt::format("Put landmark_embedding.npy (it comes with DECA), or flame_static_embedding.pkl and "
                  "flame_dynamic_embedding.npy (they come with RingNet and FLAME_PyTorch), into {}. Their "
                  "licence does not allow Likeness to include them.",
                  folder.string()),
      model_file.string()};
}

}  // namespace

const ContourRow& contour_at(const DynamicContour& contour, double yaw) {
  LIKENESS_CHECK(!contour.rows.empty(), "a contour table without rows");
  const double degree = std::clamp(yaw * 180 / std::numbers::pi, -720.0, 720.0);
  const int limit = contour.limit_deg();
  return contour.rows[std::size_t(std::clamp(int(std::lround(degree)), -limit, limit) + limit)];
}

Result<LandmarkEmbedding> parse_landmark_embedding(std::span<const std::byte> file,
                                                   const std::string& where) {
  NpyArray array;
  std::span<const std::byte> pickle = file;
  const bool is_npy = file.size() > 1 && file[0] == std::byte(0x93);
  if (is_npy) {
    auto parsed = parse_npy(file, where);
    if (!parsed) return parsed.error();
    if (parsed->kind != 'O' || parsed->count() != 1)
      return bad_embedding(where, "it is an array of numbers, not a dictionary.");
    array = std::move(*parsed);
    pickle = array.data;
  }
  const auto document = read_pickle(pickle, where);
  if (!document) return document.error();
  PickleRef dict = document->root;
  if (is_npy) {
    const auto elements = pickle_elements(*document, document->root);
    if (!elements || elements->size() != 1) return bad_embedding(where, "it holds no dictionary.");
    dict = elements->front();
  }
  if (document->node(dict).kind != PickleKind::dict) return bad_embedding(where, "it holds no dictionary.");

  LandmarkEmbedding embedding;
  for (const auto& [index, weight] :
       {std::pair{"static_lmk_faces_idx", "static_lmk_bary_coords"},
        std::pair{"dynamic_lmk_faces_idx", "dynamic_lmk_bary_coords"},
        std::pair{"full_lmk_faces_idx", "full_lmk_bary_coords"}, std::pair{"lmk_face_idx", "lmk_b_coords"}}) {
    const auto points = read_points(*document, dict, index, weight, where);
    if (!points) return points.error();
    if (points->empty()) continue;
    if (index[0] == 's')
      embedding.fixed = *points;
    else if (index[0] == 'f')
      embedding.all = *points;
    else if (index[0] == 'd' || (points->size() % kContourCount == 0 && points->size() > kLandmarkCount))
      embedding.rows = as_rows(*points);
    else
      (points->size() == kLandmarkCount ? embedding.all : embedding.fixed) = *points;
  }
  if (!embedding.fixed.empty() && int(embedding.fixed.size()) != kInnerCount)
    return bad_embedding(where, fmt::format("it has {} fixed landmarks where {} are expected.",
                                            embedding.fixed.size(), kInnerCount));
  if (!embedding.all.empty() && int(embedding.all.size()) != kLandmarkCount)
    return bad_embedding(where, fmt::format("it has {} landmarks where {} are expected.",
                                            embedding.all.size(), kLandmarkCount));
  if (!embedding.rows.empty() && embedding.rows.size() % 2 == 0)
    return bad_embedding(where, fmt::format("its contour table has {} rows where an odd number is expected.",
                                            embedding.rows.size()));
  if (embedding.fixed.empty() && embedding.all.empty() && embedding.rows.empty())
    return bad_embedding(where, "it has none of the keys of a landmark embedding.");
  return embedding;
}

Result<FlameLandmarks> read_flame_landmarks(const fs::path& model_file) {
  const std::vector<fs::path> folders = folders_of(model_file);
  auto together = first_present(folders, kTogether);
  if (!together) return together.error();
  LandmarkEmbedding embedding;
  if (*together) embedding = std::move(**together);
  if (embedding.fixed.empty() && embedding.all.empty()) {
    auto fixed = first_present(folders, kFixed);
    if (!fixed) return fixed.error();
    if (!*fixed) return missing(model_file, "landmark_embedding.npy");
    embedding.fixed = std::move((*fixed)->fixed);
    embedding.all = std::move((*fixed)->all);
  }
  if (embedding.rows.empty()) {
    auto table = first_present(folders, kTable);
    if (!table) return table.error();
    if (*table) embedding.rows = std::move((*table)->rows);
  }
  if (embedding.all.empty() && embedding.rows.empty())
    return missing(model_file, "flame_dynamic_embedding.npy");

  FlameLandmarks landmarks;
  if (!embedding.all.empty()) std::copy(embedding.all.begin(), embedding.all.end(), landmarks.points.begin());
  if (!embedding.fixed.empty())
    std::copy(embedding.fixed.begin(), embedding.fixed.end(), landmarks.points.begin() + kContourCount);
  if (!embedding.rows.empty()) {
    landmarks.contour = by_yaw(embedding.rows);
    const ContourRow& frontal = contour_at(*landmarks.contour, 0);
    std::copy(frontal.begin(), frontal.end(), landmarks.points.begin());
  }
  return landmarks;
}

std::vector<fs::path> landmark_files_beside(const fs::path& model_file) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const fs::path& folder : folders_of(model_file))
    for (const Names* names : {&kTogether, &kFixed, &kTable})
      for (const char* name : *names)
        if (fs::is_regular_file(folder / name, ignored)) files.push_back(folder / name);
  return files;
}

Result<void> attach_landmarks(const FlameLandmarks& landmarks, const std::string& where, HeadModel& model) {
  const auto fits = [&](const SurfacePoint& point) {
    return std::size_t(point.triangle) < model.triangles.size();
  };
  bool good = std::all_of(landmarks.points.begin(), landmarks.points.end(), fits);
  if (landmarks.contour)
    for (const ContourRow& row : landmarks.contour->rows)
      good = good && std::all_of(row.begin(), row.end(), fits);
  if (!good)
    return bad_embedding(
        where, fmt::format("it refers to a triangle beyond the model's {}.", model.triangles.size()));
  for (std::size_t l = 0; l < landmarks.points.size(); ++l) {
    model.landmark_triangle[l] = landmarks.points[l].triangle;
    model.landmark_barycentric[l] = landmarks.points[l].barycentric;
  }
  model.dynamic_contour = landmarks.contour;
  if (!model.dynamic_contour) return {};
  std::vector<ContourRow>& rows = model.dynamic_contour->rows;
  // Forward shift of the left half minus that of the right half, over the positive rows against the negative.
  double sense = 0;
  const int limit = model.dynamic_contour->limit_deg();
  for (int degree = -limit; degree <= limit; ++degree)
    for (const int side : {-1, 1})
      for (int i = 1; i <= 7; ++i) {
        const SurfacePoint& point =
            rows[std::size_t(degree + limit)][std::size_t(kContourCount / 2 + side * i)];
        sense += double(degree * side) * double(position(model, point).z());
      }
  if (sense < 0) std::reverse(rows.begin(), rows.end());
  return {};
}

}  // namespace likeness
