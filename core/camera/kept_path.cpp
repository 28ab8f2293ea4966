// Motion, keyframes and greys kept from import's decoding: see kept_path.h.
#include "core/camera/kept_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/json_text.h"
#include "core/camera/resect.h"
#include "core/camera/workplace.h"
#include "core/video/decode.h"
#include "core/video/grey_pictures.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// Raised when the background's motion is measured otherwise.
constexpr int kMotionVersion = 2;
constexpr int kRestSamples = 8;  // frames of a rest that are solved and averaged

fs::path kept_motion_path(const fs::path& folder) { return folder / "motion.json"; }

// Only of a clip with bars, so that what was kept of others stays.
std::string film_text(const PixelRect& film) {
  return film.empty() ? "" : fmt::format(" film {} {} {} {}", film.x, film.y, film.width, film.height);
}

}  // namespace

std::string motion_inputs(const std::string& video_hash, const AlignOptions& options) {
  std::string inputs = fmt::format("motion {} {} {} {}", kMotionVersion, video_hash, rest_limit(options),
                                   options.mask_inputs) +
                       film_text(options.film);
  for (const FrameSpan& part : options.stretches) inputs += fmt::format(" {}-{}", part.first, part.last);
  return inputs;
}

Result<void> keep_motion(const fs::path& folder, const std::string& inputs, const BackgroundMotion& motion) {
  nlohmann::json frames = nlohmann::json::array(), rests = nlohmann::json::array();
  for (const FrameMotion& f : motion.frames)
    frames.push_back({f.frame, f.path, f.travel, f.sharpness, f.x, f.y, f.time_s});
  for (const RestStretch& rest : motion.rests) rests.push_back({rest.first, rest.last});
  const nlohmann::json document = {
      {"inputs", inputs},        {"width_px", motion.width},  {"height_px", motion.height},
      {"motion", motion.motion}, {"seconds", motion.seconds}, {"tracks", motion.tracks},
      {"stride", motion.stride}, {"frames", frames},          {"rests", rests}};
  return write_text(kept_motion_path(folder), json_text(document) + "\n");
}

