// Pictures of a demo's person that its film does not hold: from any side, with any expression, in the light
// of the film; and where head, face and forehead are in them.
#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/lab/truth/track_truth.h"
#include "core/matte/read_regions.h"
#include "core/synth/demo_stage.h"

namespace likeness {

struct PersonModel;

struct TruthPicture {
  Shot shot;         // how it was taken; the camera is the film's, uncropped
  Image8 rgb, room;  // (size, size, 3) as a project's pictures are cropped and resized; the room alone
  Regions regions;   // of that size
  Image8 skin;       // of the face: neither eyes nor mouth
  Image8 forehead;   // of the skin
  std::vector<float> depth;  // (size * size) m along the pixel's unit ray to the head's surface; 0: none
};

// Takes them, and keeps what is slow in a folder, so that a second study of the same film takes none again.
class TruthCamera {
 public:
  // film: as the demo was filmed. truth: of that film. capture: of the project that imported it. folder: may
  // be empty: nothing is kept. Pictures of another crop or size have a folder of their own in it.
  TruthCamera(const DemoOptions& film, const TrackTruth& truth, const Capture& capture,
              const std::filesystem::path& folder);
  ~TruthCamera();

  const HeadModel& model() const { return stage_.model(); }
  const HeadShape& shape() const { return stage_.shape(); }
  // The person at rest, as at the film's beginning, looking into its camera.
  Shot at_rest() const;
  // The camera of `shot` moved round the head by degrees, as AskedView has them; the head keeps its place in
  // the picture.
  Shot seen_from(Shot shot, double yaw_deg, double pitch_deg) const;
  Shot of_frame(int frame) const { return stage_.shot(frame); }
  float brow_line() const { return brow_line_; }  // m, head frame at rest: the forehead lies above it

  // name: of the picture's files. Error: a stop, or a folder that cannot be written.
  Result<TruthPicture> take(const std::string& name, const Shot& shot, std::stop_token stop);

 private:
  Result<Image8> kept(const std::string& name, int channels) const;

  DemoStage stage_;
  const Capture& capture_;
  std::unique_ptr<const PersonModel> person_;
  std::vector<std::uint8_t> face_skin_;  // (F)
  float brow_line_ = 0;
  std::filesystem::path folder_;
};

}  // namespace likeness
