// Further clips of the person of a project, filmed at another place or on another day: what the first one
// never showed of the head is learnt from them. Each is a project of its own in clips/2, clips/3, ... up to
// its mattes, with the choices and the person of the project it belongs to, and without an avatar; place,
// light and clothes of the avatar stay the first clip's.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/clip_seconds.h"
#include "core/base/result.h"
#include "core/project/project.h"

namespace likeness {

inline constexpr int kFirstFurtherClip = 2;  // number of the first one that may be added

// Whether this is one, opened through the project it belongs to.
bool is_further(const Project& project);

// clips/NUMBER
std::filesystem::path further_clip_folder(const Project& project, int number);

// With the choices of the project it belongs to, which follow that one's, and its own clip.
Result<Project> open_further_clip(const Project& project, int number);

// Another clip of the same person, or some seconds of one, read and tracked by the next run. Refused: what
// serves already, so that nothing counts twice and nothing that is held out is learnt from; seconds that the
// clip does not have; a clip that cannot be read; and while another process works on the project. Returns its
// number.
Result<int> add_further_clip(Project& project, const std::filesystem::path& video,
                             std::optional<CameraKind> camera = std::nullopt,
                             const ClipSeconds& seconds = {});

// For lists and messages: "Clip 2 (film.mp4)", "Clip 3 (film.mp4 from 3 s to 8 s)".
std::string further_clip_name(const Project& further, int number);

}  // namespace likeness
