// Rendering and writing frame by frame: see write_film.h.
#include "core/export/write_film.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <regex>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/files.h"
#include "core/base/unfinished.h"
#include "core/export/mark.h"
#include "core/image/files.h"
#include "core/project/consent.h"
#include "core/render/pose_avatar.h"
#include "core/render/room_picture.h"
#include "core/video/encode.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

constexpr int kLargestSide = 16384;  // px, that encoders take
constexpr double kSameShape = 0.02;  // of width to height: rounding a side does not change the shape

constexpr const char* kPlainBackground = "#e6e6e6";

Result<Vec3f> parse_colour(const std::string& text) {
  unsigned value = 0;
  if (text.size() == 7 && text.front() == '#') {
    const char* begin = text.data() + 1;
    const auto [end, failure] = std::from_chars(begin, begin + 6, value, 16);
    if (failure == std::errc{} && end == begin + 6) {
      return Vec3f(Vec3f(float(value >> 16), float(value >> 8 & 255), float(value & 255)) / 255.0f);
    }
  }
  return Error{ErrorCode::bad_input, fmt::format("\"{}\" is not a background.", text),
               "Write plate, room, a colour such as #e8e8e8, or the name of a picture", ""};
}

// What stands behind the avatar in every frame.
struct Ground {
  Image8 picture;  // empty: the colour
  Vec3f colour = Vec3f::Constant(0.9f);
  std::optional<RoomScene> room;   // seen from each frame's camera, instead of either
  const Mosaic* mosaic = nullptr;  // the same
  std::optional<Mosaic> plate{};   // the same, of a camera that zooms or shifts where the capture's rested
};

// Such names are neither keywords nor colours; whether the picture exists is checked when it is read.
bool names_picture(const std::string& background) {
  return !background.starts_with('#') && background.find('.') != std::string::npos;
}

// The middle of a picture, as large as it fits, at another size.
Image8 cover(const Image8& picture, int width, int height) {
  const double scale = std::max(double(width) / picture.width, double(height) / picture.height);
  const int w = std::clamp(int(std::lround(width / scale)), 1, picture.width),
            h = std::clamp(int(std::lround(height / scale)), 1, picture.height);
  return resize(crop(picture, (picture.width - w) / 2, (picture.height - h) / 2, w, h), width, height);
}

