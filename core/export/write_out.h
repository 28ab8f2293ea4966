// All output of the program, however it was requested: an avatar posed, performing, or following a clip, as
// pictures, a film or a mesh. Shared by the command line and the window.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/direct/beyond_holds.h"
#include "core/direct/performance.h"
#include "core/drive/drive_clip.h"
#include "core/export/write_film.h"
#include "core/video/copy_sound.h"

namespace likeness {

// Checks that --out names neither a file that the avatar or its pictures are made from, further clips
// included, nor one that the project keeps: none of these is ever replaced.
Result<void> check_not_taken(const OpenedAvatar& opened, const FilmOptions& options);

// What is wrong with writing so many frames of this picture there, if anything; cheap, so that it can be
// reported before long work. Options for pictures only are refused for a mesh.
Result<void> check_output(const Avatar& avatar, const Intrinsics& picture, std::size_t frames,
                          const FilmOptions& options);

// To pictures, or to a mesh where the name asks for one. Number of frames written.
Result<int> write_posed(const OpenedAvatar& opened, const Film& film, const FilmOptions& options,
                        const Progress& progress, std::stop_token stop);

// What an artist directed, its camera included. The frame rate is the performance's.
Result<int> write_performed(const OpenedAvatar& opened, const Performance& performance, FilmOptions options,
                            const Progress& progress, std::stop_token stop);

struct DrivenOutput {
  int frames = 0;
  int bridged = 0;  // frames in which the driver's face was lost
  double frames_per_second = 25;
  CopiedSound sound;
  std::vector<std::pair<std::string, float>> gains;  // that are not 1
  std::vector<std::string> warnings;                 // about the clip, in sentences
  BeyondHolds beyond;  // of the film, what its avatar does not hold; empty, too, where that is not known
};

// Where a driven avatar is seen from, and how it holds its head.
struct DrivenView {
  // For frames at these times; a film of fewer cameras ends with them. Empty: the typical camera throughout.
  std::function<Result<std::vector<Camera>>(std::span<const double> times_s)> cameras;
  // Yaw, pitch and roll of the head as in turned_head, rad: it stays so, and the face alone is driven.
  std::optional<std::array<double, 3>> turn;
};

// What the driver does in a clip: an mp4 with the clip's sound, pictures, a mesh, or (.json) the performance
// as keys. Every frame has its time in the clip, counted from the first that is driven. side_by_side: the
// driver on the left of every picture.
Result<DrivenOutput> write_driven(const OpenedAvatar& opened, const DriveRequest& request,
                                  FilmOptions options, bool side_by_side, const Progress& progress,
                                  std::stop_token stop, const DrivenView& view = {});

}  // namespace likeness
