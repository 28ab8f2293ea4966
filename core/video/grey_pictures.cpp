// A line of JSON, then the pictures' bytes: see grey_pictures.h.
#include "core/video/grey_pictures.h"

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/base/sync_file.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

constexpr const char* kGreyFormat = "likeness grey pictures";
constexpr int kGreyVersion = 1;
constexpr std::size_t kLongestHeader = std::size_t(1) << 22;  // bytes
constexpr int kLargestSide = 8192;                            // px

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

Error not_whole(const fs::path& path) {
  return {ErrorCode::bad_input, path.string() + " does not hold the pictures that it should.",
          "Import the video again; the file is rewritten.", path.string()};
}

std::size_t picture_bytes(const GreyPictures& about) { return std::size_t(about.width) * about.height; }

// Up to the line's end, which is read but not returned; empty where there is none.
std::string read_line(std::FILE* file) {
  std::string line;
  for (int c = std::fgetc(file); c != EOF && line.size() < kLongestHeader; c = std::fgetc(file)) {
    if (c == '\n') return line;
    line.push_back(char(c));
  }
  return {};
}

}  // namespace

struct GreyPictureWriter::State {
  fs::path path;
  GreyPictures about;
  File file;
  std::size_t count = 0;
};

GreyPictureWriter::GreyPictureWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
GreyPictureWriter::~GreyPictureWriter() = default;
GreyPictureWriter::GreyPictureWriter(GreyPictureWriter&&) noexcept = default;
GreyPictureWriter& GreyPictureWriter::operator=(GreyPictureWriter&&) noexcept = default;

Result<GreyPictureWriter> GreyPictureWriter::create(const fs::path& path, const GreyPictures& about) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->about = about;
  state->file.reset(std::fopen(path.c_str(), "wbe"));
  if (!state->file) return file_error(path, "write", errno);
  const nlohmann::json header = {{"format", kGreyFormat},     {"version", kGreyVersion},
                                 {"inputs", about.inputs},    {"width_px", about.width},
                                 {"height_px", about.height}, {"frames", about.frames}};
  const std::string line = json_text(header) + "\n";
  if (std::fwrite(line.data(), 1, line.size(), state->file.get()) != line.size())
    return file_error(path, "write", errno);
  return GreyPictureWriter(std::move(state));
}

Result<void> GreyPictureWriter::add(const Image8& picture) {
  State& s = *state_;
  const bool expected = s.count < s.about.frames.size() && picture.width == s.about.width &&
                        picture.height == s.about.height && picture.channels == 1;
  if (!expected) return not_whole(s.path);
  if (std::fwrite(picture.data.data(), 1, picture.data.size(), s.file.get()) != picture.data.size())
    return file_error(s.path, "write", errno);
  ++s.count;
  return {};
}

Result<void> GreyPictureWriter::finish() {
  State& s = *state_;
  if (s.count != s.about.frames.size()) return not_whole(s.path);
  if (std::fflush(s.file.get()) != 0) return file_error(s.path, "write", errno);
  if (const int failed = sync_file(::fileno(s.file.get())); failed != 0)
    return file_error(s.path, "write", failed);
  return {};
}

struct GreyPictureReader::State {
  fs::path path;
  GreyPictures about;
  File file;
  std::size_t count = 0;
};

GreyPictureReader::GreyPictureReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
GreyPictureReader::~GreyPictureReader() = default;
GreyPictureReader::GreyPictureReader(GreyPictureReader&&) noexcept = default;
GreyPictureReader& GreyPictureReader::operator=(GreyPictureReader&&) noexcept = default;

Result<GreyPictureReader> GreyPictureReader::open(const fs::path& path) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->file.reset(std::fopen(path.c_str(), "rbe"));
  if (!state->file) return file_error(path, "open", errno);
  const std::string line = read_line(state->file.get());
  try {
    const nlohmann::json header = parse_json(line);
    if (header.at("format") != kGreyFormat || header.at("version") != kGreyVersion) return not_whole(path);
    state->about = {header.at("inputs").get<std::string>(), whole_number_in(header.at("width_px")),
                    whole_number_in(header.at("height_px")), whole_numbers_in(header.at("frames"))};
  } catch (const std::exception&) {
    return not_whole(path);
  }
  const GreyPictures& about = state->about;
  if (about.width <= 0 || about.height <= 0 || about.width > kLargestSide || about.height > kLargestSide)
    return not_whole(path);
  std::error_code failure;
  const std::uintmax_t size = fs::file_size(path, failure);
  if (failure || size != line.size() + 1 + about.frames.size() * picture_bytes(about)) return not_whole(path);
  return GreyPictureReader(std::move(state));
}

const GreyPictures& GreyPictureReader::about() const { return state_->about; }

Result<Image8> GreyPictureReader::next() {
  State& s = *state_;
  if (s.count >= s.about.frames.size()) return not_whole(s.path);
  Image8 picture(s.about.width, s.about.height, 1);
  if (std::fread(picture.data.data(), 1, picture.data.size(), s.file.get()) != picture.data.size())
    return not_whole(s.path);
  ++s.count;
  return picture;
}

}  // namespace likeness
