// Claims about pictures in files: exact round trips, and refusal of everything that is not a whole picture.
#include "core/image/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <webp/encode.h>
#include <zlib.h>

#include <cmath>
#include <fstream>

#include "core/base/files.h"
#include "tests/core/image/noise.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class ImageFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_image_" + std::to_string(getpid()) + "_" +
                                           ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::size_t files() const { return std::size_t(std::distance(fs::directory_iterator(folder_), {})); }

  fs::path folder_;
};

Image8 gradient(int width, int height) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y)[0] = std::uint8_t(255 * x / width);
      image.at(x, y)[1] = std::uint8_t(255 * y / height);
      image.at(x, y)[2] = 128;
    }
  }
  return image;
}

TEST_F(ImageFiles, PngRoundTripsEveryByteForOneThreeAndFourChannels) {
  for (const int channels : {1, 3, 4}) {
    for (const int level : {1, 6}) {
      const Image8 image =
          noise(37, 21, channels);  // alpha 0 with colour among them: straight alpha must survive
      const auto path = folder_ / "new folder" / "a.png";
      const auto written = write_image(path, image, {.png_level = level});
      ASSERT_TRUE(written) << written.error().what;
      const auto read = read_image(path);
      ASSERT_TRUE(read) << read.error().what;
      EXPECT_EQ(read->channels, channels);
      EXPECT_EQ(read->width, 37);
      EXPECT_EQ(read->data, image.data);
    }
  }
}

TEST_F(ImageFiles, JpegRoundTripIsClose) {
  const Image8 image = gradient(64, 48);
  ASSERT_TRUE(write_image(folder_ / "a.jpg", image));
  const auto read = read_image(folder_ / "a.jpg");
  ASSERT_TRUE(read) << read.error().what;
  for (std::size_t i = 0; i < image.data.size(); ++i) ASSERT_NEAR(read->data[i], image.data[i], 8);
}

TEST_F(ImageFiles, LeavesNoTemporaryFile) {
  ASSERT_TRUE(write_image(folder_ / "a.png", noise(8, 8, 3)));
  EXPECT_EQ(files(), 1u);
}

TEST_F(ImageFiles, RefusesATruncatedPictureAtEveryLength) {
  for (const std::string name : {"a.png", "a.jpg"}) {
    ASSERT_TRUE(write_image(folder_ / name, name == "a.png" ? noise(40, 40, 3) : gradient(80, 80)));
    const auto whole = read_file(folder_ / name);
    ASSERT_TRUE(whole);
    for (const double share : {0.02, 0.3, 0.7, 0.98}) {
      const auto cut = std::span(*whole).first(std::size_t(double(whole->size()) * share));
      ASSERT_TRUE(write_file(folder_ / ("cut_" + name), cut));
      const auto read = read_image(folder_ / ("cut_" + name));
      ASSERT_FALSE(read) << name << " cut to " << share;
      EXPECT_EQ(read.error().code, ErrorCode::bad_input);
      EXPECT_THAT(read.error().what, HasSubstr("cut_" + name));
      EXPECT_FALSE(read.error().fix.empty());
    }
  }
}

TEST_F(ImageFiles, RefusesAHeaderThatClaimsMoreThanTheFileCanHold) {
  const fs::path path = folder_ / "claim.png";
  ASSERT_TRUE(write_image(path, gradient(16, 16)));
  auto bytes = *read_file(path);
  const auto put = [&](std::size_t at, std::uint32_t value) {  // big endian
    for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = std::byte(value >> (24 - 8 * i));
  };
  put(16, 15000), put(20, 15000);  // width and height, 675 MB of pixels
  put(29, std::uint32_t(crc32(0, reinterpret_cast<const unsigned char*>(bytes.data()) + 12, 17)));
  ASSERT_TRUE(write_file(path, bytes));
  const auto refused = read_image(path);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("claims a size of 15000 x 15000"));
}

TEST_F(ImageFiles, RefusesAWebpOfImplausibleSizeBeforeTakingMemory) {
  // RIFF and a VP8L chunk: signature, 14 bits each of width and height less one, alpha, version; then
  // nothing.
  std::vector<std::byte> bytes;
  const auto put = [&](std::string_view text) {
    for (const char c : text) bytes.push_back(std::byte(c));
  };
  using namespace std::string_view_literals;
  put("RIFF\x20\0\0\0WEBPVP8L\x14\0\0\0\x2F\xFE\xBF\xFF\x0F"sv);
  bytes.resize(40);
  ASSERT_TRUE(write_file(folder_ / "a.webp", bytes));
  const auto read = read_image(folder_ / "a.webp");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().what, HasSubstr("claims a size of 16383 x 16383"));
}

TEST_F(ImageFiles, ReadsAnOrdinaryWebp) {
  const Image8 image = noise(40, 30, 3);
  std::uint8_t* encoded = nullptr;
  const std::size_t bytes = WebPEncodeLosslessRGB(image.data.data(), 40, 30, 3 * 40, &encoded);
  ASSERT_GT(bytes, 0u);
  const auto written = write_file(folder_ / "a.webp", std::as_bytes(std::span(encoded, bytes)));
  WebPFree(encoded);
  ASSERT_TRUE(written);
  const auto read = read_image(folder_ / "a.webp");
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->data, image.data);
}

TEST_F(ImageFiles, DistinguishesMissingEmptyAndTextFiles) {
  const auto missing = read_image(folder_ / "missing.png");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);

  std::ofstream(folder_ / "empty.png").close();
  const auto empty = read_image(folder_ / "empty.png");
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, ErrorCode::bad_input);
  EXPECT_THAT(empty.error().what, HasSubstr("empty"));

  std::ofstream(folder_ / "text.png") << "this is no picture, whatever its name says";
  const auto text = read_image(folder_ / "text.png");
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, ErrorCode::bad_input);
  EXPECT_THAT(text.error().what, HasSubstr("not a picture"));
}

TEST_F(ImageFiles, RefusesAnUnknownFormatAndWritesNothing) {
  const auto written = write_image(folder_ / "a.nonsense", noise(8, 8, 3));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::bad_input);
  EXPECT_EQ(files(), 0u);
}

}  // namespace
}  // namespace likeness
