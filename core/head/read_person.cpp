// See read_person.h.
#include "core/head/read_person.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/base/dense_solves.h"
#include "core/base/files.h"
#include "core/base/npz.h"
#include "core/head/ict_folder.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr float kMaxDeviations = 10;                       // of a coefficient; faces lie within three
constexpr double kSmallestHead = 0.7, kLargestHead = 1.4;  // heights of heads relative to the model's
constexpr double kFrameOff = 0.06;                         // m between the middles of mesh and model
constexpr double kUsuallyOff = 0.025;                      // m between a vertex and the model's, on average
constexpr double kFitted = 1e-4;       // m within which the identity should explain the mesh
constexpr float kNothingLeft = 1e-5f;  // m; less is rounding

constexpr std::array<const char*, 2> kCoefficientKeys{"identity", "shape"};
constexpr const char* kVertexKey = "vertices";

// What is needed, for the remedy.
std::string needed(const HeadModel& model) {
  return fmt::format(
      "Give {} identity coefficients of the {} head, shape ({}) or (1, {}), or its {} vertices in metres, "
      "shape ({}, 3): .npy, .npz with the key identity, shape or vertices, or an .obj.",
      model.identity_count(), model.name, model.identity_count(), model.identity_count(),
      model.vertex_count(), model.vertex_count());
}

Error wrong_person(const fs::path& path, std::string what, std::string fix) {
  return {ErrorCode::bad_input, std::move(what), std::move(fix), path.string()};
}

Result<NpyArray> array_of_archive(const fs::path& path, const HeadModel& model) {
  auto archive = read_npz(path);
  if (!archive) return archive.error();
  for (const char* key : {kCoefficientKeys[0], kCoefficientKeys[1], kVertexKey})
    if (const auto found = archive->find(key); found != archive->end()) return std::move(found->second);
  if (archive->size() == 1) return std::move(archive->begin()->second);
  std::vector<std::string> keys;
  for (const auto& [key, value] : *archive) keys.push_back(key);
  return wrong_person(
      path,
      fmt::format("{} holds {}, and neither identity, shape nor vertices.", path.filename().string(),
                  keys.empty() ? "nothing" : fmt::format("{}", fmt::join(keys, ", "))),
      needed(model));
}

Result<NpyArray> read_array(const fs::path& path, const HeadModel& model) {
  if (path.extension() == ".npz") return array_of_archive(path, model);
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return parse_npy(*bytes, path.filename().string());
}

Result<PersonShape> person_of_coefficients(const fs::path& path, std::span<const float> values,
                                           const HeadModel& model) {
  const std::string name = path.filename().string();
  if (int(values.size()) != model.identity_count())
    return wrong_person(
        path,
        fmt::format("{} holds {} coefficients, and the {} head has {}.", name, values.size(), model.name,
                    model.identity_count()),
        fmt::format("Build with the head model they belong to (MICA's 300 are FLAME's). {}", needed(model)));
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::abs(values[i]) > kMaxDeviations)
      return wrong_person(
          path,
          fmt::format("Coefficient {} in {} is {:.4g} standard deviations; a head lies within {:g}.", i, name,
                      values[i], kMaxDeviations),
          "These are not identity coefficients, or they are another model's. " + needed(model));
  PersonShape person;
  person.identity = Eigen::Map<const Eigen::VectorXf>(values.data(), Eigen::Index(values.size()));
  return person;
}

// -- Meshes.

struct Extent {
  Vec3d middle = Vec3d::Zero();
  double height = 0;
};

Extent extent_of(std::span<const Vec3f> vertices) {
  Extent extent;
  float low = vertices[0].y(), high = low;
  for (const Vec3f& v : vertices) {
    extent.middle += v.cast<double>() / double(vertices.size());
    low = std::min(low, v.y()), high = std::max(high, v.y());
  }
  extent.height = double(high) - double(low);
  return extent;
}

std::string unit_remedy(double ratio) {
  struct Unit {
    double per_metre;
    const char* name;
  };
  for (const Unit unit :
       {Unit{1000, "millimetres"}, {100, "centimetres"}, {10, "decimetres"}, {39.37, "inches"}})
    if (ratio > kSmallestHead * unit.per_metre && ratio < kLargestHead * unit.per_metre)
      return fmt::format("It looks like {}: divide all by {:g}, so that they are metres.", unit.name,
                         unit.per_metre);
  return "Give the vertices in metres.";
}

Result<void> check_mesh(const fs::path& path, std::span<const Vec3f> vertices, const HeadModel& model) {
  const std::string name = path.filename().string();
  const Extent found = extent_of(vertices), own = extent_of(model.vertices);
  const double ratio = found.height / own.height;
  if (!(ratio > kSmallestHead && ratio < kLargestHead))
    return wrong_person(path,
                        fmt::format("The mesh in {} is {:.4g} units tall, and the {} head is {:.3g} m.", name,
                                    found.height, model.name, own.height),
                        unit_remedy(ratio));
  if (const double off = (found.middle - own.middle).norm(); off > kFrameOff)
    return wrong_person(
        path, fmt::format("The mesh in {} lies {:.2f} m from where the {} head lies.", name, off, model.name),
        "Give it in the model's own frame, neither moved nor turned: x to the person's left, y up.");
  double sum = 0;
  for (std::size_t v = 0; v < vertices.size(); ++v) sum += double((vertices[v] - model.vertices[v]).norm());
  if (const double usual = sum / double(vertices.size()); usual > kUsuallyOff)
    return wrong_person(path,
                        fmt::format("The vertices in {} lie {:.1f} cm from those of the {} head on average.",
                                    name, 100 * usual, model.name),
                        "They are in another order, of another topology, or turned. " + needed(model));
  return {};
}

