// See face_network.h. The regions are those that the networks were trained with (MediaPipe's face landmark
// graph): the box of the points, its longer side times 1.5.
#include "core/face/face_network.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/network/installed_networks.h"

namespace likeness {
namespace {

constexpr int kEyeSide = 64;                         // px of the iris network's input
constexpr double kEyeRound = 2.3;                    // region's side in widths of an eye
constexpr int kMeshSide = 192, kDetectorSide = 128;  // px of the networks' inputs
constexpr int kCopies = 8;                           // threads that each is run by at once
constexpr double kRound = 1.5;                       // region's side in sides of the points' box
constexpr int kRightCorner = 33, kLeftCorner = 263;  // outer corners of the eyes
constexpr double kPresent = 0.5;                     // of presence: more likely a face than not
constexpr double kCandidate = 0.5;                   // of the detector's score; points are asked next
constexpr double kSameFace = 0.3;                    // overlap above which two candidates are one
constexpr double kSameTurn = 0.1;                    // rad
constexpr double kSameShift = 0.06;                  // of the side
constexpr double kSameScale = 1.1;
constexpr int kLooks = 3;

double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

cv::Mat view_of(const Image8& picture) {
  return cv::Mat(picture.height, picture.width, CV_8UC(picture.channels),
                 const_cast<std::uint8_t*>(picture.data.data()));
}

// The square `region` of the picture at side x side px, RGB. Where it is reduced much, it is averaged first.
Image8 cut(const Image8& picture, const MeshRegion& region, int side, int border) {
  const double c = std::cos(region.roll), s = std::sin(region.roll);
  // -- The upright rectangle that holds the region, within the picture and a pixel round it.
  const double reach = 0.5 * region.side * (std::abs(c) + std::abs(s)) + 2;
  const int x0 = std::clamp(int(std::floor(region.centre.x() - reach)), 0, picture.width - 1),
            y0 = std::clamp(int(std::floor(region.centre.y() - reach)), 0, picture.height - 1),
            x1 = std::clamp(int(std::ceil(region.centre.x() + reach)), x0 + 1, picture.width),
            y1 = std::clamp(int(std::ceil(region.centre.y() + reach)), y0 + 1, picture.height);
  cv::Mat part = view_of(picture)(cv::Rect(x0, y0, x1 - x0, y1 - y0));
  double fx = 1, fy = 1;  // px of the reduced part per px of the picture
  if (region.side > 1.5 * side) {
    const double wanted = side / region.side;
    cv::Mat reduced;
    cv::resize(part, reduced,
               {std::max(1, int(std::lround(part.cols * wanted))),
                std::max(1, int(std::lround(part.rows * wanted)))},
               0, 0, cv::INTER_AREA);
    fx = double(reduced.cols) / part.cols, fy = double(reduced.rows) / part.rows;
    part = reduced;
  }
  // -- Pixel (i, j) shows the place centre + R ((i, j) + 1/2 - side / 2) * scale; OpenCV counts from centres.
  const double scale = region.side / side, half = 0.5 * (side - 1);
  const double ox = region.centre.x() - x0 - scale * half * (c - s),
               oy = region.centre.y() - y0 - scale * half * (s + c);
  const cv::Matx23d from(fx * scale * c, -fx * scale * s, fx * ox - 0.5, fy * scale * s, fy * scale * c,
                         fy * oy - 0.5);
  cv::Mat square;
  cv::warpAffine(part, square, from, {side, side}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, border);
  Image8 rgb(side, side, 3);
  cv::Mat out = view_of(rgb);
  if (square.channels() == 1)
    cv::cvtColor(square, out, cv::COLOR_GRAY2RGB);
  else
    square.copyTo(out);
  return rgb;
}

// Whether some of the region, which has a size, is in the picture.
bool is_in(const MeshRegion& region, const Image8& picture) {
  const double reach = 0.5 * region.side;
  return !picture.empty() && region.side >= 4 && region.centre.allFinite() && region.centre.x() > -reach &&
         region.centre.y() > -reach && region.centre.x() < picture.width + reach &&
         region.centre.y() < picture.height + reach;
}

// Of a place in the region's square of side x side px: where it is in the picture.
Vec2d place_in(const MeshRegion& region, double x, double y, int side) {
  const double c = std::cos(region.roll), s = std::sin(region.roll), scale = region.side / side;
  const double u = (x - 0.5 * side) * scale, v = (y - 0.5 * side) * scale;
  return region.centre + Vec2d(c * u - s * v, s * u + c * v);
}

// Of the detector's 896 anchors: 16 x 16 cells with two each, then 8 x 8 with six.
Vec2d anchor(int i) {
  const bool fine = i < 512;
  const int cells = fine ? 16 : 8, cell = fine ? i / 2 : (i - 512) / 6;
  return {(cell % cells + 0.5) / cells, (cell / cells + 0.5) / cells};
}

double overlap_of(const MeshRegion& a, const MeshRegion& b) {
  const auto shared = [](double p, double q, double m, double n) {
    return std::max(0.0, std::min(p + m / 2, q + n / 2) - std::max(p - m / 2, q - n / 2));
  };
  const double both =
      shared(a.centre.x(), b.centre.x(), a.side, b.side) * shared(a.centre.y(), b.centre.y(), a.side, b.side);
  return both / (a.side * a.side + b.side * b.side - both);
}

// The surest of those that overlap.
template <class T, class Score, class Region>
std::vector<T> without_doubles(std::vector<T> all, const Score& score, const Region& region) {
  std::ranges::stable_sort(all, std::ranges::greater{}, score);
  std::vector<T> kept;
  for (T& one : all)
    if (std::ranges::none_of(kept,
                             [&](const T& k) { return overlap_of(region(k), region(one)) > kSameFace; }))
      kept.push_back(std::move(one));
  return kept;
}

}  // namespace

MeshRegion region_round(const std::array<Vec2d, kMeshCount>& points) {
  const Vec2d eyes = points[kLeftCorner] - points[kRightCorner];
  MeshRegion region;
  region.roll = std::atan2(eyes.y(), eyes.x());
  const Vec2d along(std::cos(region.roll), std::sin(region.roll)), down(-along.y(), along.x());
  Vec2d low = Vec2d::Constant(1e12), high = Vec2d::Constant(-1e12);
  for (const Vec2d& p : points) {
    const Vec2d turned(p.dot(along), p.dot(down));
    low = low.cwiseMin(turned), high = high.cwiseMax(turned);
  }
  const Vec2d middle = 0.5 * (low + high);
  region.centre = middle.x() * along + middle.y() * down;
  region.side = kRound * (high - low).maxCoeff();
  return region;
}

bool is_same_region(const MeshRegion& a, const MeshRegion& b) {
  const double turn = std::remainder(a.roll - b.roll, 2 * M_PI);
  return std::abs(turn) < kSameTurn && (a.centre - b.centre).norm() < kSameShift * b.side &&
         a.side < kSameScale * b.side && b.side < kSameScale * a.side;
}

struct FaceNetwork::Impl {
  OnnxNetwork mesh, detector, iris;
};

FaceNetwork::FaceNetwork(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FaceNetwork::~FaceNetwork() = default;
FaceNetwork::FaceNetwork(FaceNetwork&&) noexcept = default;
FaceNetwork& FaceNetwork::operator=(FaceNetwork&&) noexcept = default;

Result<FaceNetwork> FaceNetwork::installed() {
  auto mesh = load_installed_network(InstalledNetwork::face468, kCopies);
  if (!mesh) return mesh.error();
  auto detector = load_installed_network(InstalledNetwork::face_detector, kCopies);
  if (!detector) return detector.error();
  auto iris = load_installed_network(InstalledNetwork::iris, kCopies);
  if (!iris) return iris.error();
  return FaceNetwork(std::make_unique<Impl>(Impl{std::move(*mesh), std::move(*detector), std::move(*iris)}));
}

std::optional<FaceMesh> FaceNetwork::look(const Image8& picture, const MeshRegion& region) const {
  if (!is_in(region, picture)) return std::nullopt;
  const NetworkInput input{"",
                           picture_tensor(cut(picture, region, kMeshSide, cv::BORDER_REPLICATE), 1 / 255.0)};
  static const std::string kOutputs[] = {"conv2d_21", "conv2d_31"};
  const auto output = impl_->mesh.run({&input, 1}, kOutputs);
  if (!output || (*output)[0].values.size() != 3 * kMeshCount || (*output)[1].values.empty())
    return std::nullopt;
  FaceMesh mesh;
  mesh.region = region;
  mesh.presence = sigmoid((*output)[1].values[0]);
  for (std::size_t i = 0; i < kMeshCount; ++i)
    mesh.points[i] = place_in(region, (*output)[0].values[3 * i], (*output)[0].values[3 * i + 1], kMeshSide);
  return mesh;
}

std::optional<FaceMesh> FaceNetwork::settle(const Image8& picture, const MeshRegion& start) const {
  auto mesh = look(picture, start);
  for (int looks = 1; mesh && looks < kLooks; ++looks) {
    const MeshRegion wanted = region_round(mesh->points);
    if (is_same_region(mesh->region, wanted)) break;
    mesh = look(picture, wanted);
  }
  if (!mesh || mesh->presence < kPresent) return std::nullopt;
  return mesh;
}

std::optional<LidMargins> FaceNetwork::lids(const Image8& picture,
                                            const std::array<Vec2d, kMeshCount>& points) const {
  // Corners as the picture shows them, left to right. The network knows left eyes: a right one is mirrored.
  constexpr int kCorners[2][2] = {{33, 133}, {362, 263}};
  LidMargins margins;
  for (std::size_t side = 0; side < 2; ++side) {
    const Vec2d from = points[std::size_t(kCorners[side][0])], to = points[std::size_t(kCorners[side][1])];
    const Vec2d along = to - from, middle = 0.5 * (from + to);
    const MeshRegion region{middle, kEyeRound * along.norm(), std::atan2(along.y(), along.x())};
    if (!is_in(region, picture)) return std::nullopt;
    Image8 eye = cut(picture, region, kEyeSide, cv::BORDER_REPLICATE);
    const bool right = side == 0;
    cv::Mat pixels = view_of(eye);
    if (right) cv::flip(pixels, pixels, 1);
    const auto output = impl_->iris.run(picture_tensor(eye, 1 / 255.0), "output_eyes_contours_and_brows");
    if (!output || output->values.size() < 3 * kLidCount) return std::nullopt;
    for (std::size_t i = 0; i < kLidCount; ++i) {
      const double x = output->values[3 * i], y = output->values[3 * i + 1];
      margins[side][i] = place_in(region, right ? kEyeSide - x : x, y, kEyeSide);
    }
  }
  return margins;
}

std::vector<FaceCandidate> FaceNetwork::candidates(const Image8& picture, double x, double y,
                                                   double side) const {
  if (picture.empty() || !(side >= 1)) return {};
  const MeshRegion square{Vec2d(x + 0.5 * side, y + 0.5 * side), side, 0};
  const NetworkInput input{"", picture_tensor(cut(picture, square, kDetectorSide, cv::BORDER_CONSTANT),
                                              1 / 127.5, {127.5, 127.5, 127.5})};
  static const std::string kOutputs[] = {"regressors", "classificators"};
  const auto output = impl_->detector.run({&input, 1}, kOutputs);
  constexpr int kAnchors = 896, kNumbers = 16;
  if (!output || (*output)[0].values.size() != kAnchors * kNumbers || (*output)[1].values.size() != kAnchors)
    return {};
  std::vector<FaceCandidate> found;
  for (int i = 0; i < kAnchors; ++i) {
    const double score = sigmoid((*output)[1].values[std::size_t(i)]);
    if (!(score > kCandidate)) continue;
    const float* v = &(*output)[0].values[std::size_t(i) * kNumbers];
    const auto place = [&](int k) {
      return Vec2d(Vec2d(x, y) + side * (anchor(i) + Vec2d(v[k], v[k + 1]) / kDetectorSide));
    };
    const Vec2d eyes = place(6) - place(4);  // the person's right eye comes first
    FaceCandidate one;
    one.region.centre = place(0);
    one.region.side = kRound * side * std::max(v[2], v[3]) / kDetectorSide;
    one.region.roll = std::atan2(eyes.y(), eyes.x());
    one.score = score;
    found.push_back(one);
  }
  return without_doubles(std::move(found), &FaceCandidate::score,
                         [](const FaceCandidate& f) { return f.region; });
}

std::vector<FaceMesh> FaceNetwork::find(const Image8& picture) const {
  if (picture.empty()) return {};
  const double shorter = std::min(picture.width, picture.height),
               longer = std::max(picture.width, picture.height);
  std::vector<FaceMesh> faces;
  const auto search = [&](double x, double y, double side) {
    for (const FaceCandidate& one : candidates(picture, x, y, side))
      if (auto mesh = settle(picture, one.region)) faces.push_back(std::move(*mesh));
  };
  // Squares of a side, each half over its neighbours', so that a face lies whole in one of them.
  const auto search_squares = [&](double side) {
    const auto steps = [&](int length) {
      return int(std::ceil(std::max(0.0, length - side) / (0.5 * side)));
    };
    const int nx = steps(picture.width), ny = steps(picture.height);
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        search(nx ? (picture.width - side) * i / nx : 0.5 * (picture.width - side),
               ny ? (picture.height - side) * j / ny : 0.5 * (picture.height - side), side);
  };
  search(0.5 * (picture.width - longer), 0.5 * (picture.height - longer), longer);
  if (faces.empty() && longer > 1.2 * shorter) search_squares(shorter);
  if (faces.empty()) search_squares(0.5 * shorter);
  return without_doubles(std::move(faces), &FaceMesh::presence, [](const FaceMesh& f) { return f.region; });
}

}  // namespace likeness
