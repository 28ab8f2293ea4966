// Tests of chance: trial after trial, each made from its number alone, for as long as there is time. What a
// run covered is added to a tally, so that the next goes on with new numbers.
//
// LIKENESS_MINUTES: how long all tests of the program that are chosen try together; 1 by default.
// LIKENESS_TALLY: the file that keeps count over runs, a line of JSON a test and run; none: numbers begin at
// 0. LIKENESS_TRIAL: just this number, to look at a complaint.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace likeness::test {

// The number that LIKENESS_TRIAL names.
std::optional<std::uint64_t> only_trial();
// Expectations of the test that failed so far.
int complaints_so_far();
// Seconds that this test may try.
double trial_seconds();

struct Tally {
  std::uint64_t trials = 0;
  std::uint64_t found = 0;  // trials that complained
};
// What earlier runs of the test of this name add up to.
Tally read_tally(const std::string& name);
void add_to_tally(const std::string& name, const Tally& tally, double seconds);

// Calls `attempt` with one number after the other until the time is over, at least once; counts those in
// which an expectation failed, adds them to the tally and prints it.
Tally run_trials(const std::string& name, const std::function<void(std::uint64_t number)>& attempt);

}  // namespace likeness::test
