// Looks at a running training: a held-out frame as the avatar shows it, beside the true one, a new view and a
// new expression. Rendered on a thread that keeps to a small share of the time, so that training is hardly
// slowed; on a device of its own opening where there is one, for which a training waits no longer than the
// copy of the avatar takes.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "core/image/image.h"
#include "core/project/project.h"
#include "core/project/training_curve.h"
#include "core/render/picture_renderer.h"
#include "core/train/train.h"

namespace likeness::ui {

struct PreviewPictures {
  int frame = 0;                               // in the source
  bool held_out = false;                       // training never saw it
  Image8 truth, same, turned, expression;      // (size, size, 3)
  std::string turned_words, expression_words;  // "Seen from 20 degrees left", "Jaw open"
  double psnr_db = 0;                          // of `same` against `truth`: of the whole picture, or
  // where what stands behind the person was not learnt or is not known, of the person alone; then head and
  // face, too, where the frame has such regions.
  bool of_person = false;
  std::optional<double> head_db, face_db;
  double training_s = 0;  // when it was, in seconds of training
  std::uint64_t step = 0;
};

class TrainingPreview {
 public:
  // Share of the time that previews may take; they rest for the remainder.
  static constexpr double kShare = 0.03;
  static constexpr double kFirst_s = 2;  // of training before the first: earlier there is nothing to see

  TrainingPreview(Project project, std::function<void()> wake, OpenBackend open = {});

  // For run_stages. Valid as long as this object.
  AvatarTap tap();
  std::shared_ptr<const PreviewPictures> latest() const;
  std::vector<HeldOutScore> scores() const;  // of held-out frames; empty where there are none

 private:
  void loop(std::stop_token stop);

  Project project_;
  std::function<void()> wake_;
  OpenBackend open_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  bool wanted_ = true;
  std::optional<std::chrono::steady_clock::time_point> training_since_;
  std::shared_ptr<const Avatar> avatar_;
  std::shared_ptr<const PreviewPictures> latest_;
  std::vector<HeldOutScore> scores_;
  std::jthread thread_;  // last: stops before the rest goes
};

}  // namespace likeness::ui
