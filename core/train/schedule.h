// The learning rate over the planned steps, and how a budget of seconds becomes a number of steps.
//
// A budgeted run cannot know its steps beforehand: the rate is flat until kFlatShare of the steps, and the
// total is settled from the measured speed before that, so that a replay with exactly that total takes the
// same steps. Whatever else happens at a share of the steps must not happen before kFlatShare either.
#pragma once

#include <cstdint>

namespace likeness {

struct Schedule {
  std::uint64_t total_steps = 0;  // 0: not settled yet
  double budget_s = 0;            // the total was settled for; 0: steps were asked for
  double rate_scale = 1;          // halved whenever a loss was not finite
};

inline constexpr double kFlatShare = 0.35, kSettleShare = 0.28, kFinalRate = 0.02;
inline constexpr std::uint64_t kWarmupSteps = 10;

// Factor on the learning rates at a step: linear warm-up, flat, then a half cosine down to kFinalRate.
double learning_rate(std::uint64_t step, const Schedule& schedule);

// Where half of the time until a total is settled had been spent, by the run that settles it. To be forgotten
// when the steps go back: the seconds do not.
struct HalfWay {
  std::uint64_t step = 0;
  double seconds = 0;  // 0: not there yet
};

// Settles the total of a budgeted run once kSettleShare of the budget is spent, by the pace since half of
// that time: that of the last moments is another from one second to the next. seconds: spent so far, earlier
// runs included; recent_step_seconds: mean of the last steps, which serves where hardly a step was taken
// since then.
void settle(Schedule& schedule, HalfWay& half_way, std::uint64_t step, double seconds,
            double recent_step_seconds);

// Whether a run is over: at its planned steps, or, however slow the machine, with one step at least, when it
// is a seventh beyond its budget.
bool is_over(const Schedule& schedule, std::uint64_t step, double seconds);

// Fits the schedule of an interrupted or finished run at `step` to what is asked for now. False when the run
// cannot become the one asked for (steps > 0 means: exactly the run of that many steps).
bool resume_schedule(Schedule& schedule, std::uint64_t step, double seconds, std::uint64_t asked_steps,
                     double asked_budget_s);

}  // namespace likeness
