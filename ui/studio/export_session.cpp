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

bool same_picture(const ExportOrder& a, const ExportOrder& b) {
  return a.choice == b.choice && a.contents->avatar == b.contents->avatar && a.performance == b.performance &&
         a.time_s == b.time_s;
}

}  // namespace

ExportsView ExportSession::view() const {
  return {choice_, queue_.items(), queue_.status(), queue_.last_written(), first_};
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

// Without the name of its file.
ExportOrder ExportSession::order_of(ExportMoment moment) const {
  const ProjectAvatar& avatar = *context_.open.contents->avatar;
  const ViewPoint view = direct_moment(avatar.directed, *moment.performance, moment.time_s).view;
  return {settled(choice_, directed_scene(*moment.performance, view), avatar.avatar),
          context_.open.contents,
          std::move(moment.performance),
          moment.time_s,
          {},
          context_.options.compute.open,
          std::move(moment.gains)};
}

void ExportSession::show_first(ExportMoment moment) {
  const auto& contents = context_.open.contents;
  if (!contents || !contents->avatar || !makes_pictures(choice_)) {
    first_of_.reset(), first_ = {};
    return;
  }
  ExportOrder order = order_of(std::move(moment));
  if (first_of_ && same_picture(*first_of_, order)) return;
  first_of_ = order;
  context_.background.run(
      "first picture", [this, order = std::move(order)](std::stop_token) -> Background::Delivery {
        auto picture = first_picture(order);
        return [this, order, picture = std::move(picture)]() mutable {
          if (!first_of_ || !same_picture(*first_of_, order)) return;
          first_.number = ++context_.pictures;
          first_.image = picture ? std::make_shared<const Image8>(std::move(*picture)) : nullptr;
          first_.missing = picture ? "" : picture.error().what;
        };
      });
}

void ExportSession::start(ExportKind kind, ExportMoment moment) {
  const auto& contents = context_.open.contents;
  if (!contents || !contents->avatar) return;
  choice_.kind = kind;
  ExportOrder order = order_of(std::move(moment));
  order.out = export_path(context_.open.folder, order.choice, queue_);
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

void ExportSession::close() {
  context_.background.retire(queue_.clear());
  first_of_.reset(), first_ = {};
}

bool ExportSession::goes_on() const {
  return std::ranges::any_of(queue_.items(), [](const ExportItem& item) {
    return item.status.state == JobState::none || item.status.state == JobState::running;
  });
}

}  // namespace likeness::ui
