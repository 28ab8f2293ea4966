// The learning rate over the planned steps, and how a budget of seconds becomes a number of steps.
//
// The number of steps of a budgeted run is not known beforehand: the rate is flat until kFlatShare of the
// steps, and the total is settled from the measured speed before that, so that a replay with exactly that
// total takes the same steps. Nothing else that happens at a share of the steps may happen before kFlatShare
// either.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace likeness {

struct Schedule {
  std::uint64_t total_steps = 0;  // 0: not settled yet
  double budget_s = 0;            // for which the total was settled; 0: steps were requested
  double rate_scale = 1;          // halved whenever a loss was not finite
};

inline constexpr double kFlatShare = 0.35, kSettleShare = 0.28, kFinalRate = 0.02;
inline constexpr std::uint64_t kWarmupSteps = 10;

// Factor on the learning rates at a step: linear warm-up, flat, then a half cosine down to kFinalRate.
double learning_rate(std::uint64_t step, const Schedule& schedule);

// When half of the time until a total is settled had been spent, by the run that settles it. Reset when the
// steps are rolled back: the seconds are not.
struct HalfWay {
  std::uint64_t step = 0;
  double seconds = 0;  // 0: not there yet
};

// Settles the total of a budgeted run once kSettleShare of the budget is spent, by the pace since half of
// that time, since the momentary pace varies from second to second. seconds: spent so far, earlier runs
// included; recent_step_seconds: mean of the last steps, used if hardly a step was taken since then.
void settle(Schedule& schedule, HalfWay& half_way, std::uint64_t step, double seconds,
            double recent_step_seconds);

// The seconds that steps are counted with. A process that is stopped for a while, or that others leave no
// time, spends them on no step: one that takes kPausedStep times as long as the median of those before it
// counts as that median.
inline constexpr double kPausedStep = 10;
class StepSeconds {
 public:
  // Of what a step took, the part that counts.
  double count(double taken);

 private:
  std::vector<double> last_;  // of the last steps, as taken: a run that became slower is seen as such soon
  std::size_t next_ = 0;
};

// Whether a run is over: at its planned steps or, after at least one step, when it is a seventh beyond its
// budget, however slow the computer.
bool is_over(const Schedule& schedule, std::uint64_t step, double seconds);

// Adapts the schedule of an interrupted or finished run at `step` to the current request. False if the run
// cannot become the one requested (steps > 0 means: exactly the run of that many steps).
bool resume_schedule(Schedule& schedule, std::uint64_t step, double seconds, std::uint64_t asked_steps,
                     double asked_budget_s);

}  // namespace likeness
