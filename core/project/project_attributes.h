// The attributes painted in a project (core/matte/attributes.h), carried over its clip: a region of the
// canonical face each, and how much of it every frame shows.
//
//   attributes.json  what was painted; absent: nothing
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/matte/attributes.h"
#include "core/project/attribute_courses.h"
#include "core/project/project.h"
#include "core/train/attribute_region.h"
#include "core/train/train.h"

namespace likeness {

std::filesystem::path attributes_path(const Project& project);

// None where the file is absent.
Result<PaintedAttributes> read_project_attributes(const Project& project);
// No attributes: the file goes, so that the project is as it was.
Result<void> save_project_attributes(const Project& project, const PaintedAttributes& attributes);
// Only what changed since `base`, so that what another program painted meanwhile stays.
Result<void> save_attribute_changes(const Project& project, const PaintedAttributes& base,
                                    const PaintedAttributes& attributes);
// Renames the file to attributes.old.json, or with a number. Returns its new place.
Result<std::filesystem::path> set_aside_attributes(const Project& project);
// Of the file's content; empty without one.
std::string attributes_hash(const Project& project);

// That an annotation can be taken: a name that no action of the head model has, a value of -1..1, a frame
// that trains.
Result<void> check_annotation(const Project& project, std::string_view name,
                              const AttributeAnnotation& annotation);

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

}  // namespace likeness