// Rotated to begin at the smallest corner.
std::array<int, 3> from_smallest(const Triangle& t) {
  std::array<int, 3> corners{t[0], t[1], t[2]};
  std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
  return corners;
}

Result<void> check_faces(const fs::path& path, const ObjMesh& mesh, const HeadModel& model) {
  if (mesh.triangles.empty()) return {};
  std::set<std::array<int, 3>> own;
  for (const Triangle& t : model.triangles) own.insert(from_smallest(t));
  std::size_t common = 0;
  for (const Triangle& t : mesh.triangles) common += own.contains(from_smallest(t));
  // Quads may be split the other way; meshes of another topology share hardly a triangle.
  if (2 * common >= std::min(mesh.triangles.size(), own.size())) return {};
  return wrong_person(path,
                      fmt::format("Of the {} triangles in {}, {} are the {} head's.", mesh.triangles.size(),
                                  path.filename().string(), common, model.name),
                      "The mesh is of another topology. " + needed(model));
}

// The identity that explains the mesh, and the remainder as offsets. min |B x - d|^2 / kFitted^2 + |x|^2.
PersonShape person_of_vertices(std::span<const Vec3f> vertices, const HeadModel& model) {
  const Eigen::Index n = 3 * Eigen::Index(vertices.size()), count = model.identity_count();
  Eigen::VectorXf off(n);
  for (std::size_t v = 0; v < vertices.size(); ++v)
    off.segment<3>(3 * Eigen::Index(v)) = vertices[v] - model.vertices[v];
  PersonShape person;
  person.identity = Eigen::VectorXf::Zero(count);
  if (count > 0) {
    const Eigen::MatrixXf& basis = model.identity_basis;
    Eigen::MatrixXd normal = (basis.transpose() * basis).cast<double>();
    normal.diagonal().array() += kFitted * kFitted;
    const Eigen::VectorXd right = (basis.transpose() * off).cast<double>();
    person.identity = solve_symmetric(normal, right).cast<float>();
    off -= basis * person.identity;
  }
  if (off.cwiseAbs().maxCoeff() <= kNothingLeft) return person;
  for (std::size_t v = 0; v < vertices.size(); ++v)
    person.offsets.emplace_back(off.segment<3>(3 * Eigen::Index(v)));
  return person;
}

Result<PersonShape> person_of_mesh(const fs::path& path, std::span<const Vec3f> vertices,
                                   const HeadModel& model) {
  if (int(vertices.size()) != model.vertex_count())
    return wrong_person(
        path,
        fmt::format("The mesh in {} has {} vertices, and the {} head has {}.", path.filename().string(),
                    vertices.size(), model.name, model.vertex_count()),
        "The mesh is of another topology. " + needed(model));
  if (const auto fine = check_mesh(path, vertices, model); !fine) return fine.error();
  return person_of_vertices(vertices, model);
}

Result<PersonShape> person_of_obj(const fs::path& path, const HeadModel& model) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto mesh = parse_obj(*bytes, path.string());
  if (!mesh) return mesh.error();
  for (std::size_t v = 0; v < mesh->vertices.size(); ++v)
    if (!mesh->vertices[v].allFinite())
      return wrong_person(path, fmt::format("Vertex {} in {} is not finite.", v, path.filename().string()),
                          "Export the mesh again. " + needed(model));
  if (int(mesh->vertices.size()) == model.vertex_count())
    if (const auto fine = check_faces(path, *mesh, model); !fine) return fine.error();
  return person_of_mesh(path, mesh->vertices, model);
}

}  // namespace

Result<PersonShape> read_person(const fs::path& path, const HeadModel& model) {
  if (path.extension() == ".obj") return person_of_obj(path, model);
  const std::string name = path.filename().string();
  if (path.extension() != ".npy" && path.extension() != ".npz")
    return wrong_person(path, fmt::format("{} is neither .npy, .npz nor .obj.", name), needed(model));
  const auto array = read_array(path, model);
  if (!array) return array.error();
  if (array->kind != 'f' && array->kind != 'i' && array->kind != 'u')
    return wrong_person(path, fmt::format("{} holds no numbers.", name), needed(model));
  std::vector<std::size_t> shape = array->shape;
  while (shape.size() > 1 && shape.front() == 1) shape.erase(shape.begin());
  const std::vector<float> values = array->as_float();
  const auto bad = std::ranges::find_if(values, [](float value) { return !std::isfinite(value); });
  if (bad != values.end())
    return wrong_person(
        path, fmt::format("{} holds a value that is not finite, at {}.", name, bad - values.begin()),
        "Make it again. " + needed(model));
  if (shape.size() == 1) return person_of_coefficients(path, values, model);
  if (shape.size() == 2 && shape[1] == 3 && shape[0] > 0) {
    std::vector<Vec3f> vertices;
    for (std::size_t v = 0; v < shape[0]; ++v)
      vertices.emplace_back(values[3 * v], values[3 * v + 1], values[3 * v + 2]);
    return person_of_mesh(path, vertices, model);
  }
  return wrong_person(path,
                      fmt::format("{} holds numbers of shape ({}).", name, fmt::join(array->shape, ", ")),
                      needed(model));
}

}  // namespace likeness
