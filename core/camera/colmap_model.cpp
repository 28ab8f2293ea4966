// Little-endian binary layout of colmap 3.x, see the format page of its documentation.
#include "core/camera/colmap_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "core/base/files.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

// Reads numbers until the bytes run out; then `broken` stays set and zeros come back.
struct ByteReader {
  std::span<const std::byte> bytes;
  std::size_t position = 0;
  bool broken = false;

  template <class T>
  T next() {
    T value{};
    if (broken || bytes.size() - position < sizeof(T)) {
      broken = true;
      return value;
    }
    std::memcpy(&value, bytes.data() + position, sizeof(T));
    position += sizeof(T);
    return value;
  }
  std::string next_name() {
    std::string name;
    for (char c = next<char>(); !broken && c != 0; c = next<char>()) name += c;
    return name;
  }
  // A count of records of at least `least` bytes each; broken when they cannot fit.
  std::uint64_t next_count(std::size_t least) {
    const auto count = next<std::uint64_t>();
    if (broken || count > (bytes.size() - position) / least) broken = true;
    return broken ? 0 : count;
  }
};

Error broken_model(const std::filesystem::path& path, std::string what) {
  return {ErrorCode::bad_input, std::move(what),
          "Delete the work folder of the cameras and run `likeness align` again.", path.string()};
}

int parameter_count(int model) {
  switch (model) {
    case 0:
      return 3;  // SIMPLE_PINHOLE f cx cy
    case 1:
      return 4;  // PINHOLE fx fy cx cy
    case 2:
      return 4;  // SIMPLE_RADIAL f cx cy k1
    case 3:
      return 5;  // RADIAL f cx cy k1 k2
    case 4:
      return 8;  // OPENCV fx fy cx cy k1 k2 p1 p2
    default:
      return 0;
  }
}

Intrinsics intrinsics_of(int model, const double* p) {
  Intrinsics k;
  if (model == 1 || model == 4) {
    k.fx = p[0], k.fy = p[1], k.cx = p[2], k.cy = p[3];
    if (model == 4) k.k1 = p[4], k.k2 = p[5], k.p1 = p[6], k.p2 = p[7];
  } else {
    k.fx = k.fy = p[0], k.cx = p[1], k.cy = p[2];
    if (model >= 2) k.k1 = p[3];
    if (model == 3) k.k2 = p[4];
  }
  return k;
}

Result<void> read_cameras_bin(const std::filesystem::path& path, ColmapModel& model) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  ByteReader in{*bytes};
  const auto count = in.next_count(48);
  for (std::uint64_t i = 0; i < count && !in.broken; ++i) {
    const int id = in.next<std::int32_t>(), kind = in.next<std::int32_t>();
    const auto width = in.next<std::uint64_t>(), height = in.next<std::uint64_t>();
    const int parameters = parameter_count(kind);
    if (parameters == 0 && !in.broken)
      return broken_model(path,
                          fmt::format("Camera {} has the model {}, which Likeness does not read.", id, kind));
    double values[8] = {};
    for (int k = 0; k < parameters; ++k) values[k] = in.next<double>();
    Intrinsics intrinsics = intrinsics_of(kind, values);
    intrinsics.width = int(std::min<std::uint64_t>(width, 1 << 20));
    intrinsics.height = int(std::min<std::uint64_t>(height, 1 << 20));
    if (!in.broken && !(intrinsics.fx > 0 && intrinsics.fy > 0))
      return broken_model(path, fmt::format("Camera {} has a focal length of {} px.", id, intrinsics.fx));
    model.cameras[id] = intrinsics;
  }
  if (in.broken || model.cameras.empty())
    return broken_model(path, "The file is cut short or holds no camera.");
  return {};
}

