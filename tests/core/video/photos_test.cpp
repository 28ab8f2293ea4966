// Claims about a folder of photographs as a clip.
#include "core/video/photos.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "core/base/files.h"
#include "core/image/files.h"
#include "core/video/alpha.h"
#include "core/video/decode.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Photos : public InFolder {
 protected:
  std::vector<std::string> listed() const {
    std::vector<std::string> names;
    const auto photos = list_photos(folder_);
    EXPECT_TRUE(photos.ok()) << photos.error().what;
    for (const fs::path& photo : photos ? *photos : std::vector<fs::path>())
      names.push_back(photo.filename().string());
    return names;
  }
};

TEST_F(Photos, ComeInTheOrderInWhichPeopleNumberThem) {
  for (const char* name : {"10.jpg", "2.jpg", "1.jpg", "IMG_9.JPG", "img_10.jpg", "IMG_0011.JPG"})
    ASSERT_TRUE(write_image(folder_ / fs::path(name), Image8(16, 16, 3, 90)).ok()) << name;
  EXPECT_THAT(listed(),
              testing::ElementsAre("1.jpg", "2.jpg", "10.jpg", "IMG_9.JPG", "img_10.jpg", "IMG_0011.JPG"));
}

// What a picture hides may have any colour.
TEST_F(Photos, WhatAPictureHidesIsNotSeen) {
  Image8 cut_out(64, 48, 4);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const bool person = x >= 16 && x < 40;
      const std::uint8_t colour[] = {std::uint8_t(person ? 60 : 255), std::uint8_t(person ? 90 : 0), 0,
                                     std::uint8_t(person ? 255 : 0)};
      std::copy_n(colour, 4, cut_out.at(x, y));
    }
  Image8 opaque = cut_out;
  for (std::size_t i = 3; i < opaque.data.size(); i += 4) opaque.data[i] = 255;
  for (const char* name : {"1.png", "2.png", "3.png"}) ASSERT_TRUE(write_image(folder_ / name, cut_out).ok());
  ASSERT_TRUE(write_image(folder_ / "4.png", opaque).ok());
  auto reader = VideoReader::open(folder_, VideoPixels::both);
  ASSERT_TRUE(reader.ok());
  for (int i = 0; i < 4; ++i) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame.ok() && *frame);
    const std::uint8_t* wall = (*frame)->rgb.at(4, 4);
    EXPECT_EQ((*frame)->rgb.at(20, 4)[1], 90);
    ASSERT_EQ((*frame)->alpha.empty(), i == 3) << "an opaque picture brings no mask";
    if (i == 3) continue;
    EXPECT_EQ(wall[0], kBackdrop);
    EXPECT_EQ(wall[1], kBackdrop);
    EXPECT_EQ(*(*frame)->luma.at(4, 4), kBackdrop);
    EXPECT_EQ(*(*frame)->alpha.at(4, 4), 0);
    EXPECT_EQ(*(*frame)->alpha.at(20, 4), 255);
  }
}

TEST_F(Photos, WhatPhonesWriteIsReadAndWhatCannotBeReadIsCounted) {
  const bool heif = reads_heif() && std::system("ffmpeg -version > /dev/null 2>&1") == 0;
  for (int i = 1; i <= 3; ++i) {
    ASSERT_TRUE(write_image(folder_ / fmt::format("a{}.jpg", i), Image8(64, 48, 3, 90)).ok());
    if (!heif) continue;
    ASSERT_EQ(
        std::system(fmt::format("cd '{}' && ffmpeg -y -loglevel error -f lavfi -i color=c=0xC8C8C8:s=64x48 "
                                "-frames:v 1 -c:v libaom-av1 -still-picture 1 -cpu-used 8 b{}.avif && "
                                "mv b{}.avif b{}.AVIF",
                                folder_.string(), i, i, i)
                        .c_str()),
        0);
  }
  EXPECT_EQ(listed().size(), heif ? 6u : 3u);
  EXPECT_EQ(unread_pictures(folder_), "");
  for (const char* name : {"c1.DNG", "c2.dng", "d.jxl", "notes.txt"}) std::ofstream(folder_ / name) << "raw";
  EXPECT_THAT(unread_pictures(folder_), testing::AllOf(HasSubstr("2 .dng, 1 .jxl."), HasSubstr("JPEG")));
  EXPECT_THAT(unread_pictures(folder_), testing::Not(HasSubstr("txt")));
  if (heif) {
    auto reader = VideoReader::open(folder_);
    ASSERT_TRUE(reader.ok());
    reader->start_at(4);
    const auto frame = reader->next();
    ASSERT_TRUE(frame.ok() && *frame) << frame.error().what;
    EXPECT_NEAR((*frame)->rgb.at(30, 20)[1], 200, 4);
  }
  for (int i = 1; i <= 3; ++i) fs::remove(folder_ / fmt::format("a{}.jpg", i));
  for (int i = 1; i <= 3; ++i) fs::remove(folder_ / fmt::format("b{}.AVIF", i));
  const auto none = list_photos(folder_);
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().what, HasSubstr("2 .dng, 1 .jxl"));
}

