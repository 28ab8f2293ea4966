// Faces and their 68 landmarks in one picture, by one of two sources (docs/METHOD.md): the face network
// (network_landmarks.h), or dlib's HOG detector and its shape predictor, which is run from many perturbed
// boxes, of which the densest cluster is averaged. Pixels of the picture given.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/image/image.h"

namespace likeness {

struct FaceBox {
  double x = 0, y = 0, width = 0, height = 0;  // px
  double score = 0;  // of the detector, higher is more certain; below 0 only where a face was a moment ago
};

// Which source: "network", "dlib" (the system's or the bundled model), or a file, a dlib 68-point predictor
// of the user's own. Empty: the network where it is installed, else dlib.
inline constexpr const char* kNetworkLandmarks = "network";
inline constexpr const char* kDlibLandmarks = "dlib";
enum class LandmarkSource { network, dlib };
LandmarkSource landmark_source(const std::filesystem::path& choice);
// For results that depend on the choice; empty for the system's dlib model.
std::string landmark_source_hash(const std::filesystem::path& choice);

// Shared area over joint area, 0..1.
double overlap(const FaceBox& a, const FaceBox& b);

struct Landmarks {
  std::array<Vec2d, kLandmarkCount> points;     // px
  std::array<double, kLandmarkCount> spread{};  // px, rms over the cluster: the uncertainty
  double cluster_share = 0;                     // share of the perturbed runs that agree, 0..1
  int runs = 0;                                 // of the predictor
};

// How many perturbed boxes dlib's predictor runs from; each costs about a millisecond. The first runs suffice
// if they agree with each other and with the hint; otherwise the rest are made too. The network looks once
// for every eight of `most`, four times at most; each look costs 4 ms.
struct LandmarkEffort {
  int first = 32, most = 32;  // rounded up to whole rings of 4 scales
};

// Mean spread of the inner points (17..67), px.
double inner_spread(const Landmarks& landmarks);

// Where a tracked head predicts the landmarks; it selects the cluster, not the points' places.
struct LandmarkHint {
  std::array<Vec2d, kLandmarkCount> points;  // px
  double sigma = 4;                          // px, of its rigid points (nose, eye corners)
};

// Holds the models, which detectors of one choice share. The const members may run on many threads at once.
class FaceDetector {
 public:
  // choice: as landmark_source takes it.
  static Result<FaceDetector> load(const std::filesystem::path& choice = {});
  ~FaceDetector();
  FaceDetector(FaceDetector&&) noexcept;
  FaceDetector& operator=(FaceDetector&&) noexcept;

  LandmarkSource source() const;
  // Best first; faces of at least about 60 px. before: where a face was a moment ago. A face in its expected
  // place needs less evidence than another: heads turn, lamps go dim and hands cover mouths, but faces do not
  // vanish (the two thresholds of Canny's edges, IEEE PAMI 8 (1986)).
  std::vector<FaceBox> detect(const Image8& rgb, const FaceBox* before = nullptr) const;
  // rgb: one or three channels.
  Landmarks landmarks(const Image8& rgb, const FaceBox& box, std::uint32_t seed = 0,
                      const LandmarkHint* hint = nullptr, const LandmarkEffort& effort = {}) const;

 private:
  struct Impl;
  explicit FaceDetector(std::shared_ptr<const Impl> impl);
  std::shared_ptr<const Impl> impl_;
};

}  // namespace likeness
