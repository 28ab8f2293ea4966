// What is asked of a study of models: which of them, how long, and on what they are measured.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace likeness {

// Steps that an earlier study took, by model and seed: repeats it bit for bit on one machine.
using StudySteps = std::map<std::pair<std::string, std::uint64_t>, std::uint64_t>;

struct ModelStudyOptions {
  std::vector<std::string> tables, models;  // empty = all, but those that a table names as more
  double seconds = 90;                      // of processor, of each training of share 1
  std::uint64_t steps = 0;                  // of each grid of share 1, instead of seconds
  std::uint64_t mlp_steps = 0;              // of each perceptron of share 1, instead of seconds
  StudySteps replay;                        // of those that are in it, instead of either
  int size = 128;                           // px; 0 = the project's
  int frames = 8;                           // held out that are measured, evenly chosen; 0 = all
  int rays = 8192;                          // of each step of the grid
  std::filesystem::path lpips;              // a network of perceptual_network.h; empty = none
  int seeds = 3;
  std::uint64_t first_seed = 0;
  // Cells along an axis at which the default model is also stored (core/papers/baked_avatar.h), multiples
  // of 8; empty: not at all.
  std::vector<int> baked_cells{128, 256};
  bool refit = false;       // also fit pose and expression of every measured frame to the frozen field
  bool track_anew = false;  // by the project's options, whose head model may be another than its track's
};

}  // namespace likeness