// Three colour channels: a background has no transparency and is never grey-only.
Image8 three_channels(const Image8& picture) {
  Image8 rgb(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < picture.pixels(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      rgb.data[3 * i + c] = picture.data[i * std::size_t(picture.channels) + (picture.channels >= 3 ? c : 0)];
  return rgb;
}

bool same_shape(const Image8& plate, const Intrinsics& picture) {
  const double shape = double(plate.width) / plate.height;
  return std::abs(shape - double(picture.width) / std::max(1, picture.height)) < kSameShape * shape;
}

Camera with_width(const Camera& camera, int width) {
  return width > 0 && width != camera.intrinsics.width ? resized(camera, width) : camera;
}

// Whether all stand where the capture's camera rested, but some zoom or shift.
bool zooms_in_place(const Avatar& avatar, const Film& film) {
  constexpr double kSame = 1e-9, kSame_px = 1e-3;
  const Camera typical = typical_camera(avatar);
  const auto in_place = [&](const Camera& c) {
    return c.cam_from_world.isApprox(typical.cam_from_world, kSame);
  };
  const auto zoomed = [&](const Camera& c) {
    const Intrinsics own = with_width(c, typical.intrinsics.width).intrinsics, &rest = typical.intrinsics;
    return std::abs(own.fx - rest.fx) > kSame_px || std::abs(own.cx - rest.cx) > kSame_px ||
           std::abs(own.cy - rest.cy) > kSame_px;
  };
  bool any_zoomed = false;
  for (std::size_t i = 0; i < film.frames; ++i) {
    const Camera camera = film.at(i).camera;
    if (!in_place(camera)) return false;
    any_zoomed = any_zoomed || zoomed(camera);
  }
  return any_zoomed;
}

Result<Ground> open_ground(const Avatar& avatar, const std::string& background, const Film& film,
                           const Intrinsics& picture) {
  Ground ground;
  if (background == "plate" && avatar.mosaic) {
    ground.mosaic = &*avatar.mosaic;
  } else if (background == "plate" && zooms_in_place(avatar, film)) {
    ground.plate = Mosaic{avatar.plate, {}, with_width(typical_camera(avatar), avatar.plate.width)};
  } else if (background == "plate") {
    const bool same = avatar.plate.width == picture.width && avatar.plate.height == picture.height;
    ground.picture = same ? avatar.plate : resize(avatar.plate, picture.width, picture.height);
  } else if (background == "room") {
    ground.room = make_room_scene(*avatar.room);
  } else if (names_picture(background)) {
    const auto read = read_image(background);
    if (!read) return read.error();
    ground.picture = cover(three_channels(*read), picture.width, picture.height);
  } else {
    const auto colour = parse_colour(background);
    if (!colour) return colour.error();
    ground.colour = *colour;
  }
  return ground;
}

Image8 over(const Ground& ground, const Image& rgba, const Camera& camera, RenderQuality quality) {
  if (ground.room) return to_bytes(composite(rgba, room_picture(*ground.room, camera, quality)));
  if (ground.mosaic) return to_bytes(composite(rgba, mosaic_seen_by(*ground.mosaic, camera)));
  if (ground.plate) return to_bytes(composite(rgba, mosaic_seen_by(*ground.plate, camera)));
  return to_bytes(composite(rgba, ground.picture, ground.colour));
}

std::string chosen_background(const Avatar& avatar, const FilmOptions& options) {
  if (!options.background.empty()) return options.background;
  if (!options.camera_rests) return kPlainBackground;
  return !avatar.plate.empty() ? "plate" : avatar.room ? "room" : kPlainBackground;
}

// Checks that the avatar has the named background; a colour always works.
Result<void> check_known(const Avatar& avatar, const std::string& background, const Intrinsics& picture) {
  const bool room = background == "room";
  const char* fix = "Choose a colour, e.g. --background #e6e6e6";
  if (room && !avatar.room)
    return Error{ErrorCode::bad_input,
                 avatar.plate.empty() ? "This avatar has no room round it."
                                      : "This avatar has no room round it: its camera rested.",
                 avatar.plate.empty() ? fix : "Choose plate, or a colour, e.g. --background #e6e6e6", ""};
  if (room) return {};
  if (avatar.plate.empty())
    return Error{ErrorCode::bad_input, "This avatar has no background plate: its camera moved.",
                 avatar.room ? "Choose room, or a colour, e.g. --background #e6e6e6" : fix, ""};
  if (avatar.mosaic || same_shape(avatar.plate, picture)) return {};
  return Error{ErrorCode::bad_input,
               fmt::format("The plate's {} x {} px differ in shape from the pictures' {} x {}.",
                           avatar.plate.width, avatar.plate.height, picture.width, picture.height),
               fix, ""};
}

// While a sequence of pictures is written, a hidden mark of this name, and of the writing process, lies in
// its folder.
constexpr const char* kUnfinishedPictures = "pictures";

bool is_sequence_file(const std::string& name) {
  static const std::regex form(R"(\d{6,}\.png|pictures\.ffconcat)");
  return std::regex_match(name, form) || is_part_name(name);
}

// A folder that holds nothing but what a film that was never finished wrote into it.
bool is_unfinished(const fs::path& folder) {
  bool marked = false;
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure)) {
    const std::string name = it->path().filename().string();
    if (!is_sequence_file(name)) return false;
    marked |= is_part_name(name) && name.starts_with(std::string(".") + kUnfinishedPictures + ".");
  }
  return marked && !failure;
}

// Of a process that was killed; an Error where it still writes.
Result<void> clear_unfinished(const fs::path& folder) {
  if (!is_unfinished(folder)) return {};
  remove_abandoned_parts(folder);
  if (is_unfinished(folder))
    return Error{ErrorCode::bad_input,
                 fmt::format("Another process is writing pictures into {}.", folder.string()),
                 "Wait for it, or name another folder as --out.", folder.string()};
  std::vector<fs::path> left;
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure))
    if (is_sequence_file(it->path().filename().string())) left.push_back(it->path());
  for (const fs::path& path : left)
    if (!fs::remove(path, failure) && failure) return file_error(path, "remove", failure.value());
  return {};
}

