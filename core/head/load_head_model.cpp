// Reads head models in the FLAME key schema, trusting nothing in them: every shape, index, sum and value is
// checked, and errors name the key and both sizes.
#include "core/head/load_head_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <sstream>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/npz.h"
#include "core/head/builtin_head.h"
#include "core/head/drawn_landmarks.h"
#include "core/head/flame.h"
#include "core/head/flame_landmarks.h"
#include "core/head/ict_folder.h"
#include "core/head/named_actions.h"
#include "core/head/transfer_actions.h"

namespace likeness {
namespace {

constexpr const char* kNoHead =
    "Choose FLAME's .pkl, a folder of ICT-FaceKit's .obj files, or a .npz in the FLAME key schema "
    "(v_template, shapedirs, posedirs, J_regressor, weights, kintree_table, f, lmk_faces_idx, "
    "lmk_bary_coords), or leave the head model out to use the built-in one.";

constexpr int kFlameVertices = 5023;
constexpr int kFewestForActions = 500;  // vertices; on a coarser face no action can be recognised

using Shape = std::vector<std::size_t>;
using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::string shape_text(const Shape& shape) { return fmt::format("({})", fmt::join(shape, ", ")); }

// The archive with the first fault found in it: checks after a fault do nothing, so that the reading below
// stays one line per key.
class Reader {
 public:
  Reader(const NpzArchive& archive, std::string file) : archive_(archive), file_(std::move(file)) {}

  bool has(const std::string& key) const { return archive_.contains(key); }
  const std::optional<Error>& error() const { return error_; }
  void fail(Error error) {
    if (!error_) error_ = std::move(error);
  }
  void fail(std::string what) {
    if (!error_) error_ = Error{ErrorCode::bad_input, std::move(what), kNoHead, file_};
  }

  // Numeric array of exactly this shape; nullptr after a fault.
  const NpyArray* array(const std::string& key, const Shape& shape) {
    const NpyArray* found = any_array(key);
    if (!found) return nullptr;
    if (found->shape == shape) return found;
    fail(fmt::format("{} has shape {} where {} is expected.", key, shape_text(found->shape),
                     shape_text(shape)));
    return nullptr;
  }
  const NpyArray* any_array(const std::string& key) {
    if (error_) return nullptr;
    const auto found = archive_.find(key);
    if (found == archive_.end()) {
      fail(fmt::format("{} is missing.", key));
      return nullptr;
    }
    const char kind = found->second.kind;
    if (kind != 'f' && kind != 'i' && kind != 'u' && kind != 'b') {
      fail(fmt::format("{} holds {} where numbers are expected.", key,
                       kind == 'O' ? "Python objects" : "text"));
      return nullptr;
    }
    return &found->second;
  }
  std::vector<float> floats(const std::string& key, const Shape& shape) {
    const NpyArray* found = array(key, shape);
    if (!found) return {};
    std::vector<float> values = found->as_float();
    const auto bad =
        std::find_if(values.begin(), values.end(), [](float value) { return !std::isfinite(value); });
    if (bad == values.end()) return values;
    fail(fmt::format("{} holds a value that is not finite, at flat index {} of {}.", key,
                     bad - values.begin(), values.size()));
    return {};
  }
  std::vector<std::int32_t> ints(const std::string& key, const Shape& shape) {
    const NpyArray* found = array(key, shape);
    if (!found) return {};
    if (found->kind != 'i' && found->kind != 'u') {
      fail(fmt::format("{} holds numbers of kind '{}' where integers are expected.", key, found->kind));
      return {};
    }
    return found->as_int();
  }
  // Integers that index an array of `limit` elements called `what`.
  std::vector<std::int32_t> indices(const std::string& key, const Shape& shape, std::size_t limit,
                                    const char* what) {
    std::vector<std::int32_t> values = ints(key, shape);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] >= 0 && std::size_t(values[i]) < limit) continue;
      fail(fmt::format("{} refers to {} {} at flat index {}, but there are {}.", key, what, values[i], i,
                       limit));
      return {};
    }
    return values;
  }
  // An optional one-element integer.
  std::optional<int> scalar(const std::string& key) {
    if (error_ || !has(key)) return std::nullopt;
    const NpyArray* found = any_array(key);
    if (!found) return std::nullopt;
    if (found->count() != 1 || (found->kind != 'i' && found->kind != 'u')) {
      fail(fmt::format("{} has shape {} where one integer is expected.", key, shape_text(found->shape)));
      return std::nullopt;
    }
    return std::max(-1, found->as_int().front());
  }
  // Rows of `columns` numbers that must sum to 1 and not be negative.
  void check_rows(const std::string& key, const std::vector<float>& values, std::size_t columns) {
    for (std::size_t row = 0; !error_ && row * columns < values.size(); ++row) {
      double sum = 0;
      float least = 0;
      for (std::size_t c = 0; c < columns; ++c) {
        sum += values[row * columns + c];
        least = std::min(least, values[row * columns + c]);
      }
      if (std::abs(sum - 1) > 1e-3)
        fail(fmt::format("Row {} of {} sums to {:.4g}, not to 1.", row, key, sum));
      if (least < -1e-3f)
        fail(fmt::format("Row {} of {} holds the negative weight {:.4g}.", row, key, least));
    }
  }

 private:
  const NpzArchive& archive_;
  std::string file_;
  std::optional<Error> error_;
};