TEST_F(Photos, OnePhotographInTwoKindsIsOne) {
  if (!reads_heif()) GTEST_SKIP() << "needs an OpenImageIO that reads HEIF";
  const auto touch = [&](const std::string& name) { std::ofstream(folder_ / name) << "picture"; };
  for (int i = 1; i <= 4; ++i) touch(fmt::format("{}.heic", i)), touch(fmt::format("{}.JPG", i));
  EXPECT_THAT(listed(), testing::ElementsAre("1.JPG", "2.JPG", "3.JPG", "4.JPG"));
  EXPECT_THAT(unread_pictures(folder_), HasSubstr("4 photographs are in the folder twice"));
  touch("5.heic");
  EXPECT_THAT(listed(), testing::ElementsAre("1.heic", "2.heic", "3.heic", "4.heic", "5.heic"));
}

TEST(OverBackdrop, AlphaThatIsZeroThroughoutMeansNothing) {
  Image8 picture(8, 8, 4, 70);
  for (std::size_t i = 3; i < picture.data.size(); i += 4) picture.data[i] = 0;
  const ShownPicture shown = over_backdrop(picture);
  EXPECT_TRUE(shown.alpha.empty());
  EXPECT_EQ(*shown.rgb.at(3, 3), 70);
}

// Puts an orientation tag (Exif) behind the start mark of a JPEG.
void tag_orientation(const fs::path& jpeg, int tag) {
  auto bytes = read_file(jpeg);
  ASSERT_TRUE(bytes.ok());
  const unsigned char exif[] = {0xFF,
                                0xE1,
                                0,
                                34,
                                'E',
                                'x',
                                'i',
                                'f',
                                0,
                                0,
                                'I',
                                'I',
                                42,
                                0,
                                8,
                                0,
                                0,
                                0,
                                1,
                                0,
                                0x12,
                                0x01,
                                3,
                                0,
                                1,
                                0,
                                0,
                                0,
                                (unsigned char)tag,
                                0,
                                0,
                                0,
                                0,
                                0,
                                0,
                                0};
  std::vector<std::byte> tagged(bytes->begin(), bytes->begin() + 2);
  for (const unsigned char b : exif) tagged.push_back(std::byte(b));
  tagged.insert(tagged.end(), bytes->begin() + 2, bytes->end());
  ASSERT_TRUE(write_file(jpeg, tagged));
}

TEST_F(Photos, AreAClipOfOnePicturePerSecondInOrderOfNames) {
  for (const char* name : {"b.png", "a.PNG", "c.png"}) {
    ASSERT_TRUE(write_image(folder_ / "made.png", quadrant_frame(64, 48, name[0] - 'a')));
    fs::rename(folder_ / "made.png", folder_ / name);
  }
  std::ofstream(folder_ / "notes.txt") << "not a picture";
  auto reader = VideoReader::open(folder_);
  ASSERT_TRUE(reader.ok()) << reader.error().what;
  EXPECT_EQ(reader->info().frame_count, 3);
  EXPECT_EQ(reader->info().width, 64);
  for (int i = 0; i < 3; ++i) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame.ok() && frame->has_value()) << i;
    EXPECT_EQ((*frame)->index, i);
    EXPECT_DOUBLE_EQ((*frame)->time_s, i);
    EXPECT_NEAR((*frame)->rgb.at(48, 36)[0], 40 + 5 * i, 3);  // the fourth quadrant distinguishes the frames
  }
  EXPECT_FALSE(reader->next()->has_value());
  auto luma = VideoReader::open(folder_, VideoPixels::luma);
  ASSERT_TRUE(luma.ok());
  EXPECT_EQ((*luma->next())->rgb.channels, 1);
}

