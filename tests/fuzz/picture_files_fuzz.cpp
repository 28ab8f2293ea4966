// Damaged pictures, photographs and clips. The formats themselves are read by OpenImageIO and FFmpeg: what is
// asked here is that nothing they make of a damaged file crashes, hangs, or takes memory without bound.
#include <gtest/gtest.h>

#include "core/image/files.h"
#include "core/video/copy_sound.h"
#include "core/video/decode.h"
#include "core/video/encode.h"
#include "core/video/lens_tag.h"
#include "core/video/mp4_boxes.h"
#include "core/video/photos.h"
#include "tests/core/video/film_boxes.h"
#include "tests/fuzz/fuzz.h"

namespace likeness {
namespace {

// FFmpeg walks through all the samples that a damaged index claims: a second for some files, and several
// with the sanitizers, whose allocations are slow.
constexpr double kWalk_s = 30;

Image8 small_picture(int channels) {
  Image8 image(24, 16, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = std::uint8_t(7 * i + i / 24);
  return image;
}

// An Exif segment behind the start mark that says how the camera was held.
std::string with_orientation(std::string jpeg, char tag) {
  const char exif[] =
      "\xFF\xE1\x00\x22"
      "Exif\0\0MM\0\x2A\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0";
  std::string segment(exif, sizeof exif - 1);
  segment += tag;
  segment.append(6, '\0');
  return jpeg.insert(2, segment);
}

TEST(FuzzPictureFiles, Picture) {
  const ScratchFolder scratch;
  FuzzTarget target;
  target.name = "picture";
  for (const char* name : {"grey.png", "rgb.png", "rgba.png", "rgb.jpg", "rgb.tif", "rgb.webp"}) {
    const std::string file(name);
    const int channels = file.starts_with("grey") ? 1 : file.starts_with("rgba") ? 4 : 3;
    if (write_image(scratch.path() / file, small_picture(channels)))
      target.seeds.push_back(scratch.get(file));
  }
  ASSERT_GE(target.seeds.size(), 4u);
  target.seeds.push_back(with_orientation(scratch.get("rgb.jpg"), 6));
  // A header of a few bytes may claim 64 MiB, see read_image(); the libraries hold that several times.
  target.memory_floor = std::size_t(512) << 20;
  target.memory_times = 8000;
  target.max_kept = std::size_t(1) << 20;  // the libraries keep a few messages: 1.5 bytes an input
  target.read = [&](std::span<const std::byte> bytes) {
    return read_photo(scratch.put("picture", bytes)).ok();
  };
  fuzz(target);
}

// Three frames of 32 x 16 px.
void write_clip(const std::filesystem::path& path) {
  auto writer = VideoWriter::create(path, 32, 16);
  ASSERT_TRUE(writer.ok());
  Image8 frame(32, 16, 3);
  for (int i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < frame.data.size(); ++k) frame.data[k] = std::uint8_t(k * 5 + 40 * i);
    ASSERT_TRUE(writer->add(frame));
  }
  ASSERT_TRUE(writer->finish());
}

TEST(FuzzPictureFiles, Clip) {
  const ScratchFolder scratch;
  FuzzTarget target;
  target.name = "clip";
  target.max_kept =
      std::size_t(1) << 20;  // a library's buffer once grown: as much after 30,000 as after 100,000
  write_clip(scratch.path() / "seed.mp4");
  target.seeds = {scratch.get("seed.mp4")};
  target.memory_floor = std::size_t(512) << 20;  // pictures as large as the header says
  target.max_cpu_s = kWalk_s;
  target.read = [&](std::span<const std::byte> bytes) {
    const auto path = scratch.put("clip.mp4", bytes);
    const Mp4Boxes boxes = scan_mp4_boxes(path);
    try {
      auto reader = VideoReader::open(path);
      if (!reader) return false;
      for (int i = 0; i < 3; ++i) {
        const auto next = reader->next();
        if (!next) return false;
        if (!*next) break;
      }
    } catch (const std::bad_alloc&) {
      return false;  // of more memory than FFmpeg hands out, which the program's own main() tells
    }
    return boxes.is_mp4;
  };
  fuzz(target);
}

TEST(FuzzPictureFiles, LensTag) {
  const ScratchFolder scratch;
  FuzzTarget target;
  target.name = "lens tag";
  const std::string tagged = test::film(test::meta({{"other", 21, "12"}, {test::kFocalTag, 1, "26.00mm"}}),
                                        test::meta({{test::kFocalTag, 67, test::number(48, 4)}}));
  target.seeds = {tagged};
  target.read = [&](std::span<const std::byte> damaged) {
    return read_focal_35mm(scratch.put("film.mov", damaged)) > 0;
  };
  fuzz(target);
}

// A RIFF file of 50 ms of sound, 16 bit, which mp4 does not hold, and a stream of AAC frames, which it does.
std::string wave() {
  const auto number = [](std::uint32_t value, int bytes) {
    std::string text;
    for (; bytes > 0; --bytes, value >>= 8) text += char(value);
    return text;
  };
  const std::string samples(800, '\x11');
  const std::string format =
      number(1, 2) + number(1, 2) + number(8000, 4) + number(16000, 4) + number(2, 2) + number(16, 2);
  const std::string body =
      "WAVEfmt " + number(16, 4) + format + "data" + number(std::uint32_t(samples.size()), 4) + samples;
  return "RIFF" + number(std::uint32_t(body.size()), 4) + body;
}
std::string silent_aac() {
  // ADTS: LC, 44.1 kHz, one channel, 13 bytes in all; then a frame of silence.
  const unsigned char frame[] = {0xFF, 0xF1, 0x50, 0x40, 0x01, 0xBF, 0xFC,
                                 0x01, 0x18, 0x20, 0x07, 0x00, 0x0E};
  std::string stream;
  for (int i = 0; i < 5; ++i) stream.append(reinterpret_cast<const char*>(frame), sizeof frame);
  return stream;
}

TEST(FuzzPictureFiles, Sound) {
  const ScratchFolder scratch;
  FuzzTarget target;
  target.name = "sound of a clip";
  write_clip(scratch.path() / "film.mp4");
  const std::string film = scratch.get("film.mp4"), aac = silent_aac();
  const auto first =
      copy_sound(scratch.put("sound", std::as_bytes(std::span(aac))), scratch.path() / "film.mp4");
  ASSERT_TRUE(first.ok()) << first.error().what;
  ASSERT_TRUE(first->copied) << first->why_not;
  target.seeds = {scratch.get("film.mp4"), aac, wave()};
  target.memory_floor = std::size_t(512) << 20;
  target.max_cpu_s = kWalk_s;
  target.read = [&](std::span<const std::byte> bytes) {
    const auto path = scratch.put("sound", bytes);
    return copy_sound(path, scratch.put("film.mp4", std::as_bytes(std::span(film)))).ok();
  };
  fuzz(target);
}

}  // namespace
}  // namespace likeness
