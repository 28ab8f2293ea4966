// Films that are written in pieces, each whole by itself, so that a kill loses the last seconds only.
#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>
#include <vector>

#include "core/base/result.h"

namespace likeness {

// The hidden name under which a film lies beside its place while it is written in pieces:
// .NAME.recording.PID-NUMBER.part.mp4.
std::filesystem::path unfinished_film_name(const std::filesystem::path& path);

// Held while pieces are written: a process's number says nothing to a container, or to another machine that
// shares the folder. Null: another holds them, or they are gone.
std::shared_ptr<const int> lock_pieces(const std::filesystem::path& pieces);

// Puts what was written there of the film at its place, as a usual mp4, its index at the front; the pieces
// go. Where there is no room for both, the pieces themselves, which are a film, too. An Error: they hold no
// picture (bad_input), or could not be read or put there, and stay.
Result<void> finish_film(const std::filesystem::path& pieces, const std::filesystem::path& path);

// Finishes those that killed processes left in a folder, under their own names or, where these are taken,
// with a number. What holds no picture yet goes. The films' places. stop: between two of them.
std::vector<std::filesystem::path> finish_abandoned_films(const std::filesystem::path& folder,
                                                          std::stop_token stop = {});

}  // namespace likeness
