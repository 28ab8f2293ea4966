// The studio's exports: what is chosen, what is asked for of the moment that is directed, and the queue.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/direct/performance.h"
#include "ui/studio/export_order.h"
#include "ui/studio/export_queue.h"
#include "ui/studio/frame_picture.h"
#include "ui/studio/session_context.h"

namespace likeness::ui {

// For the panels.
struct ExportsView {
  ExportChoice choice;
  std::vector<ExportItem> items;
  JobStatus status;               // of the one at work, or of the one that ended last
  std::filesystem::path written;  // by the last that finished
  FramePicture first;             // of what the choice would write; of a mesh there is none
};

// What the panels ask for; numbers are the items'.
struct ExportRequests {
  std::optional<ExportChoice> choice;
  std::optional<int> stop, retry, forget;
};

// What is exported is fixed when it is asked for.
struct ExportMoment {
  std::shared_ptr<const Performance> performance;
  double time_s = 0;                   // that stills, orbits and resting meshes show
  std::map<std::string, float> gains;  // of named actions, as a live drive has them
};

class ExportSession {
 public:
  explicit ExportSession(const SessionContext& context) : context_(context), queue_(context.wake) {}

  void tick() { queue_.tick(); }
  ExportsView view() const;
  // possible: an export may begin now.
  void apply(const ExportRequests& requests, bool possible);
  void start(ExportKind kind, ExportMoment moment);
  void show_first(ExportMoment moment);  // makes its first picture, where that may be another by now
  void stop_all() { queue_.stop_all(); }
  void show_folder() const;  // of all exports, in the desktop's file manager
  void close();              // the project; the files stay
  bool is_working() const { return queue_.is_working(); }
  bool goes_on() const;

 private:
  ExportOrder order_of(ExportMoment moment) const;

  const SessionContext context_;
  ExportChoice choice_;
  ExportQueue queue_;
  std::optional<ExportOrder> first_of_;  // what `first_` shows, or will
  FramePicture first_;
};

}  // namespace likeness::ui
