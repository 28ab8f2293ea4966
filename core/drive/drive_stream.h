// Carrying a performance over as it happens, one frame after the other, without a look ahead.
#pragma once

#include <memory>

#include "core/drive/drive.h"

namespace likeness {

// What a lost frame shows is the last one before it. Frames are steadied by a one-euro filter whatever
// options.smooth says: nothing comes after a frame to judge it by.
class DriveStream {
 public:
  // driver: at rest as its neutral and world_from_head say; its seen ranges may be empty.
  static Result<std::unique_ptr<DriveStream>> create(DriveSubject driver, DriveSubject avatar,
                                                     const DriveOptions& options);
  ~DriveStream();

  // Times rise from frame to frame.
  DrivenFrame next(const TrackedFrame& frame);
  // Fails on an action the avatar's model does not know; the gains stay then.
  Result<void> set_gains(const std::map<std::string, float>& gains);

 private:
  struct Impl;
  explicit DriveStream(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
