// What the detail maps given to a project (fit --displacement) say of its clip, kept in detail.npz for the
// trainings. The folder must stay where it is as long as the project asks for it:
//
//   vertices (K) int32; mean (K), basis (K, R), middle (E + 3), rows (R, E + 3), low (R), high (R) float32:
//   core/head/expression_detail.h; frames (F) int32, scores (F, R) float32: of the training frames' own maps
//   track (n) int32: letters of the hash of what the track was fitted from
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/head/expression_detail.h"
#include "core/project/project.h"
#include "core/scene/track.h"
#include "core/train/train.h"

namespace likeness {

struct ProjectDetail {
  ExpressionDetail detail;
  std::map<int, Eigen::VectorXf> scores;  // by frame, of training frames
  std::string track_inputs;               // what the track, by whose faces it was learnt, was fitted from
};

struct DetailReport {
  std::string message;  // in words, with its numbers
  std::vector<std::string> warnings;
};

// Learns detail from the project's folder of maps and the faces of its track: of training frames alone, for
// what is shared must not know the held-out ones. Ten of them must have maps.
Result<ProjectDetail> learn_project_detail(const std::filesystem::path& maps, const Capture& capture,
                                           const Track& track, const HeadModel& model, DetailReport& report);

Result<void> write_project_detail(const Project& project, const ProjectDetail& detail);
Result<void> forget_project_detail(const Project& project);
// nullopt: no maps were given.
Result<std::optional<ProjectDetail>> read_project_detail(const Project& project, const HeadModel& model);

// The detail of a set's first clip, and of each of its views the scores of its own map where there is one.
void take_detail(const ProjectDetail& detail, TrainingSet& set);

}  // namespace likeness
