// Turning a clip of a driver's performance into a film of an avatar.
#pragma once

#include <filesystem>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/drive/drive.h"
#include "core/project/open_avatar.h"
#include "core/scene/avatar_pose.h"
#include "core/scene/track.h"

namespace likeness {

struct DriveRequest {
  std::filesystem::path video;
  std::filesystem::path track;           // of the clip: read if it exists, otherwise written; empty = neither
  std::filesystem::path head_model;      // the driver's; empty = the one the avatar was made with
  std::filesystem::path landmark_model;  // as landmark_source takes it
  DriveOptions options;
  std::vector<std::pair<std::string, float>> attributes;  // of the avatar's, held at these amounts
};

struct DrivenClip {
  Track track;
  std::vector<DrivenFrame> frames;
  std::vector<std::pair<std::string, float>> gains;  // calibrated and requested ones that are not 1
  double frames_per_second = 25;                     // of the clip; where that varies, of most of its frames
  std::vector<float> attributes;                     // amounts, in the avatar's order
  std::vector<std::string> warnings = {};            // about the clip, in sentences
};

// Tracks the clip and carries its performance over. Frames keep their times, which many phones space
// unevenly.
Result<DrivenClip> drive_clip(const OpenedAvatar& opened, const DriveRequest& request,
                              const Progress& progress, std::stop_token stop);

// Checks that `out` is not a file that the request reads, or writes for another purpose.
Result<void> check_out(const DriveRequest& request, const std::filesystem::path& out);

// Whether the frames follow each other at frames_per_second, but for a container's rounding.
bool is_steady(const DrivenClip& clip);

// Since the first.
std::vector<double> times_of(std::span<const DrivenFrame> frames);

std::vector<AvatarPose> film_poses(const DrivenClip& clip);

}  // namespace likeness