// Frames to an mp4, to a folder of PNGs, or to one PNG. Pictures of an unfinished sequence are removed again.
class FrameSink {
 public:
  FrameSink() = default;
  FrameSink(FrameSink&&) = default;
  FrameSink& operator=(FrameSink&&) = delete;
  ~FrameSink() {
    std::error_code ignored;
    for (const fs::path& picture : pictures_) fs::remove(picture, ignored);
    keep_pictures();
    if (!unfinished_.empty()) fs::remove(unfinished_, ignored);
  }
  static Result<FrameSink> open(const FilmOptions& options, const Provenance& provenance, int width,
                                int height) {
    FrameSink sink;
    sink.out_ = options.out;
    sink.picture_.texts = png_provenance(provenance);
    sink.timed_ = !options.times_s.empty();
    if (options.out.extension() == ".mp4") {
      auto writer = VideoWriter::create(options.out, width, height,
                                        {.frames_per_second = options.frames_per_second,
                                         .timed = !options.times_s.empty(),
                                         .tags = mp4_provenance(provenance)});
      if (!writer) return writer.error();
      sink.video_.emplace(std::move(*writer));
    } else if (options.out.extension().empty()) {
      if (auto cleared = clear_unfinished(options.out); !cleared) return cleared.error();
      const fs::path mark = temporary_name(options.out / kUnfinishedPictures);
      if (auto marked = write_text(mark, ""); !marked) return marked.error();
      sink.unfinished_ = mark;
    }
    return sink;
  }
  Result<void> add(const Image8& picture, std::size_t index, double time_s) {
    if (video_) return timed_ ? video_->add(picture, time_s) : video_->add(picture);
    if (out_.extension() == ".png") return write_image(out_, picture, picture_);
    const fs::path name = out_ / fmt::format("{:06}.png", index);
    remember_unfinished(name);
    pictures_.push_back(name), times_s_.push_back(time_s);
    return write_image(name, picture, picture_);
  }
  Result<void> finish() {
    if (timed_ && !pictures_.empty())
      if (auto listed = list_pictures(); !listed) return listed;
    keep_pictures();
    std::error_code ignored;
    if (!unfinished_.empty()) fs::remove(std::exchange(unfinished_, {}), ignored);
    return video_ ? video_->finish() : Result<void>{};
  }

 private:
  void keep_pictures() {
    for (const fs::path& picture : pictures_) forget_unfinished(picture);
    pictures_.clear();
  }
  Result<void> list_pictures() const {
    std::string list = "ffconcat version 1.0\n";
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      list += fmt::format("file {}\n", pictures_[i].filename().string());
      if (i + 1 < pictures_.size())
        list += fmt::format("duration {:.6f}\n", std::max(0.0, times_s_[i + 1] - times_s_[i]));
    }
    return write_file(out_ / "pictures.ffconcat", std::as_bytes(std::span(list)));
  }

  fs::path out_;
  bool timed_ = false;
  ImageWriteOptions picture_;
  std::optional<VideoWriter> video_;
  fs::path unfinished_;             // the mark of an unfinished sequence
  std::vector<fs::path> pictures_;  // of an unfinished sequence
  std::vector<double> times_s_;     // of them
};

// Alpha straight on disk, premultiplied inside.
Image8 straight_alpha(Image rgba) {
  for (std::size_t i = 0; i < rgba.data.size(); i += 4) {
    const float alpha = rgba.data[i + 3];
    for (int c = 0; c < 3; ++c)
      rgba.data[i + std::size_t(c)] = alpha > 1e-4f ? rgba.data[i + std::size_t(c)] / alpha : 0;
  }
  return to_bytes(rgba);
}

// As it is written, but for what is beside it.
Image8 finished(const Ground& ground, Image rgba, const Camera& camera, const FilmOptions& options) {
  Image8 shown =
      options.alpha ? straight_alpha(std::move(rgba)) : over(ground, rgba, camera, options.quality);
  if (options.mark) draw_mark(shown);
  return shown;
}

// The left picture is cut or padded in black to the right one's height, about its middle.
Image8 side_by_side(const Image8& left, const Image8& right) {
  Image8 both(left.width + right.width, right.height, 3);
  const int shift = (right.height - left.height) / 2;
  for (int y = 0; y < right.height; ++y) {
    if (y >= shift && y - shift < left.height)
      std::copy_n(left.at(0, y - shift), 3 * left.width, both.at(0, y));
    std::copy_n(right.at(0, y), 3 * right.width, both.at(left.width, y));
  }
  return both;
}

}  // namespace

Provenance provenance_of(const OpenedAvatar& opened, std::chrono::system_clock::time_point made_at) {
  std::error_code failure;
  const fs::path absolute = fs::absolute(opened.project.folder, failure).lexically_normal();
  const fs::path folder = absolute.has_filename() ? absolute : absolute.parent_path();
  Provenance made = provenance(folder.stem().string(), opened.avatar_hash, made_at);
  made.consent = consent_name(opened.project.consent);
  return made;
}

double frame_time_s(const FilmOptions& options, std::size_t frame) {
  return options.times_s.empty() ? double(frame) / options.frames_per_second : options.times_s.at(frame);
}

