// How much of each painted attribute every frame of a project shows, as its training found it.
//
//   attribute_values.json       what the avatar's training made of it, for every tracked frame
//   attribute_values.next.json  of the training at work, or of one that was stopped
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/project/project.h"
#include "core/render/avatar.h"
#include "core/scene/avatar_pose.h"
#include "core/scene/track.h"

namespace likeness {

std::filesystem::path attribute_values_path(const Project& project);
std::filesystem::path next_attribute_values_path(const Project& project);

// An attribute's amounts over the clip.
struct AttributeCourse {
  std::string name;
  std::vector<int> frames;            // numbers in the source, ascending
  std::vector<float> values, doubts;  // as FrameAmount (core/train/attribute_values.h)
  std::vector<std::uint8_t> annotated;
  int painted_frames = 0, skipped_frames = 0;  // annotations used; of frames that do not train any more
  double left_out_error = 0;                   // rms of the annotated values, each predicted by the others
  int unlike_any = 0;                          // frames that look like none of the annotated ones
};
// In words, one line.
std::string course_words(const AttributeCourse& course);

Result<void> write_attribute_values(const std::filesystem::path& path,
                                    std::span<const AttributeCourse> courses);
Result<std::vector<AttributeCourse>> read_attribute_values(const std::filesystem::path& path);

// 0 where the course has no such frame.
float amount_at(const AttributeCourse& course, int frame);

// The amounts of an avatar's attributes in a frame of its project, in the avatar's order; empty for an avatar
// without any. 0 where the frame has none.
std::vector<float> frame_amounts(const Avatar& avatar, std::span<const AttributeCourse> courses, int frame);
// A tracked frame's pose with these amounts, as an avatar of its project is asked for that frame. No detail:
// the scores of a frame's own map are for the trainings (take_detail), and without them an avatar shows those
// that the articulation tells, in held-out frames and all others alike.
AvatarPose frame_pose(const Avatar& avatar, std::span<const AttributeCourse> courses,
                      const TrackedFrame& tracked);
// The courses of the avatar's project; none of an avatar without attributes.
Result<std::vector<AttributeCourse>> read_courses(const Project& project, const Avatar& avatar);

}  // namespace likeness
