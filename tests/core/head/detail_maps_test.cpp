// Claims about detail maps: every kind of file gives the same heights, frames may be missing, and errors name
// the file and what is needed.
#include "core/head/detail_maps.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/base/files.h"
#include "core/head/texture_corners.h"
#include "core/image/files.h"
#include "tests/core/head/builtin.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kSide = 96;

using HeightAt = std::function<float(float u, float v)>;  // mm

std::vector<float> map_of(const HeightAt& height, int side = kSide) {
  std::vector<float> map;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      map.push_back(height((float(x) + 0.5f) / float(side), 1 - (float(y) + 0.5f) / float(side)));
  return map;
}

float hills(float u, float v) { return 2 * std::sin(9 * u) * std::cos(7 * v); }

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string npy(const std::vector<float>& map, int width, int height) {
  std::string header =
      fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}", height, width);
  while ((header.size() + 11) % 64 != 0) header += ' ';
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  append(bytes, std::uint16_t(header.size()));
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(map.data()), map.size() * sizeof(float));
  return bytes;
}

// One strip of floats, little-endian, not compressed.
std::string tiff(const std::vector<float>& map, int width, int height) {
  std::string bytes("II*\0", 4);
  append(bytes, std::uint32_t(8 + 4 * map.size()));
  bytes.append(reinterpret_cast<const char*>(map.data()), map.size() * sizeof(float));
  const std::uint32_t entries[][4] = {{256, 4, 1, std::uint32_t(width)},
                                      {257, 4, 1, std::uint32_t(height)},
                                      {258, 3, 1, 32},
                                      {259, 3, 1, 1},
                                      {262, 3, 1, 1},
                                      {273, 4, 1, 8},
                                      {277, 3, 1, 1},
                                      {278, 4, 1, std::uint32_t(height)},
                                      {279, 4, 1, std::uint32_t(4 * map.size())},
                                      {339, 3, 1, 3}};
  append(bytes, std::uint16_t(std::size(entries)));
  for (const auto& e : entries)
    append(bytes, std::uint16_t(e[0])), append(bytes, std::uint16_t(e[1])), append(bytes, e[2]),
        append(bytes, e[3]);
  append(bytes, std::uint32_t(0));
  return bytes;
}

void append_big(std::string& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += char(value >> shift & 255);
}

void append_chunk(std::string& bytes, const std::string& type, const std::string& body) {
  append_big(bytes, std::uint32_t(body.size()));
  const std::string checked = type + body;
  bytes += checked;
  append_big(bytes,
             std::uint32_t(crc32(0, reinterpret_cast<const Bytef*>(checked.data()), uInt(checked.size()))));
}

// Grey, 16 bits: 32768 is zero, a step a micrometre.
std::string png16(const std::vector<float>& map, int width, int height) {
  std::string rows;
  for (int y = 0; y < height; ++y) {
    rows += '\0';
    for (int x = 0; x < width; ++x) {
      const int value = 32768 + int(std::lround(1000 * map[std::size_t(y * width + x)]));
      rows += char(value >> 8 & 255), rows += char(value & 255);
    }
  }
  std::string packed(compressBound(uLong(rows.size())), '\0');
  uLongf size = uLongf(packed.size());
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
           uLong(rows.size()));
  packed.resize(size);
  std::string header;
  append_big(header, std::uint32_t(width)), append_big(header, std::uint32_t(height));
  header += std::string("\x10\x00\x00\x00\x00", 5);
  std::string bytes("\x89PNG\r\n\x1a\n", 8);
  append_chunk(bytes, "IHDR", header), append_chunk(bytes, "IDAT", packed), append_chunk(bytes, "IEND", "");
  return bytes;
}

