// Claims about pictures told by their first bytes, whatever their names.
#include "core/image/picture_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "core/base/files.h"
#include "core/image/files.h"
#include "tests/core/image/noise.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using namespace std::string_literals;

FoundKind kind_of_bytes(const std::string& bytes) { return picture_kind(std::as_bytes(std::span(bytes))); }

// A TIFF's header and one directory of short values.
std::string tiff_of(std::initializer_list<std::pair<int, int>> tags) {
  std::string bytes = "II*\0\x08\0\0\0"s;
  const auto put = [&](int value, int size) {
    for (int i = 0; i < size; ++i) bytes += char(value >> (8 * i));
  };
  put(int(tags.size()), 2);
  for (const auto& [tag, value] : tags) put(tag, 2), put(3, 2), put(1, 4), put(value, 4);
  put(0, 4);
  return bytes;
}

TEST(PictureKind, AFileOfAFewBytesIsNone) {
  for (const std::string& magic : {"RIFF"s, "II*\0"s, "MM\0*"s, "II+\0"s,
                                   "\0\0\0\x18"
                                   "ftyp"s,
                                   "P5"s, ""s})
    for (std::size_t more = 0; more < 9; ++more)
      EXPECT_NE(kind_of_bytes(magic + std::string(more, 'x')).kind, PictureKind::webp) << magic << more;
}

TEST(PictureKind, IsThatOfTheFirstBytes) {
  EXPECT_EQ(kind_of_bytes("\x89PNG\r\n\x1a\n....").kind, PictureKind::png);
  EXPECT_EQ(kind_of_bytes("\xff\xd8\xff\xe0").kind, PictureKind::jpeg);
  EXPECT_EQ(kind_of_bytes("RIFF....WEBPVP8 ").kind, PictureKind::webp);
  EXPECT_EQ(kind_of_bytes("\x76\x2f\x31\x01").kind, PictureKind::exr);
  EXPECT_EQ(kind_of_bytes("\0\0\0\x18"
                          "ftypheic"s)
                .kind,
            PictureKind::heif);
  EXPECT_EQ(kind_of_bytes("\0\0\0\x18"
                          "ftypavif"s)
                .kind,
            PictureKind::heif);
  EXPECT_EQ(kind_of_bytes(tiff_of({{262, 2}})).kind, PictureKind::tiff);
  EXPECT_EQ(kind_of_bytes("MM\0*\0\0\0\x08"s).kind, PictureKind::tiff);
  for (const std::string& none : {""s, "I"s, "P"s, "text, no picture"s,
                                  "\0\0\0\x18"
                                  "ftypisom"s}) {
    EXPECT_EQ(kind_of_bytes(none).kind, PictureKind::other) << none;
    EXPECT_EQ(kind_of_bytes(none).name, "") << none;
  }
}

TEST(PictureKind, OthersHaveTheirNames) {
  const std::pair<std::string, const char*> others[] = {{"GIF89a", "a GIF"},
                                                        {"BM....", "a BMP"},
                                                        {"SDPX", "a DPX"},
                                                        {"P6\n4 4 255\n", "a Netpbm picture"},
                                                        {"\0\0\x01\0\x01\0"s, "an icon"},
                                                        {"\0\0\0\x0CjP  \r\n"s, "a JPEG 2000"},
                                                        {"\xFF\x0A..", "a JPEG XL"},
                                                        {"\0\0\0\x18"
                                                         "ftypcrx "s,
                                                         "a camera's raw picture (CR3)"}};
  for (const auto& [bytes, name] : others) {
    EXPECT_EQ(kind_of_bytes(bytes).kind, PictureKind::other) << name;
    EXPECT_EQ(kind_of_bytes(bytes).name, name);
  }
}

// What a TIFF reader shows of them is a thumbnail of 160 px.
TEST(PictureKind, ACamerasRawPictureIsNoTiff) {
  EXPECT_EQ(kind_of_bytes(tiff_of({{254, 1}, {50706, 1}})).name, "a camera's raw picture (DNG)");
  EXPECT_EQ(kind_of_bytes(tiff_of({{254, 1}, {330, 8}})).kind, PictureKind::other);
  EXPECT_EQ(kind_of_bytes(tiff_of({{262, 32803}})).kind, PictureKind::other);
  EXPECT_EQ(kind_of_bytes(tiff_of({{254, 1}})).kind, PictureKind::tiff);
}

TEST(PictureKind, ANameOpensNoOtherReader) {
  const fs::path folder = fs::temp_directory_path() / ("likeness_kinds_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const std::string ppm = "P6\n2 1\n255\nabcdef";
  for (const char* name : {"a.jpg", "a.png", "a.tif", "a.ppm"}) {
    ASSERT_TRUE(write_text(folder / name, ppm).ok());
    const auto refused = read_image(folder / name);
    ASSERT_FALSE(refused.ok()) << name;
    EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
    EXPECT_THAT(refused.error().what, testing::HasSubstr("a Netpbm picture")) << name;
    EXPECT_FALSE(refused.error().fix.empty());
    EXPECT_EQ(image_orientation(folder / name), 1);
  }
  const Image8 picture = noise(5, 4, 3);
  ASSERT_TRUE(write_image(folder / "b.png", picture).ok());
  fs::rename(folder / "b.png", folder / "b.jpg");  // as messengers name what they re-encode
  const auto read = read_image(folder / "b.jpg");
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(read->data, picture.data);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace likeness
