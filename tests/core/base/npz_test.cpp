// Claims about .npz archives.
#include "core/base/npz.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>

#include "core/base/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class Npz : public testing::Test {
 protected:
  void TearDown() override { fs::remove(path_); }
  fs::path path_ = fs::temp_directory_path() / ("likeness_" + std::to_string(::getpid()) + ".npz");
};

NpzArchive example() {
  const std::vector<float> floats{1.5f, -2, 3, 4, 5, 6};
  const std::vector<std::int32_t> ints{7, -8};
  return {{"floats", npy_from_floats({2, 3}, floats)}, {"ints", npy_from_ints({2}, ints)}};
}

TEST_F(Npz, ReadsBackWhatWasWritten) {
  ASSERT_TRUE(write_npz(path_, example()).ok());
  const auto archive = read_npz(path_);
  ASSERT_TRUE(archive.ok()) << archive.error().what;
  EXPECT_EQ(archive->at("floats").shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(archive->at("floats").as_float(), (std::vector<float>{1.5f, -2, 3, 4, 5, 6}));
  EXPECT_EQ(archive->at("ints").as_int(), (std::vector<std::int32_t>{7, -8}));
}

TEST_F(Npz, EveryTruncationIsAnErrorNotACrash) {
  ASSERT_TRUE(write_npz(path_, example()).ok());
  const auto whole = read_file(path_).value();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    ASSERT_TRUE(write_file(path_, std::span(whole).first(size)).ok());
    EXPECT_FALSE(read_npz(path_).ok()) << size;
  }
}

TEST_F(Npz, FlippedBytesNeverCrash) {
  ASSERT_TRUE(write_npz(path_, example()).ok());
  const auto whole = read_file(path_).value();
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    auto damaged = whole;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = std::byte(random());
    ASSERT_TRUE(write_file(path_, damaged).ok());
    const auto archive = read_npz(path_);
    if (!archive.ok()) {
      EXPECT_FALSE(archive.error().fix.empty());
    }
  }
}

// A flipped bit makes another head of a head model, and no reader sees it but by the archive's checksum.
TEST_F(Npz, EveryAlteredNumberIsDamage) {
  ASSERT_TRUE(write_npz(path_, example()).ok());
  const auto whole = read_file(path_).value();
  const float wanted = 1.5f;
  const auto bytes = std::as_bytes(std::span(&wanted, 1));
  const auto at = std::search(whole.begin(), whole.end(), bytes.begin(), bytes.end());
  ASSERT_NE(at, whole.end());
  for (int bit = 0; bit < 8; ++bit) {
    auto altered = whole;
    altered[std::size_t(at - whole.begin()) + 2] ^= std::byte(1 << bit);
    ASSERT_TRUE(write_file(path_, altered).ok());
    const auto archive = read_npz(path_);
    ASSERT_FALSE(archive.ok()) << bit;
    EXPECT_EQ(archive.error().code, ErrorCode::bad_input);
  }
}

std::vector<std::byte> npy(std::string header, std::span<const std::byte> body) {
  std::string text = std::string("\x93NUMPY\x01\x00", 8);
  text += char(header.size() & 255);
  text += char(header.size() >> 8);
  text += header;
  std::vector<std::byte> bytes(text.size() + body.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  std::memcpy(bytes.data() + text.size(), body.data(), body.size());
  return bytes;
}

TEST(Npy, FortranOrderBecomesCOrder) {
  const std::vector<float> columns{1, 4, 2, 5, 3, 6};  // of [[1,2,3],[4,5,6]]
  const auto array = parse_npy(
      npy("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 3), }\n", std::as_bytes(std::span(columns))),
      "a");
  ASSERT_TRUE(array.ok()) << array.error().what;
  EXPECT_EQ(array->as_float(), (std::vector<float>{1, 2, 3, 4, 5, 6}));
}

TEST(Npy, HalfPrecisionIsWidened) {
  const std::vector<std::uint16_t> halves{0x3c00, 0xc000};  // 1, -2
  const auto array = parse_npy(
      npy("{'descr': '<f2', 'fortran_order': False, 'shape': (2,), }", std::as_bytes(std::span(halves))),
      "a");
  ASSERT_TRUE(array.ok());
  EXPECT_EQ(array->as_float(), (std::vector<float>{1, -2}));
}

TEST(Npy, AShapeLargerThanTheFileTakesNoMemory) {
  const std::vector<float> few{1};
  for (const char* shape : {"(99999999999999,)", "(4294967296, 4294967296)", "(1000000, 1000000, 1000000)"}) {
    EXPECT_FALSE(
        parse_npy(npy(std::string("{'descr': '<f4', 'fortran_order': False, 'shape': ") + shape + ", }",
                      std::as_bytes(std::span(few))),
                  "a")
            .ok());
  }
}

TEST(Npy, AnIndexBeyond32BitsStaysBeyond) {
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  const std::vector<std::int64_t> wide{7, (std::int64_t(1) << 32) + 1, -(std::int64_t(1) << 40), 4294967295};
  const auto signed_array = parse_npy(
      npy("{'descr': '<i8', 'fortran_order': False, 'shape': (4,), }", std::as_bytes(std::span(wide))), "a");
  ASSERT_TRUE(signed_array.ok());
  EXPECT_EQ(signed_array->as_int(), (std::vector<std::int32_t>{7, kMost, -kMost - 1, -1}));
  const std::vector<std::uint32_t> narrow{7, 4294967295u, 3000000000u};
  const auto unsigned_array = parse_npy(
      npy("{'descr': '<u4', 'fortran_order': False, 'shape': (3,), }", std::as_bytes(std::span(narrow))),
      "a");
  ASSERT_TRUE(unsigned_array.ok());
  EXPECT_EQ(unsigned_array->as_int(), (std::vector<std::int32_t>{7, -1, kMost}));
}

// Reading a pickle may execute it; this reader passes the bytes on unchanged.
TEST(Npy, ObjectsKeepTheirPickleUnread) {
  const std::string pickle = "cos\nsystem\n(S'false'\ntR.";
  const auto array = parse_npy(
      npy("{'descr': '|O', 'fortran_order': False, 'shape': (1,), }", std::as_bytes(std::span(pickle))), "a");
  ASSERT_TRUE(array.ok());
  EXPECT_EQ(array->kind, 'O');
  const auto bytes = std::as_bytes(std::span(pickle));
  EXPECT_TRUE(std::equal(array->data.begin(), array->data.end(), bytes.begin(), bytes.end()));
}

}  // namespace
}  // namespace likeness
