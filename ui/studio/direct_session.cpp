// See direct_session.h.
#include "ui/studio/direct_session.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "core/direct/camera_keys.h"
#include "core/direct/random_walk.h"
#include "core/video/webcam.h"
#include "ui/studio/read_frames.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

constexpr double kAutosave_s = 1;                       // after the last change
constexpr std::chrono::seconds kSaveAgain{5};           // until the next try after a failed save
constexpr double kShortest_walk_s = 8;                  // of an empty performance
constexpr float kDollyTo = 0.7f;                        // times the typical distance
constexpr const char* kCompareFrame = "frame compare";  // the background's key
constexpr const char* kPerformance = "performance.json";
constexpr const char* kUnread = "performance-unread.json";

}  // namespace

Performance DirectSession::Take::keys() const { return performance_of(*frames, rate, avatar->directed); }

// Saves of performances, by the window's thread and by the background's: a save still queued when a newer one
// has been written writes nothing.
struct DirectSession::Saves {
  std::mutex mutex;  // held while one is written
  std::uint64_t written = 0;

  Result<void> write(std::uint64_t number, const fs::path& file, const Performance& performance) {
    const std::lock_guard lock(mutex);
    if (number < written) return {};
    auto saved = write_performance(file, performance);
    if (saved) written = number;
    return saved;
  }
};

void DirectSession::edit(std::string what, const std::function<void(Performance&)>& change) {
  Performance edited = *directing_.performance();
  change(edited);
  directing_.edit(std::move(edited), std::move(what));
}

void DirectSession::tick() {
  if (auto note = renderer_.take_note()) context_.notices.message = std::move(*note);
  if (directing_.advance(Directing::Clock::now())) request_picture();
  save_performance(false);
  if (!drive_.has_ended()) return;
  take_drive();
  if (const auto error = drive_.view().status.error) context_.notices.fail(*error);
  context_.background.retire(drive_.stop());
  request_picture();
}

DirectView DirectSession::view() const {
  DirectView view;
  view.directing = directing_.view();
  if (const auto& contents = context_.open.contents; contents && contents->avatar) {
    const ProjectAvatar& avatar = *contents->avatar;
    const Performance& performance = *view.directing.performance;
    const double time_s = view.directing.playhead_s;
    view.directing.view = direct_moment(avatar.directed, performance, time_s).view;
    view.directing.beyond = beyond_seen(avatar.directed, avatar.views, avatar.limits, performance, time_s);
  }
  view.live = drive_.view();
  view.moment = moment_number_;
  view.picture = renderer_.latest();
  view.rendering = renderer_.busy();
  view.on_device = renderer_.on_device();
  view.comparing = comparing_;
  view.compare_picture = compare_picture_;
  return view;
}

void DirectSession::apply(const DirectRequests& requests) {
  if (requests.compare_frame && context_.open.contents) {
    read_frame(context_, kCompareFrame, *requests.compare_frame, nullptr, compare_picture_);
    request_picture();
  }
  const auto before = directing_.performance();
  const double playhead = directing_.playhead_s();
  directing_.apply(requests);
  if (directing_.performance() != before || directing_.playhead_s() != playhead) request_picture();
  if (requests.gains) drive_.set_gains(*requests.gains);
  if (requests.drive_video) drive([file = *requests.drive_video] { return open_clip_source(file); });
  if (requests.open_performance) open_performance(*requests.open_performance);
  if (requests.save_performance) save_performance_as(*requests.save_performance);
  if (requests.view_px && *requests.view_px != view_px_) {
    view_px_ = *requests.view_px;
    request_picture();
  }
}

void DirectSession::rest(ChannelPart part) {
  const char* what = part == ChannelPart::face   ? "reset the face"
                     : part == ChannelPart::head ? "reset the head"
                                                 : "reset the view";
  edit(what, [&](Performance& p) { set_to_rest(p, part, directing_.value_edit()); });
}

void DirectSession::random_walk() {
  edit("random walk", [&](Performance& p) {
    if (p.channels.empty()) p.duration_s = std::max(p.duration_s, kShortest_walk_s);
    set_walk(p, context_.open.contents->avatar->limits, ++walks_);
  });
}