TEST_F(Photos, AreUprightWhateverTheirTag) {
  // Two by one quadrants would hide a mirrored one: the four differ.
  const Image8 upright = quadrant_frame(48, 64, 20);
  for (int tag = 1; tag <= 8; ++tag) {
    // What the sensor stored so that the tag's way of showing it gives the upright picture.
    const bool transposed = tag >= 5;
    Image8 stored(transposed ? 64 : 48, transposed ? 48 : 64, 3);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 48; ++x) {
        int sx = x, sy = y;
        switch (tag) {
          case 2:
            sx = 47 - x;
            break;
          case 3:
            sx = 47 - x, sy = 63 - y;
            break;
          case 4:
            sy = 63 - y;
            break;
          case 5:
            sx = y, sy = x;
            break;
          case 6:
            sx = y, sy = 47 - x;
            break;
          case 7:
            sx = 63 - y, sy = 47 - x;
            break;
          case 8:
            sx = 63 - y, sy = x;
            break;
          default:
            break;
        }
        std::copy_n(upright.at(x, y), 3, stored.at(sx, sy));
      }
    const fs::path file = folder_ / "p.jpg";
    ASSERT_TRUE(write_image(file, stored, {.jpeg_quality = 100}));
    tag_orientation(file, tag);
    const auto photo = read_photo(file);
    ASSERT_TRUE(photo.ok()) << photo.error().what;
    ASSERT_EQ(photo->width, 48) << tag;
    ASSERT_EQ(photo->height, 64) << tag;
    for (const auto& [x, y] : {std::pair{12, 16}, {36, 16}, {12, 48}, {36, 48}})
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(photo->at(x, y)[c], upright.at(x, y)[c], 6) << tag;
  }
}

TEST_F(Photos, AnEmptyFolderAndOneOfOddOnesAreNamed) {
  const auto empty = VideoReader::open(folder_);
  ASSERT_FALSE(empty.ok());
  EXPECT_THAT(empty.error().what, HasSubstr("a folder with 0 photographs"));
  for (const char* name : {"a.png", "b.png", "c.png"})
    ASSERT_TRUE(write_image(folder_ / name, quadrant_frame(name[0] == 'a' ? 64 : 32, 48, 0)));
  auto reader = VideoReader::open(folder_);
  ASSERT_TRUE(reader.ok());
  ASSERT_TRUE(reader->next().ok());
  const auto odd = reader->next();
  ASSERT_FALSE(odd.ok());
  EXPECT_THAT(odd.error().what, HasSubstr("32 x 48 px"));
  EXPECT_THAT(odd.error().where, HasSubstr("c.png"));
  EXPECT_FALSE(reader->next().ok());  // and again
}

TEST_F(Photos, BrokenAndOddOnesAreLeftOutAndNamed) {
  for (int i = 1; i <= 8; ++i)
    ASSERT_TRUE(write_image(folder_ / fmt::format("{}.jpg", i), quadrant_frame(i == 4 ? 32 : 64, 48, 0)));
  for (const char* broken : {"1.jpg", "7.jpg"}) fs::resize_file(folder_ / broken, 300);
  auto reader = VideoReader::open(folder_);
  ASSERT_TRUE(reader.ok()) << reader.error().what;
  for (const VideoPixels pixels : {VideoPixels::rgb, VideoPixels::luma}) {
    ASSERT_TRUE(reader->rewind(pixels));
    std::vector<int> read;
    while (true) {
      const auto frame = reader->next();
      ASSERT_TRUE(frame.ok()) << frame.error().what;
      if (!*frame) break;
      EXPECT_EQ((*frame)->time_s, (*frame)->index);
      read.push_back((*frame)->index);
    }
    EXPECT_THAT(read, testing::ElementsAre(1, 2, 4, 5, 7));
    ASSERT_TRUE(reader->fault());
    EXPECT_THAT(fault_words(*reader->fault()), HasSubstr("3 of 8 photographs are left out, 1.jpg first: "));
  }
}

TEST_F(Photos, HashCoversNamesAndContents) {
  for (const char* name : {"a.png", "b.png", "c.png"})
    ASSERT_TRUE(write_image(folder_ / name, quadrant_frame(32, 32, name[0])));
  const auto before = hash_video(folder_);
  ASSERT_TRUE(before.ok());
  EXPECT_EQ(*hash_video(folder_), *before);
  ASSERT_TRUE(write_image(folder_ / "b.png", quadrant_frame(32, 32, 1)));
  EXPECT_NE(*hash_video(folder_), *before);
}

}  // namespace
}  // namespace likeness