std::optional<BackgroundMotion> kept_motion(const fs::path& folder, const std::string& inputs) {
  if (folder.empty()) return std::nullopt;
  const auto text = read_text(kept_motion_path(folder));
  if (!text) return std::nullopt;
  try {
    const nlohmann::json document = parse_json(*text);
    if (document.at("inputs") != inputs) return std::nullopt;
    BackgroundMotion motion;
    motion.width = whole_number_in(document.at("width_px"));
    motion.height = whole_number_in(document.at("height_px"));
    motion.motion = document.at("motion").get<double>();
    motion.seconds = document.at("seconds").get<double>();
    motion.tracks = document.at("tracks").get<double>();
    motion.stride = whole_number_in(document.at("stride"));
    for (const nlohmann::json& f : document.at("frames"))
      motion.frames.push_back({whole_number_in(f.at(0)), f.at(1).get<double>(), f.at(2).get<double>(),
                               f.at(3).get<double>(), f.at(4).get<double>(), f.at(5).get<double>(),
                               f.at(6).get<double>()});
    for (const nlohmann::json& rest : document.at("rests"))
      motion.rests.push_back({whole_number_in(rest.at(0)), whole_number_in(rest.at(1))});
    if (motion.frames.empty() || motion.width <= 0 || motion.height <= 0 || motion.stride <= 0)
      return std::nullopt;
    return motion;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

namespace {

fs::path background_greys(const fs::path& folder) { return folder / "background.greys"; }
fs::path background_masks(const fs::path& folder) { return folder / "background.masks"; }

Result<void> write_greys(const fs::path& path, const std::string& inputs, const std::vector<int>& frames,
                         const std::vector<Image8>& pictures) {
  auto writer = GreyPictureWriter::create(path, {inputs, pictures[0].width, pictures[0].height, frames});
  if (!writer) return writer.error();
  for (const Image8& picture : pictures)
    if (auto added = writer->add(picture); !added) return added;
  return writer->finish();
}

std::optional<std::vector<Image8>> read_greys(const fs::path& path, const std::string& inputs,
                                              std::vector<int>& frames) {
  auto reader = GreyPictureReader::open(path);
  if (!reader || reader->about().inputs != inputs) return std::nullopt;
  frames = reader->about().frames;
  std::vector<Image8> pictures;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto next = reader->next();
    if (!next) return std::nullopt;
    pictures.push_back(std::move(*next));
  }
  return pictures;
}

}  // namespace

Result<void> keep_background(const fs::path& folder, const std::string& inputs,
                             const BackgroundPictures& pictures) {
  if (pictures.grey.empty()) return {};
  if (auto written = write_greys(background_greys(folder), inputs, pictures.frames, pictures.grey); !written)
    return written;
  if (pictures.person.empty()) return {};
  std::vector<int> masked;
  for (std::size_t i = 0; i < pictures.person.size(); ++i)
    masked.push_back(pictures.frames[i * BackgroundPictures::kMaskEvery]);
  return write_greys(background_masks(folder), inputs, masked, pictures.person);
}

std::optional<BackgroundPictures> kept_background(const fs::path& folder, const std::string& inputs) {
  BackgroundPictures pictures;
  auto greys = read_greys(background_greys(folder), inputs, pictures.frames);
  if (!greys) return std::nullopt;
  pictures.grey = std::move(*greys);
  std::error_code ignored;
  if (!fs::exists(background_masks(folder), ignored)) return pictures;
  std::vector<int> masked;
  auto masks = read_greys(background_masks(folder), inputs, masked);
  const std::size_t every = BackgroundPictures::kMaskEvery;
  if (!masks || masks->size() != (pictures.frames.size() + every - 1) / every) return std::nullopt;
  pictures.person = std::move(*masks);
  return pictures;
}

bool needs_path(const BackgroundMotion& motion, const AlignOptions& options) {
  return motion.tracks >= kLeastTracks && motion.motion > options.static_motion_px_per_1000;
}

std::string keyframe_inputs(const std::string& video_hash, const BackgroundMotion& motion,
                            const std::vector<int>& keyframes, bool masked, const AlignOptions& options) {
  std::string inputs =
      fmt::format("radial {} {} {} {} {}", video_hash, solve_width(motion.width, options.colmap_width),
                  options.colmap_features, options.seed, masked ? "masked" : "unmasked");
  if (masked) inputs += " " + options.mask_inputs;  // another mask leaves other features
  for (const int frame : keyframes) inputs += fmt::format(" {}", frame);
  return inputs + film_text(options.film);
}

int solve_width(int width, int wanted) {
  return width * 5 / 4 < wanted ? std::min(wanted, width * 3 / 2) : std::min(wanted, width);
}

std::set<int> frames_between(const BackgroundMotion& motion, const std::set<int>& solved) {
  std::set<int> wanted;
  for (const auto& frame : motion.frames) wanted.insert(frame.frame);
  for (const auto& rest : motion.rests) {
    wanted.erase(wanted.lower_bound(rest.first), wanted.upper_bound(rest.last));
    const int length = rest.last - rest.first;
    for (int i = 0; i < kRestSamples; ++i)
      wanted.insert((rest.first + length * (2 * i + 1) / (2 * kRestSamples)) / motion.stride * motion.stride);
  }
  for (int frame : solved) wanted.erase(frame);
  return wanted;
}

std::string keyframe_name(int frame) { return fmt::format("{:06}.png", frame); }

fs::path kept_keyframes(const fs::path& folder) { return folder / "keyframes"; }
fs::path kept_greys(const fs::path& folder) { return folder / "path.greys"; }

void drop_path_pictures(const fs::path& folder) {
  std::error_code ignored;
  fs::remove_all(kept_keyframes(folder), ignored);
  for (const fs::path& path : {kept_greys(folder), background_greys(folder), background_masks(folder)})
    fs::remove(path, ignored);
}

struct PathPictures::State {
  fs::path work;  // of the keyframes
  PersonMask person;
  std::set<int> keyframes, wanted;  // wanted: all in the file of greys
  int width = 0, height = 0;        // px that colmap sees
  std::optional<GreyPictureWriter> greys;
};

PathPictures::PathPictures(std::unique_ptr<State> state) : state_(std::move(state)) {}
PathPictures::~PathPictures() = default;
PathPictures::PathPictures(PathPictures&&) noexcept = default;
PathPictures& PathPictures::operator=(PathPictures&&) noexcept = default;

std::uint64_t PathPictures::expected_bytes(const BackgroundMotion& motion, const AlignOptions& options) {
  const int width = solve_width(motion.width, options.colmap_width);
  return motion.frames.size() * std::uint64_t(width) *
         std::uint64_t(reduced_height(motion.width, motion.height, width));
}

Result<PathPictures> PathPictures::create(const fs::path& folder, const std::string& video_hash,
                                          const BackgroundMotion& motion, PersonMask person,
                                          const AlignOptions& options) {
  auto state = std::make_unique<State>();
  const std::vector<int> chosen = choose_keyframes(motion, options.keyframes);
  state->work = kept_keyframes(folder);
  state->keyframes = {chosen.begin(), chosen.end()};
  state->wanted = frames_between(motion, {});
  state->wanted.insert(chosen.begin(), chosen.end());
  state->width = solve_width(motion.width, options.colmap_width);
  state->height = reduced_height(motion.width, motion.height, state->width);
  const std::string inputs = keyframe_inputs(video_hash, motion, chosen, bool(person), options);
  state->person = std::move(person);
  if (auto ready = prepare_work_folder(state->work, hash_text(inputs)); !ready) return ready.error();
  auto greys = GreyPictureWriter::create(
      kept_greys(folder),
      {video_hash, state->width, state->height, {state->wanted.begin(), state->wanted.end()}});
  if (!greys) return greys.error();
  state->greys = std::move(*greys);
  return PathPictures(std::move(state));
}

Result<void> PathPictures::add(const VideoFrame& frame) {
  State& s = *state_;
  if (s.keyframes.contains(frame.index)) {
    const Image8 mask = s.person ? s.person(frame.index, frame.rgb) : Image8();
    auto written = write_picture(s.work, keyframe_name(frame.index), frame.rgb, mask, s.width);
    if (!written) return written;
  }
  if (!s.wanted.contains(frame.index)) return {};
  return s.greys->add(followed_picture(frame.rgb, s.width, s.height));
}

Result<void> PathPictures::finish() {
  if (auto whole = state_->greys->finish(); !whole) return whole;
  return mark_pictures_ready(state_->work);
}

}  // namespace likeness
