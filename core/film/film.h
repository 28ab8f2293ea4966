// A film of an avatar: one picture after the other to an mp4, a folder of PNGs, or one PNG. Shared by
// whatever renders: the command line and the window.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/film/provenance.h"
#include "core/head/head_model.h"
#include "core/project/project.h"
#include "core/render/avatar.h"
#include "core/render/backend.h"
#include "core/render/render.h"

namespace likeness {

// A project's avatar with the head model it was made with.
struct OpenedAvatar {
  Project project;
  Avatar avatar;
  HeadModel model;
  std::string avatar_hash;  // of avatar.bin
};
Result<OpenedAvatar> open_avatar(const std::filesystem::path& folder);

// What a file made from the avatar says of itself.
Provenance provenance_of(const OpenedAvatar& opened, std::chrono::system_clock::time_point made_at);

// What the avatar does in one frame.
struct FilmPose {
  Pose world_from_head = Pose::Identity(), world_from_torso = Pose::Identity();  // m
  Articulation articulation;
  std::vector<float> attributes{};  // amounts, in the avatar's order; empty: all at rest
};

struct Film {
  std::vector<Camera> cameras;  // of one picture size
  std::vector<FilmPose> poses;  // one a camera
};

struct FilmOptions {
  std::filesystem::path out;  // .mp4, .png, or a folder
  // "plate": as the resting camera saw it. "room": as a moving one taught it, seen from each frame's camera.
  // A colour such as #e8e8e8, or a picture file. Empty: where the film's camera rests the plate, or the room
  // where there is none; else a light grey.
  std::string background;
  bool camera_rests = true;
  int width = 0;  // px of every picture; 0 = as the film's cameras have it
  RenderQuality quality = RenderQuality::final;
  RenderPlace place;   // where the avatar is rendered; a room behind it is the processor's
  bool alpha = false;  // transparent background, PNG only
  bool mark = false;   // a visible line of text (mark.h); what the file says of itself is always written
  std::chrono::system_clock::time_point made_at = std::chrono::system_clock::now();  // as the file says it
  double frames_per_second = 25;
  int beside_width = 0;  // px; > 0: `beside` gives a picture of this width for the left of every frame
  std::function<Result<Image8>(std::size_t frame)> beside;
};

// What is wrong with these options for this avatar, if anything; cheap, so that it can be said before long
// work.
Result<void> check_film(const Avatar& avatar, const Intrinsics& picture, std::size_t frames,
                        const FilmOptions& options);

// Number of frames written.
Result<int> write_film(const OpenedAvatar& opened, const Film& film, const FilmOptions& options,
                       const Progress& progress, std::stop_token stop);

}  // namespace likeness
