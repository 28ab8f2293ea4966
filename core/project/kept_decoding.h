// What import's decoding of a clip shows of it to align and fit, kept in the project's folder decoded/, so
// that they need not decode the clip again.
//
// Nothing depends on it: a stage that does not find what it needs there, of its own inputs, decodes the clip
// and finds the same.
#pragma once

#include <filesystem>
#include <memory>

#include "core/capture/import_listeners.h"
#include "core/project/stage_run.h"

namespace likeness {

std::filesystem::path decoded_path(const Project& project);

// What the motion of the background in a project's clip is measured with (AlignOptions::mask_inputs).
std::string mask_inputs(const AlignInputs& inputs);

class KeptWork;  // core/base/kept_work.h

class KeptDecoding {
 public:
  // For one run of import; context must outlive it. faces: where those it finds are kept until import is
  // done.
  KeptDecoding(const StageContext& context, std::shared_ptr<KeptWork> faces);
  ~KeptDecoding();

  // For import_clip; where its split asks, they also say which frames a moving camera filmed.
  ImportListeners listeners();
  // After import_clip: puts decoded/ in its place. Where that fails, or there is no room on the disk, the
  // later stages decode the clip.
  void commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace likeness
