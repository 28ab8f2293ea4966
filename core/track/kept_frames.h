// A clip's working pictures and landmarks, found while import decodes the clip and kept in a folder, so that
// track_clip need not decode the clip again. Only a copy of what read_clip_frames finds, which is asked where
// they are missing or were made from other inputs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/track/clip_frames.h"

namespace likeness {

// What they depend on.
Result<std::string> clip_frames_inputs(const std::string& video_hash, const TrackRegion& region,
                                       const std::set<int>& held_out, const TrackOptions& options);

// Gathers them: of every frame sampled, RGB, in order.
class ClipFrameKeeper {
 public:
  // folder: exists. frames: the numbers of all that will be added.
  static Result<ClipFrameKeeper> create(const std::filesystem::path& folder, const std::string& inputs,
                                        ClipFollower follower, const std::vector<int>& frames);
  ~ClipFrameKeeper();
  ClipFrameKeeper(ClipFrameKeeper&&) noexcept;
  ClipFrameKeeper& operator=(ClipFrameKeeper&&) noexcept;

  Result<void> add(const VideoFrame& frame, const std::stop_token& stop);
  Result<void> finish(const std::stop_token& stop);

 private:
  struct State;
  explicit ClipFrameKeeper(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// What the pictures of `frames` frames take on the disk at most.
std::uint64_t kept_clip_bytes(std::size_t frames, const TrackOptions& options);

// nullopt: there are none of these inputs.
std::optional<ClipFrames> kept_clip_frames(const std::filesystem::path& folder, const std::string& inputs);

void drop_clip_frames(const std::filesystem::path& folder);

}  // namespace likeness