std::vector<Vec3f> as_points(const std::vector<float>& values) {
  std::vector<Vec3f> points(values.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  return points;
}

Eigen::MatrixXf as_matrix(const std::vector<float>& values, std::size_t rows, std::size_t columns) {
  if (values.size() != rows * columns) return {};
  return Eigen::Map<const RowMajor>(values.data(), Eigen::Index(rows), Eigen::Index(columns));
}

// How the last axis of shapedirs divides into identity and expression.
struct BasisCounts {
  std::size_t identity = 0, expression = 0;
};

BasisCounts read_counts(Reader& reader, std::size_t total) {
  std::optional<int> identity = reader.scalar("n_shape"), expression = reader.scalar("n_expr");
  if (!identity && !expression) {
    // FLAME's own files hold 300 + 100 directions and say so nowhere; 100 + 50 is its usual excerpt.
    if (total == 400)
      identity = 300, expression = 100;
    else if (total == 150)
      identity = 100, expression = 50;
  } else if (!identity) {
    identity = int(total) - *expression;
  } else if (!expression) {
    expression = int(total) - *identity;
  }
  if (!identity)
    reader.fail(
        fmt::format("shapedirs has {} directions, and neither n_shape nor n_expr says how many are identity "
                    "(without them 400 = 300 + 100 or 150 = 100 + 50 is expected).",
                    total));
  else if (*identity < 0 || *expression < 0 || std::size_t(*identity) + std::size_t(*expression) != total)
    reader.fail(fmt::format("n_shape {} and n_expr {} do not add up to the {} directions of shapedirs.",
                            *identity, *expression, total));
  if (reader.error()) return {};
  return {std::size_t(*identity), std::size_t(*expression)};
}

void read_geometry(Reader& reader, HeadModel& model) {
  const NpyArray* points = reader.any_array("v_template");
  if (!points) return;
  const NpyArray* weights = reader.has("weights") ? reader.any_array("weights") : nullptr;
  const auto count_along = [](const NpyArray* array, std::size_t axis) {
    return array && array->shape.size() > axis ? array->shape[axis] : 0;
  };
  if (const char* name = flame_relative(count_along(points, 0), count_along(weights, 1)))
    return reader.fail(fmt::format("The file is {}, not a head model.", name));
  if (points->shape.size() != 2 || points->shape[1] != 3 || points->shape[0] < 3)
    return reader.fail(
        fmt::format("v_template has shape {} where (V, 3) is expected.", shape_text(points->shape)));
  const std::size_t count = points->shape[0];
  model.vertices = as_points(reader.floats("v_template", {count, 3}));
  if (reader.error()) return;
  Vec3f low = model.vertices.front(), high = low;
  for (const Vec3f& vertex : model.vertices) low = low.cwiseMin(vertex), high = high.cwiseMax(vertex);
  const float extent = (high - low).maxCoeff();
  if (extent < 0.05f || extent > 2.0f)
    return reader.fail(
        fmt::format("v_template is {:.4g} units long; a head in metres has 0.05 to 2.", extent));

  const NpyArray* faces = reader.any_array("f");
  if (!faces) return;
  if (faces->shape.size() != 2 || faces->shape[1] != 3 || faces->shape[0] == 0)
    return reader.fail(fmt::format("f has shape {} where (F, 3) is expected.", shape_text(faces->shape)));
  const std::vector<std::int32_t> corners = reader.indices("f", {faces->shape[0], 3}, count, "vertex");
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
    model.triangles.emplace_back(corners[i], corners[i + 1], corners[i + 2]);
}

void read_bases(Reader& reader, HeadModel& model) {
  const std::size_t count = model.vertices.size();
  const NpyArray* shapes = reader.any_array("shapedirs");
  if (!shapes) return;
  if (shapes->shape.size() != 3 || shapes->shape[0] != count || shapes->shape[1] != 3)
    return reader.fail(fmt::format("shapedirs has shape {} where ({}, 3, n) is expected.",
                                   shape_text(shapes->shape), count));
  const std::size_t total = shapes->shape[2];
  const BasisCounts counts = read_counts(reader, total);
  if (reader.error()) return;
  const std::vector<float> values = reader.floats("shapedirs", {count, 3, total});
  if (reader.error()) return;
  const Eigen::Map<const RowMajor> basis(values.data(), Eigen::Index(3 * count), Eigen::Index(total));
  model.identity_basis = basis.leftCols(Eigen::Index(counts.identity));
  model.expression_basis = basis.rightCols(Eigen::Index(counts.expression));

  model.pose_basis.resize(Eigen::Index(3 * count), 0);
  if (!reader.has("posedirs")) return;
  const std::size_t features = kPoseFeatureCount;
  model.pose_basis = as_matrix(reader.floats("posedirs", {count, 3, features}), 3 * count, features);
}

void read_skeleton(Reader& reader, HeadModel& model) {
  const std::size_t count = model.vertices.size(), joints = kJointCount;
  const std::vector<float> regressor = reader.floats("J_regressor", {joints, count});
  double off = 0;
  for (std::size_t j = 0; j < joints && !regressor.empty(); ++j) {
    double sum = 0;
    for (std::size_t v = 0; v < count; ++v) sum += regressor[j * count + v];
    off = std::max(off, std::abs(sum - 1));
  }
  if (off > 1e-2) reader.fail(fmt::format("A row of J_regressor is {:.4g} away from summing to 1.", off));
  model.joint_regressor = as_matrix(regressor, joints, count);

  const std::vector<float> weights = reader.floats("weights", {count, joints});
  reader.check_rows("weights", weights, joints);
  model.skinning_weights = as_matrix(weights, count, joints);

  const std::vector<std::int32_t> tree = reader.ints("kintree_table", {2, joints});
  if (reader.error()) return;
  for (int j = 0; j < kJointCount; ++j) {
    const bool good = j == 0 ? tree[j] < 0 : tree[j] >= 0 && tree[j] < j;
    if (!good)
      return reader.fail(
          fmt::format("kintree_table gives joint {} the parent {}; a parent comes before its child, and "
                      "only the root has none.",
                      j, tree[j]));
    model.parents[j] = j == 0 ? -1 : tree[j];
  }
}

void read_landmarks(Reader& reader, const std::filesystem::path& path, HeadModel& model) {
  // Archives made from FLAME's files have none of these keys: FLAME keeps its landmarks in files of their
  // own.
  if (!reader.has("lmk_faces_idx") && !reader.has("lmk_bary_coords") &&
      model.vertex_count() == kFlameVertices) {
    const auto landmarks = read_flame_landmarks(path);
    if (!landmarks) return reader.fail(landmarks.error());
    const auto attached = attach_landmarks(*landmarks, path.string(), model);
    if (!attached) reader.fail(attached.error());
    return;
  }
  const std::size_t count = kLandmarkCount;
  const std::vector<std::int32_t> faces =
      reader.indices("lmk_faces_idx", {count}, model.triangles.size(), "triangle");
  const std::vector<float> weights = reader.floats("lmk_bary_coords", {count, 3});
  reader.check_rows("lmk_bary_coords", weights, 3);
  if (reader.error()) return;
  for (std::size_t l = 0; l < count; ++l) {
    model.landmark_triangle[l] = faces[l];
    model.landmark_barycentric[l] = {weights[3 * l], weights[3 * l + 1], weights[3 * l + 2]};
  }
}

void read_parts(Reader& reader, HeadModel& model) {
  model.parts.assign(model.vertices.size(), HeadPart::unknown);
  if (!reader.has("part_id")) {
    // Vertices bound to an eye's joint are that eyeball: the one part that FLAME's files identify.
    for (int v = 0; v < model.vertex_count(); ++v)
      for (const auto& [joint, part] :
           {std::pair{kLeftEye, HeadPart::left_eyeball}, std::pair{kRightEye, HeadPart::right_eyeball}})
        if (model.skinning_weights(v, joint) > 0.9f) model.parts[std::size_t(v)] = part;
    return;
  }
  const std::vector<std::int32_t> ids =
      reader.indices("part_id", {model.vertices.size()}, std::size_t(HeadPart::unknown) + 1, "part");
  for (std::size_t v = 0; v < ids.size(); ++v)
    model.parts[v] = HeadPart(ids[v]);  // the enumeration is in file order
}

// `*_expression_names.txt` beside the model, in order.
std::vector<std::filesystem::path> name_files_beside(const std::filesystem::path& model_path) {
  std::error_code ignored;
  std::vector<std::filesystem::path> files;
  const std::filesystem::path folder = model_path.has_parent_path() ? model_path.parent_path() : ".";
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.path().filename().string().ends_with("_expression_names.txt")) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

// Names in a text file, one per line: the first file that holds as many as needed.
std::vector<std::string> names_beside(const std::filesystem::path& model_path, std::size_t count) {
  for (const std::filesystem::path& candidate : name_files_beside(model_path)) {
    const Result<std::string> text = read_text(candidate);
    if (!text) continue;
    std::vector<std::string> names;
    std::istringstream words(*text);
    for (std::string word; words >> word;) names.push_back(word);
    if (names.size() == count) return names;
  }
  return {};
}

void read_names(Reader& reader, const NpzArchive& archive, const std::filesystem::path& path,
                HeadModel& model) {
  const std::size_t count = std::size_t(model.expression_count());
  const auto found = archive.find("expression_names");
  if (found == archive.end()) {
    if (count > 0) model.expression_names = names_beside(path, count);
  } else if (found->second.kind != 'U') {
    reader.fail("expression_names is not an array of text.");
  } else {
    model.expression_names = found->second.as_strings();
    if (model.expression_names.size() != count)
      reader.fail(fmt::format("expression_names has {} names for {} expressions.",
                              model.expression_names.size(), count));
  }
  const bool named = !model.expression_names.empty();
  const Eigen::Index size = Eigen::Index(count);
  // Named shapes range from 0 to 1; unnamed ones are principal components, in standard deviations.
  model.expression_min = Eigen::VectorXf::Constant(size, named ? 0.0f : -3.0f);
  model.expression_max = Eigen::VectorXf::Constant(size, named ? 1.0f : 3.0f);
}

std::string model_name(const NpzArchive& archive, const std::filesystem::path& path, int vertices) {
  const auto found = archive.find("name");
  if (found != archive.end() && found->second.kind == 'U' && found->second.count() == 1)
    return found->second.as_strings().front();
  if (archive.contains("ict_vertex")) return "ICT-FaceKit";
  return vertices == kFlameVertices ? flame_name(path) : path.stem().string();
}

bool starts_like(const std::vector<std::byte>& bytes, std::string_view start) {
  return bytes.size() >= start.size() && std::memcmp(bytes.data(), start.data(), start.size()) == 0;
}

}  // namespace

