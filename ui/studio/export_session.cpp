// See export_session.h.
#include "ui/studio/export_session.h"

#include <algorithm>
#include <utility>

#include "ui/platform/show_folder.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

// A name in exports/ that no file has and no waiting export will take.
fs::path export_path(const fs::path& folder, const ExportChoice& choice, const ExportQueue& queue) {
  for (int number = 1;; ++number) {
    const fs::path path = folder / "exports" / export_file_name(choice, number);
    std::error_code ignored;
    if (!fs::exists(path, ignored) && !queue.holds(path)) return path;
  }
}

}  // namespace

ExportsView ExportSession::view() const {
  return {choice_, queue_.items(), queue_.status(), queue_.last_written()};
}

void ExportSession::apply(const ExportRequests& requests, bool possible) {
  if (requests.choice) choice_ = *requests.choice;
  if (requests.stop) queue_.stop(*requests.stop);
  if (requests.retry && possible) queue_.retry(*requests.retry);
  if (requests.retry && !possible)
    context_.notices.fail({ErrorCode::failed, "Nothing is exported while the avatar is being made.",
                           "Pause or stop that first, or wait until it ends.", ""});
  if (requests.forget) queue_.forget(*requests.forget);
}

void ExportSession::start(ExportKind kind, ExportMoment moment) {
  const auto& contents = context_.open.contents;
  if (!contents || !contents->avatar) return;
  choice_.kind = kind;
  const ProjectAvatar& avatar = *contents->avatar;
  const ViewPoint view = direct_moment(avatar.directed, *moment.performance, moment.time_s).view;
  const ExportChoice choice = settled(choice_, view, avatar.avatar);
  ExportOrder order{choice,
                    contents,
                    std::move(moment.performance),
                    moment.time_s,
                    export_path(context_.open.folder, choice, queue_),
                    context_.options.compute.open,
                    std::move(moment.gains)};
  if (const auto fine = check_order(order); !fine) return context_.notices.fail(fine.error());
  const fs::path out = order.out;
  queue_.add(out, [order = std::move(order)](const Progress& progress, std::stop_token stop) {
    return write_order(order, progress.stage(0, 1, "export"), stop);
  });
}

void ExportSession::show_folder() const {
  if (const auto shown = ui::show_folder(context_.open.contents->project.folder / "exports"); !shown)
    context_.notices.fail(shown.error());
}

void ExportSession::close() { context_.background.retire(queue_.clear()); }

bool ExportSession::goes_on() const {
  return std::ranges::any_of(queue_.items(), [](const ExportItem& item) {
    return item.status.state == JobState::none || item.status.state == JobState::running;
  });
}

}  // namespace likeness::ui
