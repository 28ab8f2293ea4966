// Claims about grey pictures in one file: they come back as they were, and a file that is not whole is
// refused.
#include "core/video/grey_pictures.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

class GreyPicturesFile : public InFolder {
 protected:
  static Image8 picture(int seed) {
    Image8 image(7, 5, 1);
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = std::uint8_t(31 * seed + 10 * i);
    return image;
  }
  std::filesystem::path file() const { return folder_ / "a.greys"; }
  void write() const {
    auto writer = GreyPictureWriter::create(file(), {"of these inputs", 7, 5, {3, 6, 10}});
    ASSERT_TRUE(writer) << writer.error().what;
    for (const int frame : {3, 6, 10}) ASSERT_TRUE(writer->add(picture(frame)));
    ASSERT_TRUE(writer->finish());
  }
};

TEST_F(GreyPicturesFile, ComesBackAsItWas) {
  write();
  auto reader = GreyPictureReader::open(file());
  ASSERT_TRUE(reader) << reader.error().what;
  EXPECT_EQ(reader->about().inputs, "of these inputs");
  EXPECT_EQ(reader->about().frames, (std::vector<int>{3, 6, 10}));
  for (const int frame : {3, 6, 10}) {
    const auto back = reader->next();
    ASSERT_TRUE(back);
    EXPECT_EQ(back->width, 7);
    EXPECT_EQ(back->height, 5);
    EXPECT_EQ(back->data, picture(frame).data);
  }
  EXPECT_FALSE(reader->next());
}

TEST_F(GreyPicturesFile, CutOffLengthenedOrOfAnotherKindIsRefused) {
  write();
  const auto bytes = read_file(file());
  ASSERT_TRUE(bytes);
  for (const std::size_t size : {bytes->size() - 1, bytes->size() / 2, std::size_t(3), std::size_t(0)}) {
    ASSERT_TRUE(write_file(file(), std::span(*bytes).first(size)));
    EXPECT_FALSE(GreyPictureReader::open(file())) << size;
  }
  auto longer = *bytes;
  longer.push_back({});
  ASSERT_TRUE(write_file(file(), longer));
  EXPECT_FALSE(GreyPictureReader::open(file()));
  ASSERT_TRUE(write_text(file(), "{\"format\": \"something else\"}\n"));
  EXPECT_FALSE(GreyPictureReader::open(file()));
  EXPECT_EQ(GreyPictureReader::open(folder_ / "missing").error().code, ErrorCode::not_found);
}

TEST_F(GreyPicturesFile, IsWholeOnlyWithEveryPictureInItsSize) {
  auto writer = GreyPictureWriter::create(file(), {"", 7, 5, {0, 1}});
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->add(picture(0)));
  EXPECT_FALSE(writer->finish());
  EXPECT_FALSE(writer->add(Image8(5, 7, 1)));
  EXPECT_FALSE(writer->add(Image8(7, 5, 3)));
  ASSERT_TRUE(writer->add(picture(1)));
  EXPECT_FALSE(writer->add(picture(2)));
  EXPECT_TRUE(writer->finish());
}

}  // namespace
}  // namespace likeness