Result<HeadModel> head_model_from_archive(const NpzArchive& archive, const std::filesystem::path& where) {
  Reader reader(archive, where.string());
  HeadModel model;
  read_geometry(reader, model);
  if (!reader.error()) read_bases(reader, model);
  if (!reader.error()) read_skeleton(reader, model);
  if (!reader.error()) read_landmarks(reader, where, model);
  if (!reader.error() && archive.contains("ict_vertex")) draw_landmarks(model, ict_shifts());
  if (!reader.error()) read_parts(reader, model);
  if (!reader.error()) read_names(reader, archive, where, model);
  if (reader.error()) return *reader.error();
  model.name = model_name(archive, where, model.vertex_count());
  model.actions = make_named_actions(model);
  if (model.expression_names.empty() && model.vertex_count() >= kFewestForActions)
    model.actions = transfer_actions(make_builtin_head(), model);
  model.hash = content_hash(model);
  return model;
}

Result<HeadModel> load_head_model(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return load_ict_folder(path);
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  Result<NpzArchive> archive = NpzArchive();
  if (starts_like(*bytes, "PK")) {
    archive = parse_npz(*bytes, path.string());
    if (!archive) return archive.error();
    if (const auto unpacked = unpack_objects(*archive, path.string()); !unpacked) return unpacked.error();
  } else if (path.extension() == ".pkl" || starts_like(*bytes, "\x80")) {
    archive = read_flame_pickle(*bytes, path.string());
    if (!archive) return archive.error();
  } else {
    return Error{ErrorCode::bad_input, "The file is neither a .npz nor a .pkl head model.", kNoHead,
                 path.string()};
  }
  return head_model_from_archive(*archive, path);
}

Result<std::string> head_model_files_hash(const std::filesystem::path& path) {
  std::error_code ignored;
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(path, ignored)) {
    files = ict_folder_files(path);
  } else {
    files = {path};
    for (const std::filesystem::path& file : landmark_files_beside(path)) files.push_back(file);
    if (path.extension() == ".npz")
      for (const std::filesystem::path& file : name_files_beside(path)) files.push_back(file);
  }
  std::string list;
  for (const std::filesystem::path& file : files) {
    const auto hash = hash_file(file);
    if (!hash) return hash.error();
    list += file.filename().string() + ' ' + *hash + '\n';
  }
  return files.size() == 1 ? hash_file(path) : Result<std::string>(hash_text(list));
}

}  // namespace likeness
