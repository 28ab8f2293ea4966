// A project's clip with another track: by fewer or more steps of the tracker, with something taken out of it,
// or by another head model. A project of its own, beside the studied one, whose pictures it shares.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/project/project.h"
#include "core/scene/track.h"

namespace likeness {

struct TrackVariant {
  std::string step;  // the last step of the tracker (track_steps); empty: the project's own track
  void (*change)(Track& track, const HeadModel& model) = nullptr;  // what is taken out of it
  bool same_mattes = false;    // what is taken out of the track leaves the mattes as they are
  bool maps = true;            // with the project's detail maps, where it has any
  bool person_network = true;  // mattes with the person network that the project chose

  bool is_the_project_s() const { return step.empty() && change == nullptr && maps && person_network; }
};

// The project must be imported, aligned and matted (regions/ frozen); its options give clip and head model,
// and it is not changed. Further clips are left out. Works in `folder`: tracks, mattes and the new project
// are kept there, named by what they were made from, and a second call finds them. `name` is of the project.
Result<Project> make_variant_project(const Project& project, const std::string& name,
                                     const TrackVariant& variant, const std::filesystem::path& folder,
                                     const Progress& progress, std::stop_token stop);

}  // namespace likeness
