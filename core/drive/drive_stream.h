// Carrying a performance over live, frame by frame, without looking ahead.
#pragma once

#include <memory>

#include "core/drive/drive.h"

namespace likeness {

// A lost frame repeats the one before it. Frames are always smoothed by a one-euro filter, whatever
// options.smooth says: there are no later frames to judge by.
class DriveStream {
 public:
  // driver: at rest as its neutral and world_from_head say; its seen ranges may be empty.
  static Result<std::unique_ptr<DriveStream>> create(DriveSubject driver, DriveSubject avatar,
                                                     const DriveOptions& options);
  ~DriveStream();

  // Times must increase from frame to frame.
  DrivenFrame next(const TrackedFrame& frame);
  // Fails on an action the avatar's model does not know; the gains then stay as they were.
  Result<void> set_gains(const std::map<std::string, float>& gains);

 private:
  struct Impl;
  explicit DriveStream(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
