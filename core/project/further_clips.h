// Further clips of the person of a project, filmed at another place or on another day: what the first one
// never showed of the head is learnt from them. Each is a project of its own in clips/2, clips/3, ... up to
// its mattes, with the choices and the person of the project it belongs to, and without an avatar; place,
// light and clothes of the avatar stay the first clip's.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/project/project.h"
#include "core/project/seen_views.h"
#include "core/train/train.h"

namespace likeness {

inline constexpr int kFirstFurtherClip = 2;  // number of the first one that may be added

// clips/NUMBER
std::filesystem::path further_clip_folder(const Project& project, int number);

// With the choices of the project it belongs to, which follow that one's, and its own clip.
Result<Project> open_further_clip(const Project& project, int number);

// Another clip of the same person, read and tracked by the next run. Refused: the same clip twice, one that
// cannot be read, and while another process works on the project. Returns its number.
Result<int> add_further_clip(Project& project, const std::filesystem::path& video,
                             bool resting_camera = false);
// Forgets the clip, and what was made of it; never the clip itself.
Result<void> remove_further_clip(Project& project, int number);

// One line for lists and messages.
std::string further_clip_name(const Project& further, int number);  // "Clip 2 (film.mp4)"

// The further clips' views for training, without their pictures: those of the head alone
// (TrainingView::further_clip). Their pictures are added by load_further_pictures.
Result<void> add_further_views(const Project& project, const HeadModel& model, TrainingSet& set);
Result<void> load_further_pictures(const Project& project, TrainingSet& set);

// From where the further clips' training pictures show the head. None where the avatar is not the one that
// the project would be trained to now: it may not have learnt from them.
SeenViews learnt_further_views(const Project& project);

}  // namespace likeness
