// The attributes painted in a project (core/matte/attributes.h), carried over its clip: a region of the
// canonical face each, and how much of it every frame shows.
//
//   attributes.json        what was painted; absent: nothing
//   attribute_values.json       what the avatar's training made of it, for every tracked frame
//   attribute_values.next.json  of the training at work, or of one that was stopped
#pragma once

#include <filesystem>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/matte/attributes.h"
#include "core/project/project.h"
#include "core/render/avatar.h"
#include "core/scene/avatar_pose.h"
#include "core/scene/track.h"
#include "core/train/attribute_region.h"
#include "core/train/train.h"

namespace likeness {

std::filesystem::path attributes_path(const Project& project);
std::filesystem::path attribute_values_path(const Project& project);
std::filesystem::path next_attribute_values_path(const Project& project);

// None where the file is absent.
Result<PaintedAttributes> read_project_attributes(const Project& project);
// No attributes: the file goes, so that the project is as it was.
Result<void> save_project_attributes(const Project& project, const PaintedAttributes& attributes);
// Only what changed since `base`, so that what another program painted meanwhile stays.
Result<void> save_attribute_changes(const Project& project, const PaintedAttributes& base,
                                    const PaintedAttributes& attributes);
// Renames the file to attributes.old.json, or with a number. Returns its new place.
Result<std::filesystem::path> set_aside_attributes(const Project& project);
// Whether a project's file of this name holds attributes, set aside or not.
bool is_attributes_file(const std::string& name);
// Of the file's content; empty without one.
std::string attributes_hash(const Project& project);

// That an annotation can be taken: a name that no action of the head model has, a value of -1..1, a frame
// that trains.
Result<void> check_annotation(const Project& project, std::string_view name,
                              const AttributeAnnotation& annotation);

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

struct FoundAttribute {
  AttributeRegion region;
  AttributeCourse course;          // of the project's own frames, held-out ones included
  std::vector<float> view_values;  // of the set's views
};
// set: with its pictures. A held-out frame's amount comes from its own picture and its held-out neighbours;
// it teaches nothing. An Error where fewer than two frames are left, all show the same amount, or no painted
// pixel meets the head.
Result<std::vector<FoundAttribute>> find_attributes(const Project& project, const PaintedAttributes& painted,
                                                    const TrainingSet& set, const Progress& progress,
                                                    std::stop_token stop, const RegionOptions& region = {});
// Gives the set its attributes and the views their amounts.
void take_attributes(const std::vector<FoundAttribute>& found, TrainingSet& set);
// Both, for whatever was painted in the project.
Result<std::vector<FoundAttribute>> add_attributes(const Project& project, TrainingSet& set,
                                                   const Progress& progress, std::stop_token stop);

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