Result<void> check_film(const Avatar& avatar, const Intrinsics& camera, std::size_t frames,
                        const FilmOptions& options) {
  Camera asked;
  asked.intrinsics = camera;
  const Intrinsics picture = with_width(asked, options.width).intrinsics;
  const std::string ending = options.out.extension().string();
  if (!ending.empty() && ending != ".mp4" && ending != ".png") {
    return Error{
        ErrorCode::bad_input,
        fmt::format("\"{}\" is not a film or picture that can be written.", options.out.filename().string()),
        "Name FILE.mp4, FILE.png, or a folder without a dot as --out.", options.out.string()};
  }
  std::error_code ignored;
  if (ending.empty() && fs::is_directory(options.out, ignored) && !fs::is_empty(options.out, ignored) &&
      !is_unfinished(options.out)) {
    return Error{ErrorCode::bad_input, fmt::format("The folder {} is not empty.", options.out.string()),
                 "Name a new folder as --out.", options.out.string()};
  }
  if (picture.width + options.beside_width > kLargestSide || picture.height > kLargestSide) {
    return Error{ErrorCode::bad_input,
                 fmt::format("Pictures of {} x {} px are too large.", picture.width + options.beside_width,
                             picture.height),
                 fmt::format("Use cameras, or a driving clip, of at most {} px.", kLargestSide), ""};
  }
  if (options.out.extension() == ".png" && frames > 1) {
    return Error{ErrorCode::bad_input, fmt::format("{} frames do not fit into one picture.", frames),
                 "Name an .mp4 or a folder as --out.", options.out.string()};
  }
  if (options.alpha && options.out.extension() == ".mp4") {
    return Error{ErrorCode::bad_input, "An mp4 cannot hold transparency.",
                 "With --alpha, name a folder or a .png as --out.", ""};
  }
  if (options.alpha && options.beside_width > 0) {
    return Error{ErrorCode::bad_input, "Pictures side by side have no transparency.",
                 "Leave out --alpha or --side-by-side.", ""};
  }
  const std::string background = chosen_background(avatar, options);
  if (options.alpha) return {};
  if (names_picture(background)) {
    if (fs::is_regular_file(background, ignored)) return {};
    return Error{ErrorCode::not_found, fmt::format("There is no picture {}.", background),
                 "Name an existing picture, plate, room, or a colour such as #e8e8e8", background};
  }
  if (background == "plate" || background == "room") return check_known(avatar, background, picture);
  const auto colour = parse_colour(background);
  return colour ? Result<void>{} : Result<void>(colour.error());
}

Result<Image8> film_picture(const Avatar& avatar, const AvatarRig& rig, const Camera& camera,
                            const AvatarPose& pose, const FilmOptions& options) {
  const Camera seen = with_width(camera, options.width);
  if (const auto checked = check_film(avatar, seen.intrinsics, 1, options); !checked) return checked.error();
  const auto ground = options.alpha ? Result<Ground>(Ground{})
                                    : open_ground(avatar, chosen_background(avatar, options),
                                                  listed_film({camera}, {pose}), seen.intrinsics);
  if (!ground) return ground.error();
  return finished(*ground,
                  render_frame(avatar, seen, pose_avatar(rig, pose), render_options(options.quality)).rgba,
                  seen, options);
}

Result<int> write_film(const OpenedAvatar& opened, const Film& film, const FilmOptions& options,
                       const Progress& progress, std::stop_token stop) {
  const Avatar& avatar = opened.avatar;
  const Intrinsics picture = with_width(film.at(0).camera, options.width).intrinsics;
  const std::size_t frames = film.frames;
  if (const auto checked = check_film(avatar, picture, frames, options); !checked) return checked.error();
  const auto ground = options.alpha ? Result<Ground>(Ground{})
                                    : open_ground(avatar, chosen_background(avatar, options), film, picture);
  if (!ground) return ground.error();
  const auto rig = make_rig(avatar, opened.model);
  if (!rig) return rig.error();
  const Provenance made = provenance_of(opened, options.made_at);
  const auto renderer = make_renderer(options.place, avatar);
  if (!renderer) return renderer.error();
  auto sink = FrameSink::open(options, made, options.beside_width + picture.width, picture.height);
  if (!sink) return sink.error();
  for (std::size_t i = 0; i < frames; ++i) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(i) / double(frames), fmt::format("frame {} of {}", i + 1, frames));
    const FilmFrame shot = film.at(i);
    const Camera camera = with_width(shot.camera, options.width);
    auto frame = (*renderer)->render(camera, pose_avatar(*rig, shot.pose), render_options(options.quality));
    if (!frame) return frame.error();
    Image8 shown = finished(*ground, std::move(frame->rgba), camera, options);
    if (options.beside_width > 0) {
      const auto left = options.beside(i);
      if (!left) return left.error();
      shown = side_by_side(*left, shown);
    }
    if (const auto added = sink->add(shown, i, frame_time_s(options, i)); !added) return added.error();
  }
  if (const auto finished = sink->finish(); !finished) return finished.error();
  progress.report(1);
  return int(frames);
}

}  // namespace likeness
