// Progress: see progress.h.
#include "core/base/progress.h"

#include <algorithm>
#include <exception>
#include <mutex>

namespace likeness {

struct Progress::Root {
  std::mutex mutex;
  Sink sink;
  double fraction = 0;
};

Progress::Progress() : Progress(Sink{}) {}

Progress::Progress(Sink sink) : root_(std::make_shared<Root>()) { root_->sink = std::move(sink); }

Progress::Progress(std::shared_ptr<Root> root, double from, double to, std::string label)
    : root_(std::move(root)), from_(from), to_(to), label_(std::move(label)) {}

Progress Progress::stage(double from, double to, std::string label) const {
  const double span = to_ - from_;
  return {root_, from_ + span * std::clamp(from, 0.0, 1.0), from_ + span * std::clamp(to, 0.0, 1.0),
          std::move(label)};
}

void Progress::report(double fraction, std::string_view text) const {
  if (!root_->sink) return;
  const std::scoped_lock lock(root_->mutex);
  root_->fraction = std::max(root_->fraction, from_ + (to_ - from_) * std::clamp(fraction, 0.0, 1.0));
  try {
    root_->sink({root_->fraction, label_, std::string(text)});
  } catch (const std::exception&) {  // who cannot be told must not end the work
  }
}

}  // namespace likeness