Result<void> read_images_bin(const std::filesystem::path& path, ColmapModel& model) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  ByteReader in{*bytes};
  const auto count = in.next_count(73);
  for (std::uint64_t i = 0; i < count && !in.broken; ++i) {
    ColmapImage image;
    in.next<std::uint32_t>();  // id: follows thread order, names identify
    double q[4], t[3];
    for (double& value : q) value = in.next<double>();
    for (double& value : t) value = in.next<double>();
    image.camera = int(in.next<std::uint32_t>());
    image.name = in.next_name();
    const auto features = in.next_count(24);
    image.observations.reserve(features);
    for (std::uint64_t f = 0; f < features && !in.broken; ++f) {
      const double x = in.next<double>(), y = in.next<double>();
      image.observations.push_back({{x, y}, in.next<std::int64_t>()});
    }
    if (in.broken) break;
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (!(rotation.norm() > 0.5) || !model.cameras.count(image.camera))
      return broken_model(path, fmt::format("Picture {} has no valid pose or camera.", image.name));
    image.cam_from_world.linear() = rotation.normalized().toRotationMatrix();
    image.cam_from_world.translation() = Vec3d(t[0], t[1], t[2]);
    model.images.push_back(std::move(image));
  }
  if (in.broken) return broken_model(path, "The file is cut short.");
  std::sort(model.images.begin(), model.images.end(),
            [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  return {};
}

Result<void> read_points_bin(const std::filesystem::path& path, ColmapModel& model) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  ByteReader in{*bytes};
  const auto count = in.next_count(51);
  model.points.reserve(count);
  for (std::uint64_t i = 0; i < count && !in.broken; ++i) {
    const auto id = in.next<std::int64_t>();
    ColmapPoint point;
    for (int axis = 0; axis < 3; ++axis) point.position[axis] = in.next<double>();
    for (int channel = 0; channel < 3; ++channel) in.next<std::uint8_t>();
    point.error_px = in.next<double>();
    const auto views = in.next_count(8);
    in.position += in.broken ? 0 : views * 8;
    point.views = int(views);
    model.points.emplace(id, point);
  }
  if (in.broken) return broken_model(path, "The file is cut short.");
  return {};
}

}  // namespace

Result<ColmapModel> read_colmap_model(const std::filesystem::path& folder) {
  ColmapModel model;
  if (auto read = read_cameras_bin(folder / "cameras.bin", model); !read) return read.error();
  if (auto read = read_images_bin(folder / "images.bin", model); !read) return read.error();
  if (auto read = read_points_bin(folder / "points3D.bin", model); !read) return read.error();
  return model;
}

double median_parallax(const ColmapModel& model) {
  struct Seen {
    Vec3d first = Vec3d::Zero();  // unit, from the point to the first picture
    double min_cosine = 1;
    bool any = false;
  };
  std::unordered_map<std::int64_t, Seen> seen;
  for (const ColmapImage& image : model.images) {
    const Vec3d eye = inverse(image.cam_from_world).translation();
    for (const ColmapObservation& observation : image.observations) {
      const auto point = model.points.find(observation.point);
      if (point == model.points.end()) continue;
      const Vec3d towards = (eye - point->second.position).normalized();
      Seen& one = seen[observation.point];
      if (!one.any) one.first = towards;
      one.any = true;
      one.min_cosine = std::min(one.min_cosine, one.first.dot(towards));
    }
  }
  std::vector<double> angles;
  for (const auto& [id, one] : seen) angles.push_back(std::acos(std::clamp(one.min_cosine, -1.0, 1.0)));
  return median(std::move(angles));
}

Result<void> write_colmap_cameras(const std::filesystem::path& folder,
                                  const std::map<int, Intrinsics>& cameras) {
  constexpr std::int32_t kOpenCv = 4;
  std::vector<std::byte> bytes;
  const auto put = [&](const auto& value) {
    const auto raw = std::as_bytes(std::span(&value, 1));
    bytes.insert(bytes.end(), raw.begin(), raw.end());
  };
  put(std::uint64_t(cameras.size()));
  for (const auto& [id, k] : cameras) {
    put(std::int32_t(id)), put(kOpenCv), put(std::uint64_t(k.width)), put(std::uint64_t(k.height));
    for (const double value : {k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2}) put(value);
  }
  return write_file(folder / "cameras.bin", bytes);
}

double mean_reprojection_px(const ColmapModel& model) {
  double sum = 0;
  std::size_t count = 0;
  for (const auto& image : model.images) {
    const Intrinsics& k = model.cameras.at(image.camera);
    for (const auto& seen : image.observations) {
      const auto point = model.points.find(seen.point);
      if (point == model.points.end()) continue;
      const Vec3d in_cam = image.cam_from_world * point->second.position;
      if (in_cam.z() <= 0) continue;
      sum += (project<double>(k, in_cam) - seen.pixel).norm();
      ++count;
    }
  }
  return count ? sum / double(count) : 0;
}

}  // namespace likeness