class DetailMaps : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              fmt::format("likeness_maps_{}_{}", getpid(),
                          testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void put(const std::string& name, const std::string& bytes) const {
    ASSERT_TRUE(write_text(folder_ / name, bytes).ok());
  }
  void expect_refused(const std::vector<std::string>& words, const HeadModel& model = builtin()) const {
    const auto maps = read_detail_maps(folder_, model);
    ASSERT_FALSE(maps.ok());
    EXPECT_FALSE(maps.error().fix.empty());
    const std::string message = maps.error().what + " " + maps.error().fix;
    for (const std::string& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << word << ": " << message;
  }

  fs::path folder_;
};

TEST_F(DetailMaps, EveryKindOfFileHoldsTheSameHeights) {
  const std::vector<float> map = map_of(hills);
  put("000003.npy", npy(map, kSide, kSide));
  put("12.tif", tiff(map, kSide, kSide));
  put("000360.png", png16(map, kSide, kSide));
  put("readme.txt", "no map");
  put("note_7.png", "no map either");
  const auto maps = read_detail_maps(folder_, builtin());
  ASSERT_TRUE(maps.ok()) << maps.error().what;
  ASSERT_EQ(maps->size(), 3u);
  EXPECT_EQ((*maps)[0].frame, 3);
  EXPECT_EQ((*maps)[1].frame, 12);
  EXPECT_EQ((*maps)[2].frame, 360);
  EXPECT_EQ((*maps)[0].height, (*maps)[1].height);
  EXPECT_LT(((*maps)[0].height - (*maps)[2].height).cwiseAbs().maxCoeff(), 0.6e-6f);  // half a step
  EXPECT_GT((*maps)[0].height.cwiseAbs().maxCoeff(), 0.0015f);
}

TEST_F(DetailMaps, VerticesGetTheHeightOfTheirPlace) {
  constexpr int side = 512;
  const HeightAt slope = [](float u, float v) { return 3 * u - 2 * v; };
  put("0.npy", npy(map_of(slope, side), side, side));
  put("1.npy", npy(map_of([](float, float) { return 1.5f; }, side), side, side));
  const auto maps = read_detail_maps(folder_, builtin());
  ASSERT_TRUE(maps.ok()) << maps.error().what;
  double error = 0, spread = 0;
  int count = 0;
  for (int v = 0; v < builtin().vertex_count(); ++v) {
    const HeadPart part = builtin().parts[std::size_t(v)];
    const float flat = (*maps)[1].height[v], sloped = (*maps)[0].height[v];
    if (part == HeadPart::left_eyeball || part == HeadPart::teeth || part == HeadPart::gums_tongue) {
      EXPECT_EQ(flat, 0) << v;  // what is not skin stays
      continue;
    }
    if (part != HeadPart::face) continue;
    EXPECT_NEAR(flat, 0.0015f, 1e-8f) << v;
    const Vec2f& uv = builtin().uvs[std::size_t(v)];
    error += std::pow(1000 * double(sloped) - double(slope(uv.x(), uv.y())), 2);
    spread += std::pow(double(slope(uv.x(), uv.y()) - 0.5f), 2);
    ++count;
  }
  ASSERT_GT(count, 1000);
  EXPECT_LT(std::sqrt(error / count), 0.05);  // mm
  EXPECT_GT(std::sqrt(spread / count), 0.2);
}

TEST_F(DetailMaps, AModelWithoutATextureTakesThatOfAnObjBesideTheMaps) {
  const std::vector<float> map = map_of(hills);
  put("5.npy", npy(map, kSide, kSide));
  const auto own = read_detail_maps(folder_, builtin());
  ASSERT_TRUE(own.ok());
  HeadModel bare = builtin();
  bare.uvs.clear();
  expect_refused({"texture coordinates", ".obj"}, bare);
  std::string text;
  for (const Vec3f& v : builtin().vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const Vec2f& uv : builtin().uvs) text += fmt::format("vt {:.9g} {:.9g}\n", uv.x(), uv.y());
  const auto corner = [](int v) { return fmt::format("{}/{}", v + 1, v + 1); };
  for (std::size_t f = 0; f < builtin().triangles.size(); ++f) {  // from any corner
    const Triangle& t = builtin().triangles[f];
    const int a = int(f % 3);
    text += fmt::format("f {} {} {}\n", corner(t[a]), corner(t[(a + 1) % 3]), corner(t[(a + 2) % 3]));
  }
  put("head.obj", text);
  const auto given = read_detail_maps(folder_, bare);
  ASSERT_TRUE(given.ok()) << given.error().what;
  EXPECT_LT((given->front().height - own->front().height).cwiseAbs().maxCoeff(), 1e-7f);
  put("head.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n");
  expect_refused({"head.obj", "3 vertices"}, bare);
  put("head.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  expect_refused({"head.obj", "Line 4", "texture coordinate"}, bare);
}

TEST_F(DetailMaps, NamesAFileThatIsNotAMap) {
  std::vector<float> map = map_of(hills);
  expect_refused({"named after a frame", "000360.npy"});
  put("1.npy", npy(map, kSide, kSide));
  put("2.npy", npy(map_of(hills, 64), 64, 64));
  expect_refused({"2.npy is 64 x 64", "1.npy is 96 x 96", "one size"});
  put("2.npy", npy(std::vector<float>(64, 0.f), 8, 8));
  expect_refused({"2.npy is 8 x 8", "16 to 4096"});
  map[kSide * 5 + 7] = std::numeric_limits<float>::quiet_NaN();
  put("2.npy", npy(map, kSide, kSide));
  expect_refused({"2.npy", "not finite", "(7, 5)"});
  map[kSide * 5 + 7] = -10.5f;
  put("2.npy", npy(map, kSide, kSide));
  expect_refused({"2.npy", "-10.5 mm", "10", "millimetres"});
  fs::remove(folder_ / "2.npy");
  ASSERT_TRUE(write_image(folder_ / "2.png", Image8(kSide, kSide, 1, 128)).ok());
  expect_refused({"2.png", "8 bits"});
  put("2.png", "not a picture");
  expect_refused({"2.png"});
  fs::remove(folder_ / "2.png");
  put("001.tif", tiff(map_of(hills), kSide, kSide));
  expect_refused({"1.npy", "001.tif", "frame 1"});
  fs::remove(folder_ / "001.tif");
  EXPECT_TRUE(read_detail_maps(folder_, builtin()).ok());
  EXPECT_EQ(read_detail_maps(folder_ / "none", builtin()).error().code, ErrorCode::not_found);
}

TEST_F(DetailMaps, HashCoversContentsAndNames) {
  put("1.npy", npy(map_of(hills), kSide, kSide));
  const auto before = detail_maps_hash(folder_);
  ASSERT_TRUE(before.ok());
  put("notes.txt", "beside");
  EXPECT_EQ(*detail_maps_hash(folder_), *before);
  fs::rename(folder_ / "1.npy", folder_ / "2.npy");
  EXPECT_NE(*detail_maps_hash(folder_), *before);
  fs::rename(folder_ / "2.npy", folder_ / "1.npy");
  EXPECT_EQ(*detail_maps_hash(folder_), *before);
  put("1.npy", npy(map_of([](float, float) { return 1; }), kSide, kSide));
  EXPECT_NE(*detail_maps_hash(folder_), *before);
}

}  // namespace
}  // namespace likeness
