// A fit's state between two of its parts, kept so that a fit which was killed goes on from there, to the bit.
#pragma once

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>

#include "core/base/kept_work.h"
#include "core/base/result.h"
#include "core/track/clip/clip_work.h"

namespace likeness {

// What of `work` the parts change: neither the clip's pictures nor its cameras, which the same clip gives
// again.
std::string bytes_of_work(const ClipWork& work);
// Into a work of the same clip that prepare() made; false, and nothing is changed: the bytes are not of it.
bool take_work(const std::string& bytes, const HeadModel& model, bool person_known, ClipWork& work);

class KeptFit {
 public:
  // kept: null, all parts are run and none is kept.
  KeptFit(std::shared_ptr<KeptWork> kept, const HeadModel& model, bool person_known, ClipWork& work)
      : kept_(std::move(kept)), model_(model), person_known_(person_known), work_(work) {}

  // The state after the last of these parts that was kept, in `work`. In their order.
  void go_on(std::initializer_list<const char*> parts);
  // Runs it, unless it lies before what go_on() found.
  Result<void> part(const char* name, const std::function<Result<void>()>& run);

 private:
  std::shared_ptr<KeptWork> kept_;
  const HeadModel& model_;
  bool person_known_;
  ClipWork& work_;
  std::string until_;  // the last part that need not be run; empty: none
};

}  // namespace likeness