void DirectSession::camera_orbit() {
  const ProjectAvatar& avatar = *context_.open.contents->avatar;
  edit("camera orbit", [&](Performance& p) { set_orbit(p, orbit_of(avatar)); });
}

void DirectSession::camera_dolly() {
  edit("camera dolly", [](Performance& p) { set_dolly(p, 1, kDollyTo); });
}

void DirectSession::go_to_start() {
  directing_.stop_playing();
  directing_.go_to(0);
}

void DirectSession::go_to_end() {
  directing_.stop_playing();
  directing_.go_to(directing_.performance()->duration_s);
}

void DirectSession::toggle_comparing() {
  comparing_ = !comparing_;
  const auto& contents = context_.open.contents;
  if (comparing_ && compare_picture_.frame < 0 && contents)
    if (const auto frames = shown_frames(*contents, false); !frames.empty())
      read_frame(context_, kCompareFrame, frames[frames.size() / 2], nullptr, compare_picture_);
}

void DirectSession::close() {
  save_all();
  directing_.open({});
  context_.background.retire(drive_.stop());
  comparing_ = false;
  compare_picture_ = {};
  renderer_.clear();
}

void DirectSession::save_all() {
  lay_takes();
  save_performance(true);
}

void DirectSession::open_performance(const fs::path& file) {
  context_.background.run("open performance", [this, file](std::stop_token) -> Background::Delivery {
    auto read = read_performance(file);
    return [this, file, read = std::move(read)] {
      if (!context_.open.contents || !context_.open.contents->avatar) return;
      const auto known = read ? check_performance(*read, *context_.open.contents->model,
                                                  context_.open.contents->avatar->avatar.attributes)
                              : Result<void>(read.error());
      if (!known) {
        context_.notices.fail(known.error());
        return;
      }
      directing_.edit(*read, "open " + file.filename().string());
      request_picture();
    };
  });
}

void DirectSession::save_performance_as(const fs::path& file) {
  std::error_code ignored;
  if (fs::exists(file, ignored) && !read_performance(file)) {
    context_.notices.fail({ErrorCode::bad_input,
                           file.filename().string() + " already exists and is not a performance.",
                           "Choose another name.", file.string()});
    return;
  }
  const auto saved = write_performance(file, *directing_.performance());
  if (!saved) return context_.notices.fail(saved.error());
  context_.notices.message = "Written: " + file.string();
}

// A performance that cannot be read is set aside, not overwritten.
void DirectSession::open() {
  directing_.open({});
  std::error_code ignored;
  const fs::path folder = context_.open.folder;
  const fs::path file = folder / kPerformance;
  if (!fs::exists(file, ignored)) return;
  context_.background.run("performance", [this, folder, file](std::stop_token) -> Background::Delivery {
    auto read = read_performance(file);
    return [this, folder, file, read = std::move(read)] {
      if (folder != context_.open.folder) return;
      if (read) {
        directing_.open(*read);
        request_picture();
        return;
      }
      if (context_.open.look_only) return context_.notices.fail(read.error());
      std::error_code failure;
      fs::rename(file, folder / kUnread, failure);
      context_.notices.fail({read.error().code, read.error().what,
                             failure ? read.error().fix
                                     : std::string("It is kept as ") + kUnread + "; directing starts afresh.",
                             file.string()});
    };
  });
}

void DirectSession::save_performance(bool at_once) {
  const auto since = directing_.unsaved_since();
  if (!since || context_.open.folder.empty() || context_.open.look_only) return;
  if (!at_once && (saving_ == directing_.performance() ||
                   Directing::Clock::now() - *since < std::chrono::duration<double>(kAutosave_s)))
    return;
  if (!saves_) saves_ = std::make_shared<Saves>();
  const auto performance = directing_.performance();
  const std::uint64_t number = ++save_number_;
  if (at_once) {
    const auto saved = saves_->write(number, context_.open.folder / kPerformance, *performance);
    if (!saved) return context_.notices.fail(saved.error());
    directing_.was_saved();
    return;
  }
  saving_ = performance;
  context_.background.run(
      "save performance",
      [this, number, performance, saves = saves_,
       file = context_.open.folder / kPerformance](std::stop_token) -> Background::Delivery {
        const auto saved = saves->write(number, file, *performance);
        return [this, performance, error = saved ? std::nullopt : std::optional(saved.error())] {
          if (saving_ == performance) saving_.reset();
          if (error) context_.notices.fail(*error);
          if (performance != directing_.performance()) return;  // edited meanwhile
          if (error) {
            directing_.was_not_saved(Directing::Clock::now() + kSaveAgain);
          } else {
            directing_.was_saved();
          }
        };
      });
}

