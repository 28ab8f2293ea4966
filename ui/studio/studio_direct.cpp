// The Direct step's part of the studio: commands on the performance, its file, its picture.
#include <chrono>
#include <mutex>
#include <optional>

#include "core/direct/camera_keys.h"
#include "core/direct/random_walk.h"
#include "core/video/webcam.h"
#include "ui/studio/studio.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

constexpr double kPlaying_s = 0.03, kDriving_s = 0.25, kWorking_s = 1.0, kIdle_s = 2.0;
constexpr double kSettling_s = 0.25;
constexpr double kAutosave_s = 1;              // after the last change
constexpr std::chrono::seconds kSaveAgain{5};  // after a save that failed
constexpr double kShortest_walk_s = 8;         // of an empty performance
constexpr float kDollyTo = 0.7f;               // times the typical distance
constexpr const char* kUnread = "performance-unread.json";

}  // namespace

Performance Studio::Take::keys() const { return performance_of(*frames, rate, avatar->directed); }

// Saves of performances, by the window and by the thread behind it: an older one that is still queued when a
// newer is written writes nothing.
struct Studio::Saves {
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

double Studio::patience_s() const {
  return directing_.playing()       ? kPlaying_s
         : drive_.on() || recorder_ ? kDriving_s
         : strokes_changed_         ? kSettling_s
         : is_working()             ? kWorking_s
                                    : kIdle_s;
}

void Studio::edit_performance(std::string what, const std::function<void(Performance&)>& change) {
  Performance edited = *directing_.performance();
  change(edited);
  directing_.edit(std::move(edited), std::move(what));
}

void Studio::apply(const DirectRequests& requests) {
  const auto before = directing_.performance();
  const double playhead = directing_.playhead_s();
  directing_.apply(requests);
  if (directing_.performance() != before || directing_.playhead_s() != playhead) request_picture();
}

WindowRequest Studio::direct(Command command) {
  const ValueEdit edit = directing_.value_edit();
  const auto rest = [&](const char* what, ChannelPart part) {
    edit_performance(what, [&](Performance& p) { set_to_rest(p, part, edit); });
  };
  switch (command) {
    case Command::undo:
      directing_.undo();
      break;
    case Command::redo:
      directing_.redo();
      break;
    case Command::reset_face:
      rest("reset the face", ChannelPart::face);
      break;
    case Command::reset_head:
      rest("reset the head", ChannelPart::head);
      break;
    case Command::reset_view:
      rest("reset the view", ChannelPart::camera);
      break;
    case Command::copy_keys:
      directing_.copy_selected();
      break;
    case Command::paste_keys:
      directing_.paste();
      break;
    case Command::delete_keys:
      directing_.delete_selected();
      break;
    case Command::choose_all_keys:
      directing_.select_all();
      break;
    case Command::choose_keys_here:
      directing_.select_here();
      break;
    case Command::copy_pose:
      directing_.copy_pose();
      break;
    case Command::paste_pose:
      directing_.paste_pose();
      break;
    case Command::open_performance:
      return WindowRequest::pick_performance;
    case Command::save_performance:
      return WindowRequest::name_performance;
    case Command::play:
      directing_.toggle_playing(Directing::Clock::now());
      break;
    case Command::repeat:
      directing_.toggle_looping();
      break;
    case Command::record_keys:
      directing_.toggle_recording();
      break;
    case Command::add_keys:
      directing_.add_keys();
      break;
    case Command::keys_earlier:
      directing_.move_selected(-1);
      break;
    case Command::keys_later:
      directing_.move_selected(1);
      break;
    case Command::next_easing:
      directing_.next_easing();
      break;
    case Command::previous_picture:
      directing_.step_frames(-1);
      break;
    case Command::next_picture:
      directing_.step_frames(1);
      break;
    case Command::previous_key:
      directing_.go_to_key(-1);
      break;
    case Command::next_key:
      directing_.go_to_key(1);
      break;
    case Command::go_to_start:
      directing_.stop_playing();
      directing_.go_to(0);
      break;
    case Command::go_to_end:
      directing_.stop_playing();
      directing_.go_to(directing_.performance()->duration_s);
      break;
    case Command::random_walk:
      edit_performance("random walk", [&](Performance& p) {
        if (p.channels.empty()) p.duration_s = std::max(p.duration_s, kShortest_walk_s);
        set_walk(p, open_.contents->avatar->limits, ++walks_);
      });
      break;
    case Command::camera_orbit:
      edit_performance("camera orbit",
                       [&](Performance& p) { set_orbit(p, orbit_range(open_.contents->avatar->limits)); });
      break;
    case Command::camera_dolly:
      edit_performance("camera dolly", [](Performance& p) { set_dolly(p, 1, kDollyTo); });
      break;
    case Command::drive_video:
      return WindowRequest::pick_driver;
    case Command::drive_webcam:
      start_driving([] { return open_webcam({}, kToDrive); });
      break;
    case Command::rest_face:
      drive_.rest_now();
      break;
    case Command::record_drive:
      if (drive_.toggle_recording()) break;
      take_drive();
      break;
    case Command::stop_driving:
      take_drive();
      background_.retire(drive_.stop());
      break;
    default:
      break;
  }
  request_picture();
  return WindowRequest::none;
}

void Studio::open_performance(const fs::path& file) {
  background_.run("open performance", [this, file](std::stop_token) -> Background::Delivery {
    auto read = read_performance(file);
    return [this, file, read = std::move(read)] {
      if (!open_.contents || !open_.contents->avatar) return;
      const auto known =
          read ? check_performance(*read, *open_.contents->model, open_.contents->avatar->avatar.attributes)
               : Result<void>(read.error());
      if (!known) {
        notices_.fail(known.error());
        return;
      }
      directing_.edit(*read, "open " + file.filename().string());
      request_picture();
    };
  });
}

void Studio::save_performance_as(const fs::path& file) {
  std::error_code ignored;
  if (fs::exists(file, ignored) && !read_performance(file)) {
    notices_.fail({ErrorCode::bad_input,
                   file.filename().string() + " is there already, and is no performance.",
                   "Choose another name.", file.string()});
    return;
  }
  const auto saved = write_performance(file, *directing_.performance());
  if (!saved) return notices_.fail(saved.error());
  notices_.message = "Written: " + file.string();
}

// The project's own, as it was left. One that cannot be read is put aside, not overwritten.
void Studio::take_performance(const fs::path& folder) {
  directing_.open({});
  std::error_code ignored;
  const fs::path file = folder / "performance.json";
  if (!fs::exists(file, ignored)) return;
  background_.run("performance", [this, folder, file](std::stop_token) -> Background::Delivery {
    auto read = read_performance(file);
    return [this, folder, file, read = std::move(read)] {
      if (folder != open_.folder) return;
      if (read) {
        directing_.open(*read);
        request_picture();
        return;
      }
      std::error_code failure;
      fs::rename(file, folder / kUnread, failure);
      notices_.fail(
          {read.error().code, read.error().what,
           failure ? read.error().fix : std::string("It is kept as ") + kUnread + "; directing starts anew.",
           file.string()});
    };
  });
}

void Studio::save_performance(bool at_once) {
  const auto since = directing_.unsaved_since();
  if (!since || open_.folder.empty()) return;
  if (!at_once && (saving_ == directing_.performance() ||
                   Directing::Clock::now() - *since < std::chrono::duration<double>(kAutosave_s)))
    return;
  if (!saves_) saves_ = std::make_shared<Saves>();
  const auto performance = directing_.performance();
  const std::uint64_t number = ++save_number_;
  if (at_once) {
    const auto saved = saves_->write(number, performance_path(), *performance);
    if (!saved) return notices_.fail(saved.error());
    directing_.was_saved();
    return;
  }
  saving_ = performance;
  background_.run("save performance",
                  [this, number, performance, saves = saves_,
                   file = performance_path()](std::stop_token) -> Background::Delivery {
                    const auto saved = saves->write(number, file, *performance);
                    return [this, performance, error = saved ? std::nullopt : std::optional(saved.error())] {
                      if (saving_ == performance) saving_.reset();
                      if (error) notices_.fail(*error);
                      if (performance != directing_.performance()) return;  // edited meanwhile
                      if (error) {
                        directing_.was_not_saved(Directing::Clock::now() + kSaveAgain);
                      } else {
                        directing_.was_saved();
                      }
                    };
                  });
}

void Studio::request_picture() {
  if (!open_.contents || !open_.contents->avatar) return;
  const auto& avatar = open_.contents->avatar;
  PictureRequest request;
  request.avatar = avatar;
  request.origin.moment = ++moment_number_;
  request.finest = view_px_;
  request.moving = directing_.playing();
  if (const auto frame = comparing_ && compare_picture_.frame >= 0
                             ? frame_view(*open_.contents, compare_picture_.frame)
                             : std::nullopt) {
    request.camera = frame->camera;
    request.pose = frame_pose(avatar->avatar, open_.contents->courses, *frame->tracked);
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
    drive_.look(std::move(request));  // from here; what the avatar does is the driver's to say
    return;
  }
  renderer_.request(std::move(request));
}

void Studio::start_driving(LiveDriver::Open open) {
  if (!open_.contents || !open_.contents->avatar) return;
  take_drive();
  background_.retire(drive_.stop());
  directing_.stop_playing();
  comparing_ = false;
  LiveOptions options;
  options.track.predictor = open_.contents->project.options.landmark_model;
  drive_.start(open_.contents->avatar, std::move(open), std::move(options));
  request_picture();
}

// Keeps what was recorded, to be laid over the performance.
std::optional<std::uint64_t> Studio::keep_take() {
  auto frames = drive_.take_recording();
  if (frames.empty()) return std::nullopt;
  takes_.push_back({++take_number_, drive_.avatar(),
                    std::make_shared<const std::vector<DrivenFrame>>(std::move(frames)),
                    directing_.performance()->frames_per_second, directing_.playhead_s()});
  return take_number_;
}

void Studio::take_drive() {
  const auto number = keep_take();
  if (!number) return;
  background_.run("", [this, take = takes_.back()](std::stop_token) -> Background::Delivery {
    return [this, take, keys = take.keys()] {
      if (std::erase_if(takes_, [&](const Take& kept) { return kept.number == take.number; }) > 0)
        lay_take(keys, take.at_s);
    };
  });
}

void Studio::lay_takes() {
  keep_take();
  for (const Take& take : std::exchange(takes_, {})) lay_take(take.keys(), take.at_s);
}

void Studio::lay_take(const Performance& keys, double at_s) {
  // Another head model may have come with an avatar that was made meanwhile.
  const auto known =
      open_.contents && open_.contents->model
          ? check_performance(keys, *open_.contents->model,
                              open_.contents->avatar ? open_.contents->avatar->avatar.attributes
                                                     : std::vector<AttributeRegion>{})
          : Result<void>(Error{ErrorCode::not_found, "", "", ""});
  if (!known) {
    notices_.fail({ErrorCode::failed, "The recorded drive is dropped: the avatar it was made for is gone.",
                   "Record it again with the avatar there is now.", ""});
    return;
  }
  edit_performance("record the drive", [&](Performance& p) { lay_over(p, keys, at_s); });
  request_picture();
}

}  // namespace likeness::ui
