// A film of an avatar, picture by picture, to an mp4, a folder of PNGs, or one PNG. Shared by the command
// line and the window.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/export/provenance.h"
#include "core/project/open_avatar.h"
#include "core/render/backend.h"
#include "core/render/film.h"
#include "core/render/pose_avatar.h"
#include "core/render/render.h"

namespace likeness {

// What a file made from the avatar says of itself.
Provenance provenance_of(const OpenedAvatar& opened, std::chrono::system_clock::time_point made_at);

struct FilmOptions {
  std::filesystem::path out;  // .mp4, .png, or a folder
  // "plate": the background as the resting camera saw it, and what a camera that zooms or shifts there sees
  // of it; of a hand-held one, what the film's camera sees of it. "room": the surroundings as a moving camera
  // taught them, seen from each frame's camera. A colour such as #e8e8e8, or a picture file. Empty: if the
  // film's camera rests, the plate, or else the room; otherwise a light grey.
  std::string background;
  bool camera_rests = true;
  int width = 0;  // px of every picture; 0 = as the film's cameras have it
  RenderQuality quality = RenderQuality::final;
  RenderPlace place;   // where the avatar is rendered; a room behind it is always rendered on the processor
  bool alpha = false;  // transparent background, PNG only
  bool mark = false;   // a visible line of text (mark.h); what the file says of itself is always written
  std::chrono::system_clock::time_point made_at =
      std::chrono::system_clock::now();  // as recorded in the file
  double frames_per_second = 25;
  std::vector<double> times_s = {};  // of the frames, the first one's 0; empty: the steady rate's
  int beside_width = 0;  // px; > 0: `beside` gives a picture of this width for the left of every frame
  std::function<Result<Image8>(std::size_t frame)> beside;
};

double frame_time_s(const FilmOptions& options, std::size_t frame);

// What is wrong with these options for this avatar, if anything; cheap, so that it can be reported before
// long work.
Result<void> check_film(const Avatar& avatar, const Intrinsics& picture, std::size_t frames,
                        const FilmOptions& options);

// One picture of a film as it would be written, but for what is beside it; on the processor.
Result<Image8> film_picture(const Avatar& avatar, const AvatarRig& rig, const Camera& camera,
                            const AvatarPose& pose, const FilmOptions& options);

// Number of frames written. A folder of pictures that stand at times of their own has a list of them,
// pictures.ffconcat, too: ffmpeg -f concat reads it.
Result<int> write_film(const OpenedAvatar& opened, const Film& film, const FilmOptions& options,
                       const Progress& progress, std::stop_token stop);

}  // namespace likeness