void DirectSession::request_picture() {
  if (!context_.open.contents || !context_.open.contents->avatar) return;
  const auto& avatar = context_.open.contents->avatar;
  PictureRequest request;
  request.avatar = avatar;
  request.origin.moment = ++moment_number_;
  request.finest = view_px_;
  request.moving = directing_.playing();
  if (const auto frame = comparing_ && compare_picture_.frame >= 0
                             ? frame_view(*context_.open.contents, compare_picture_.frame)
                             : std::nullopt) {
    request.camera = frame->camera;
    request.pose = frame_pose(avatar->avatar, context_.open.contents->courses, *frame->tracked);
    request.origin.frame = frame->tracked->frame;
    request.moving = false;
  } else {
    const Performance& performance = *directing_.performance();
    DirectedMoment moment = direct_moment(avatar->directed, performance, directing_.playhead_s());
    request.camera = moment.camera;
    request.pose = std::move(moment.pose);
    request.origin.view = moment.view;
    request.origin.doubt = view_doubt(
        beyond_seen(avatar->directed, avatar->views, avatar->limits, performance, directing_.playhead_s())
            .view);
  }
  if (drive_.on() && request.origin.frame < 0) {
    drive_.look(std::move(request));  // the view is this one; the pose comes from the driver
    return;
  }
  renderer_.request(std::move(request));
}

void DirectSession::drive(LiveDriver::Open open) {
  if (!context_.open.contents || !context_.open.contents->avatar) return;
  stop_driving();
  directing_.stop_playing();
  comparing_ = false;
  LiveOptions options;
  options.track.predictor = context_.open.contents->project.options.shared.landmark_model;
  drive_.start(context_.open.contents->avatar, std::move(open), std::move(options));
  request_picture();
}

// Keeps what was recorded until it is laid over the performance.
std::optional<std::uint64_t> DirectSession::keep_take() {
  auto frames = drive_.take_recording();
  if (frames.empty()) return std::nullopt;
  takes_.push_back({++take_number_, drive_.avatar(),
                    std::make_shared<const std::vector<DrivenFrame>>(std::move(frames)),
                    directing_.performance()->frames_per_second, directing_.playhead_s()});
  return take_number_;
}

void DirectSession::stop_driving() {
  take_drive();
  context_.background.retire(drive_.stop());
}

std::unique_ptr<LiveDriver> DirectSession::take_driver() {
  take_drive();
  directing_.stop_playing();
  auto driver = drive_.stop();
  request_picture();
  return driver;
}

void DirectSession::toggle_drive_recording() {
  if (!drive_.toggle_recording()) take_drive();
}

void DirectSession::take_drive() {
  const auto number = keep_take();
  if (!number) return;
  context_.background.run("", [this, take = takes_.back()](std::stop_token) -> Background::Delivery {
    return [this, take, keys = take.keys()] {
      if (std::erase_if(takes_, [&](const Take& kept) { return kept.number == take.number; }) > 0)
        lay_take(keys, take.at_s);
    };
  });
}

void DirectSession::lay_takes() {
  keep_take();
  for (const Take& take : std::exchange(takes_, {})) lay_take(take.keys(), take.at_s);
}

void DirectSession::lay_take(const Performance& keys, double at_s) {
  // An avatar made meanwhile may have another head model.
  const auto known = context_.open.contents && context_.open.contents->model
                         ? check_performance(keys, *context_.open.contents->model,
                                             context_.open.contents->avatar
                                                 ? context_.open.contents->avatar->avatar.attributes
                                                 : std::vector<AttributeRegion>{})
                         : Result<void>(Error{ErrorCode::not_found, "", "", ""});
  if (!known) {
    context_.notices.fail({ErrorCode::failed,
                           "The recorded drive is dropped: the avatar it was made for is gone.",
                           "Record it again with the present avatar.", ""});
    return;
  }
  edit("record the drive", [&](Performance& p) { lay_over(p, keys, at_s); });
  request_picture();
}

}  // namespace likeness::ui
