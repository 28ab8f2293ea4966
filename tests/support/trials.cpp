// See trials.h.
#include "tests/support/trials.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <nlohmann/json.hpp>

namespace likeness::test {

using Clock = std::chrono::steady_clock;
using nlohmann::json;

namespace {

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

int complaints_so_far() {
  return testing::UnitTest::GetInstance()->current_test_info()->result()->total_part_count();
}

std::optional<std::uint64_t> only_trial() {
  const char* text = std::getenv("LIKENESS_TRIAL");
  return text ? std::optional(std::strtoull(text, nullptr, 10)) : std::nullopt;
}

double trial_seconds() {
  const char* text = std::getenv("LIKENESS_MINUTES");
  const double minutes = text ? std::atof(text) : 1;
  return 60 * minutes / std::max(1, testing::UnitTest::GetInstance()->test_to_run_count());
}

Tally read_tally(const std::string& name) {
  Tally sum;
  const char* path = std::getenv("LIKENESS_TALLY");
  if (!path) return sum;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const json row = json::parse(line, nullptr, false);  // a line cut by a kill counts for nothing
    if (!row.is_object() || row.value("test", "") != name) continue;
    sum.trials += row.value("trials", std::uint64_t(0));
    sum.found += row.value("found", std::uint64_t(0));
  }
  return sum;
}

void add_to_tally(const std::string& name, const Tally& tally, double seconds) {
  const char* path = std::getenv("LIKENESS_TALLY");
  if (!path || only_trial()) return;
  std::ofstream(path, std::ios::app) << json{{"test", name},
                                             {"trials", tally.trials},
                                             {"found", tally.found},
                                             {"seconds", std::int64_t(seconds)}}
                                            .dump()
                                     << '\n';
}

Tally run_trials(const std::string& name, const std::function<void(std::uint64_t)>& attempt) {
  const auto start = Clock::now();
  const Tally before = read_tally(name);
  Tally now;
  Tally told;
  auto told_at = start;
  // Now and then, so that a run that is ended counts, too.
  const auto tell = [&] {
    const double seconds = seconds_since(told_at);
    add_to_tally(name, {now.trials - told.trials, now.found - told.found}, seconds);
    told = now, told_at = Clock::now();
  };
  const auto once = [&](std::uint64_t number) {
    const int complaints = complaints_so_far();
    {
      SCOPED_TRACE(name + ": LIKENESS_TRIAL=" + std::to_string(number));
      attempt(number);
    }
    ++now.trials;
    now.found += complaints_so_far() > complaints;
    if (seconds_since(told_at) > 10) tell();
  };
  if (const auto only = only_trial()) {
    once(*only);
  } else {
    do once(before.trials + now.trials);
    while (seconds_since(start) < trial_seconds());
  }
  tell();
  std::printf("%s: %llu trials, of which %llu complained; with those of earlier runs %llu and %llu\n",
              name.c_str(), static_cast<unsigned long long>(now.trials),
              static_cast<unsigned long long>(now.found),
              static_cast<unsigned long long>(before.trials + now.trials),
              static_cast<unsigned long long>(before.found + now.found));
  return now;
}

}  // namespace likeness::test
