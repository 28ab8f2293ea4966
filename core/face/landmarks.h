// Faces and their 68 landmarks in one picture, by one of two sources (docs/METHOD.md): the face network
// (network_landmarks.h), or dlib's HOG detector and its shape predictor, which is run from many perturbed
// boxes, of which the densest cluster is averaged. Pixels of the picture given.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/face/face_landmarks.h"
#include "core/image/image.h"

namespace likeness {

class KeptWork;  // core/base/kept_work.h

// Which source: "network", "dlib" (the system's or the bundled model), or a file, a dlib 68-point predictor
// of the user's own. Empty: the network where it is installed, else dlib.
inline constexpr const char* kNetworkLandmarks = "network";
inline constexpr const char* kDlibLandmarks = "dlib";
inline constexpr const char* kLandmarkModelHelp =
    "Where a face's landmarks come from: the face network (network), dlib's model (dlib), or a file, a dlib "
    "68-point shape predictor; default: the network where it is installed, else dlib's model";
enum class LandmarkSource { network, dlib };
LandmarkSource landmark_source(const std::filesystem::path& choice);
// For results that depend on the choice; empty for the system's dlib model.
std::string landmark_source_hash(const std::filesystem::path& choice);

// Holds the models, which detectors of one choice share. The const members may run on many threads at once.
class FaceDetector {
 public:
  // choice: as landmark_source takes it.
  static Result<FaceDetector> load(const std::filesystem::path& choice = {});
  ~FaceDetector();
  FaceDetector(FaceDetector&&) noexcept;
  FaceDetector& operator=(FaceDetector&&) noexcept;

  LandmarkSource source() const;
  // What it finds from now on is kept there, and what was found there is not sought again.
  void keep_in(std::shared_ptr<KeptWork> kept) { kept_ = std::move(kept); }
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
  std::vector<FaceBox> seek_faces(const Image8& rgb, const FaceBox* before) const;
  Landmarks seek_landmarks(const Image8& rgb, const FaceBox& box, std::uint32_t seed,
                           const LandmarkHint* hint, const LandmarkEffort& effort) const;
  std::shared_ptr<const Impl> impl_;
  std::shared_ptr<KeptWork> kept_;  // or null
};

}  // namespace likeness
