// Progress of long work: a tree of weighted stages seen as one rising number.
//
// A Progress is a cheap handle (copy it freely) on an interval of its root's [0, 1]. Safe from any thread.
// The fraction shown never falls; calls that would lower it only change the text. What a sink throws is lost:
// a message that cannot be shown does not end the work.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace likeness {

struct ProgressReport {
  double fraction = 0;  // of the root, in [0, 1]
  std::string stage;    // label of the innermost stage
  std::string text;     // one line about it
};

class Progress {
 public:
  using Sink = std::function<void(const ProgressReport&)>;

  Progress();                    // reports to nobody
  explicit Progress(Sink sink);  // the sink is called under a lock: keep it short

  // A stage covering [from, to] of this one.
  Progress stage(double from, double to, std::string label) const;
  // Fraction of this stage, clamped to [0, 1].
  void report(double fraction, std::string_view text = {}) const;

 private:
  struct Root;
  Progress(std::shared_ptr<Root> root, double from, double to, std::string label);
  std::shared_ptr<Root> root_;
  double from_ = 0, to_ = 1;
  std::string label_;
};

}  // namespace likeness
