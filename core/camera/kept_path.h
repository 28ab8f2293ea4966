// What aligning reads of a clip, gathered while import decodes the clip and kept in a folder, so that
// align_clip need not decode the clip again: the background's motion; of a moving camera also the keyframes'
// pictures and every frame small and grey.
//
// All of it is only a copy of what align_clip would find by itself, which it does where something is missing
// or was made from other inputs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/camera/align_options.h"
#include "core/camera/motion.h"

namespace likeness {

// What the motion depends on.
std::string motion_inputs(const std::string& video_hash, const AlignOptions& options);
Result<void> keep_motion(const std::filesystem::path& folder, const std::string& inputs,
                         const BackgroundMotion& motion);
// nullopt: none of these inputs.
std::optional<BackgroundMotion> kept_motion(const std::filesystem::path& folder, const std::string& inputs);

// The pictures that were measured, of the same inputs.
Result<void> keep_background(const std::filesystem::path& folder, const std::string& inputs,
                             const BackgroundPictures& pictures);
std::optional<BackgroundPictures> kept_background(const std::filesystem::path& folder,
                                                  const std::string& inputs);

// The camera goes somewhere, so align_clip solves its path.
bool needs_path(const BackgroundMotion& motion, const AlignOptions& options);

// What the keyframes' pictures for colmap depend on.
std::string keyframe_inputs(const std::string& video_hash, const BackgroundMotion& motion,
                            const std::vector<int>& keyframes, bool masked, const AlignOptions& options);

// Width at which colmap sees a picture. A small one is enlarged: its features are too fine for most scales of
// the detector, and half as many again in each direction give three times as many.
int solve_width(int width, int wanted);

// The frames whose camera is found by following points: all outside rests, a few of each rest, none of
// `solved`.
std::set<int> frames_between(const BackgroundMotion& motion, const std::set<int>& solved);

// Name of a keyframe's picture for colmap.
std::string keyframe_name(int frame);

// Gathers the pictures for the path of a moving camera; of every frame sampled, RGB, in order.
class PathPictures {
 public:
  // folder: exists.
  static Result<PathPictures> create(const std::filesystem::path& folder, const std::string& video_hash,
                                     const BackgroundMotion& motion, PersonMask person,
                                     const AlignOptions& options);
  // What they will take on the disk.
  static std::uint64_t expected_bytes(const BackgroundMotion& motion, const AlignOptions& options);
  ~PathPictures();
  PathPictures(PathPictures&&) noexcept;
  PathPictures& operator=(PathPictures&&) noexcept;

  Result<void> add(const VideoFrame& frame);
  Result<void> finish();

 private:
  struct State;
  explicit PathPictures(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

std::filesystem::path kept_keyframes(const std::filesystem::path& folder);  // a work folder (workplace.h)
std::filesystem::path kept_greys(const std::filesystem::path& folder);      // core/video/grey_pictures.h

// Nothing but the motion is needed once the cameras are known. Also removes the background's pictures.
void drop_path_pictures(const std::filesystem::path& folder);

}  // namespace likeness
