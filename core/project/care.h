// The care for a project: its clip found again after it moved, and everything of a person removed on request.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/project/project.h"

namespace likeness {

// Why the project's clip cannot be read where it was, with how to name its new place; nullopt: it is there.
std::optional<Error> missing_clip(const Project& project);

// The same clip at another place. What was imported must have been imported from it; a project that has read
// nothing yet takes any clip. Takes the project's lock.
Result<Project> relink_clip(const std::filesystem::path& folder, const std::filesystem::path& clip);

// That something may be written there: `out` is neither a clip of the project, further ones included, nor
// what the project keeps or what lies in it; a performance that exists, or what was painted, is no more
// replaced than the track. option: what the path was given as, for the message.
Result<void> check_free(const Project& project, const std::filesystem::path& out, std::string_view option);
// The same of whoever writes beside no project of its own: no project's files.
Result<void> check_free(const std::filesystem::path& out, std::string_view option);

// Whether these frames may be left out of the training: known ones that train. Held-out frames measure the
// avatar; leaving one out would flatter it, so they are refused by number.
Result<void> check_left_out(const Capture& capture, const std::vector<int>& frames);

// Whether these frames may be named as the person's resting face: known ones that are not held out.
Result<void> check_rest_frames(const Capture& capture, const std::vector<int>& frames);

struct DeletedPerson {
  std::uint64_t bytes = 0;
  bool folder_gone = false;
  std::vector<std::string> links;            // names that were links; what they lead to is as it was
  std::vector<std::filesystem::path> clips;  // the person's films, which stay where they are
  std::vector<std::string> kept;  // names in the folder that are none of Likeness's, or were to be kept
  // False: the project was damaged and no longer tells which film is the clip. Folders with films in them
  // were kept, exports among them.
  bool clip_known = true;
};

// What was done, in a sentence or two.
std::string deletion_words(const DeletedPerson& deleted);

// Removes what Likeness made of the person: frames, masks with what was painted on them, tracks, checkpoints,
// the avatar, performances, what was compared, and the whole folder of exports unless it is kept. Never the
// clip, nor a folder that it lies in, and nothing else that Likeness did not write; the folder itself goes
// when it is empty. Refused while another process works on the project. Also of a project whose project.json
// is damaged (core/project/damaged_project.h).
Result<DeletedPerson> delete_person(const std::filesystem::path& folder, bool keep_exports);

// Forgets a further clip (core/project/further_clips.h), and what was made of it; never the clip itself.
Result<void> remove_further_clip(Project& project, int number);

}  // namespace likeness
