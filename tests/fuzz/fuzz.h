// Feeds a file reader with damaged files. Deterministic: input n of a target is made from (target, n) alone,
// and every complaint prints both. A reader passes when it neither crashes nor hangs, takes no more memory
// than its file explains, and gives back a value or an Error.
//
// LIKENESS_FUZZ_INPUTS sets how many inputs each target gets (2,000 by default, 100,000 for the long test).
// Where LIKENESS_MINUTES is set, each gets as many as its share of the time allows, from where the tally of
// earlier runs ends (tests/support/trials.h); LIKENESS_TRIAL=n reads just input n, to look at a complaint.
// Build with LIKENESS_SANITIZE for more eyes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace likeness {

struct FuzzTarget {
  std::string name;
  std::vector<std::string> seeds;                        // good files, small
  std::function<bool(std::span<const std::byte>)> read;  // true: the reader took it
  std::function<void(std::string&)> repair;          // puts checksums right, for every second input; or none
  std::size_t memory_floor = std::size_t(48) << 20;  // bytes any file may take
  std::size_t memory_times = 200;                    // bytes per byte of the file
  double max_cpu_s = 5;                              // of one input
  std::size_t max_kept = 65536;                      // bytes alive after all inputs
  std::uint64_t inputs = 2000;                       // by default
};

struct FuzzFigures {
  std::uint64_t inputs = 0, taken = 0;
  std::uint64_t complaints = 0;  // inputs of which an expectation failed
  double slowest_s = 0;          // CPU time of one input
  std::size_t peak_bytes = 0;    // most memory alive in one input, beyond what was before
  std::size_t leaked_bytes = 0;  // alive after the last input, beyond what was after the first
};

// Runs the target and states the claims as gtest expectations; prints one line of figures.
FuzzFigures fuzz(const FuzzTarget& target);

std::string damaged(const std::vector<std::string>& seeds, std::uint64_t seed);  // one input, before repair

// Section files end with the hash of what is before it: puts it right.
void repair_checksum(std::string& text);

// Where a reader wants a path: a file in memory (/dev/shm) or the temporary folder, rewritten for every
// input.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path put(const std::string& name, std::span<const std::byte> bytes) const;
  std::string get(const std::string& name) const;

 private:
  std::filesystem::path path_;
};

inline std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace likeness
