// Learning-rate schedule.
#include "core/train/schedule.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace likeness {

double learning_rate(std::uint64_t step, const Schedule& schedule) {
  const double warmup = schedule.rate_scale * std::min(1.0, 0.1 + 0.9 * double(step) / double(kWarmupSteps));
  if (schedule.total_steps == 0) return warmup;
  const double share = double(step) / double(schedule.total_steps);
  if (share <= kFlatShare) return warmup;
  const double fall = std::min(1.0, (share - kFlatShare) / (1 - kFlatShare));
  return warmup * (kFinalRate + (1 - kFinalRate) * 0.5 * (1 + std::cos(std::numbers::pi * fall)));
}

void settle(Schedule& schedule, HalfWay& half_way, std::uint64_t step, double seconds,
            double recent_step_seconds) {
  if (schedule.budget_s <= 0 || schedule.total_steps != 0) return;
  constexpr std::uint64_t kStretch = 10;
  const double due = kSettleShare * schedule.budget_s;
  if (half_way.seconds == 0 && seconds >= due / 2 && seconds < due) half_way = {step, seconds};
  if (seconds < due) return;
  const double step_seconds = half_way.seconds > 0 && step >= half_way.step + kStretch
                                  ? (seconds - half_way.seconds) / double(step - half_way.step)
                                  : recent_step_seconds;
  const double remaining = std::max(0.0, schedule.budget_s - seconds) / std::max(step_seconds, 1e-6);
  // Never so few that this step is beyond the flat part, in which nothing yet depends on the total.
  const auto least = std::uint64_t(std::ceil(double(step) / kFlatShare));
  schedule.total_steps = std::max({least, step + std::uint64_t(remaining), std::uint64_t(1)});
}

double StepSeconds::count(double taken) {
  constexpr std::size_t kKept = 31, kFewest = 3;
  double counts = taken;
  if (last_.size() >= kFewest) {
    std::vector<double> sorted = last_;
    const auto middle = sorted.begin() + std::ptrdiff_t(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    if (taken > kPausedStep * *middle) counts = *middle;
  }
  if (last_.size() < kKept)
    last_.push_back(taken);
  else
    last_[next_++ % kKept] = taken;
  return counts;
}

bool is_over(const Schedule& schedule, std::uint64_t step, double seconds) {
  constexpr double kOverrun = 1.15;
  if (schedule.total_steps > 0 && step >= schedule.total_steps) return true;
  return step > 0 && schedule.budget_s > 0 && seconds >= kOverrun * schedule.budget_s;
}

bool resume_schedule(Schedule& schedule, std::uint64_t step, double seconds, std::uint64_t asked_steps,
                     double asked_budget_s) {
  const bool flat = schedule.total_steps == 0 || double(step) < kFlatShare * double(schedule.total_steps);
  if (asked_steps > 0) {
    if (schedule.total_steps != asked_steps && !(flat && double(step) < kFlatShare * double(asked_steps)))
      return false;
    schedule.total_steps = asked_steps;
    schedule.budget_s = 0;
    return true;
  }
  if (std::abs(schedule.budget_s - asked_budget_s) <= 0.01 * asked_budget_s) return true;
  schedule.budget_s = asked_budget_s;
  if (flat) {
    schedule.total_steps = 0;
  } else {  // a longer run of one whose rate has already fallen: it rises again to what it would be in the
            // longer one
    const double step_seconds = seconds / double(std::max<std::uint64_t>(step, 1));
    schedule.total_steps =
        step + std::uint64_t(std::max(0.0, asked_budget_s - seconds) / std::max(step_seconds, 1e-6));
  }
  return true;
}

}  // namespace likeness
