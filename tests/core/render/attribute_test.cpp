// Claims about attributes of an avatar: their file, their condition, and that a picture with zero amounts
// equals that of an avatar without attributes.
#include "core/render/attribute.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <random>

#include "core/base/files.h"
#include "core/render/render.h"
#include "core/render/section_file.h"
#include "tests/core/render/posed_tiny_avatar.h"

namespace likeness {
namespace {

AttributeRegion region_of(const std::string& name, const Vec3f& origin) {
  AttributeRegion region;
  region.name = name;
  region.low = -0.25f, region.high = 1, region.coverage = 0.5f;
  region.origin = origin, region.cell = 0.01f, region.count = {6, 5, 7};
  for (int z = 0; z < 7; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x) {
        const bool border = x == 0 || y == 0 || z == 0 || x == 5 || y == 4 || z == 6;
        region.weights.push_back(border ? 0 : 255);
      }
  return region;
}

// The posable avatar with two more entries of psi that act in regions, both of them with weights of their
// own.
Avatar with_attributes() {
  Avatar a = posable_avatar();
  FieldConfig config = a.head.field.config;
  config.condition_count += 2, config.local_conditions = 2;
  Field field = make_field(config, 5);
  std::mt19937 random(3);
  for (float& p : field.parameters) p += 0.3f * (float(random() % 2001) / 1000 - 1);
  a.head.field = std::move(field);
  a.attributes = {region_of("left", Vec3f(0, -0.02f, 0)), region_of("right", Vec3f(-0.06f, -0.02f, 0))};
  return a;
}

class AttributeFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ =
        std::filesystem::temp_directory_path() / ("likeness_attribute_" + std::to_string(getpid()) + ".bin");
  }
  void TearDown() override { std::filesystem::remove(path_); }
  std::filesystem::path path_;
};

TEST_F(AttributeFile, RoundTripsEveryAttribute) {
  const Avatar a = with_attributes();
  ASSERT_TRUE(write_avatar(path_, a).ok());
  const auto b = read_avatar(path_);
  ASSERT_TRUE(b.ok()) << b.error().what;
  EXPECT_TRUE(b->head.field.config == a.head.field.config);
  ASSERT_EQ(b->attributes.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(b->attributes[i].name, a.attributes[i].name);
    EXPECT_EQ(b->attributes[i].low, a.attributes[i].low);
    EXPECT_EQ(b->attributes[i].high, a.attributes[i].high);
    EXPECT_EQ(b->attributes[i].coverage, a.attributes[i].coverage);
    EXPECT_EQ(b->attributes[i].origin, a.attributes[i].origin);
    EXPECT_EQ(b->attributes[i].cell, a.attributes[i].cell);
    EXPECT_EQ(b->attributes[i].count, a.attributes[i].count);
    EXPECT_EQ(b->attributes[i].weights, a.attributes[i].weights);
  }
}

TEST_F(AttributeFile, AvatarWithoutAttributesStoresNone) {
  ASSERT_TRUE(write_avatar(path_, posable_avatar()).ok());
  EXPECT_EQ(read_text(path_)->find("attribute"), std::string::npos);
  EXPECT_TRUE(read_avatar(path_)->attributes.empty());
}

TEST_F(AttributeFile, RefusesImpossibleRegions) {
  Avatar a = with_attributes();
  const auto refused = [&](const std::function<void(Avatar&)>& spoil) {
    Avatar spoilt = a;
    spoil(spoilt);
    ASSERT_TRUE(write_avatar(path_, spoilt).ok());
    const auto read = read_avatar(path_);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, ErrorCode::bad_input);
  };
  refused([](Avatar& s) { s.attributes[1].weights.pop_back(); });
  refused([](Avatar& s) { s.attributes[0].cell = 0; });
  refused([](Avatar& s) { s.attributes[0].count[1] = 1; });
  refused([](Avatar& s) { s.attributes.push_back(s.attributes[0]); });  // one more than the field has
  refused([](Avatar& s) { s.attributes.resize(9, s.attributes[0]); });  // more than psi has entries
  refused([](Avatar& s) { s.attributes.pop_back(); });
}

Image picture(const Avatar& a, const std::vector<float>& amounts, FieldPrecision precision) {
  RenderState state = posed_state(a, 0);
  state.pose.attributes = amounts;
  RenderOptions options;
  options.strata = 8, options.precision = precision;
  return render_frame(a, typical_camera(a), state, options).rgba;
}

TEST(Attribute, AtRestMatchesAnAvatarWithoutOne) {
  const Avatar a = with_attributes();
  // The same field without the columns of the two entries.
  Avatar none = a;
  FieldConfig config = a.head.field.config;
  config.condition_count -= 2, config.local_conditions = 0;
  Field field = make_field(config, 1);
  const auto from = parameter_layout(a.head.field.config), to = parameter_layout(config);
  ASSERT_EQ(from.size(), to.size());
  for (std::size_t b = 0; b < to.size(); ++b)
    for (std::size_t i = 0; i < to[b].count; ++i) {
      const std::size_t row = to[b].columns > 0 ? i / std::size_t(to[b].columns) : 0,
                        column = to[b].columns > 0 ? i % std::size_t(to[b].columns) : i;
      const std::size_t wide = to[b].columns > 0 ? std::size_t(from[b].columns) : 0;
      field.parameters[to[b].offset + i] = a.head.field.parameters[from[b].offset + row * wide + column];
    }
  none.head.field = std::move(field), none.attributes.clear();
  for (const FieldPrecision precision : {FieldPrecision::exact, FieldPrecision::bf16}) {
    const Image plain = picture(none, {}, precision);
    EXPECT_EQ(picture(a, {}, precision).data, plain.data);
    EXPECT_EQ(picture(a, {0, 0}, precision).data, plain.data);
    EXPECT_NE(picture(a, {0.5f, 0}, precision).data, plain.data);
  }
}

TEST(Attribute, TwoAttributesEachChangeTheirOwnPixels) {
  const Avatar a = with_attributes();
  const Image rest = picture(a, {0.01f, 0.01f}, FieldPrecision::exact),
              left = picture(a, {1, 0.01f}, FieldPrecision::exact),
              right = picture(a, {0.01f, 1}, FieldPrecision::exact),
              both = picture(a, {1, 1}, FieldPrecision::exact);
  int by_left = 0, by_right = 0;
  for (std::size_t i = 0; i < rest.data.size(); ++i) {
    const bool l = left.data[i] != rest.data[i], r = right.data[i] != rest.data[i];
    by_left += l, by_right += r;
    if (l && !r) {
      EXPECT_EQ(both.data[i], left.data[i]) << i;
    }
    if (r && !l) {
      EXPECT_EQ(both.data[i], right.data[i]) << i;
    }
    if (!l && !r) {
      EXPECT_EQ(both.data[i], rest.data[i]) << i;
    }
  }
  EXPECT_GT(by_left, 20);
  EXPECT_GT(by_right, 20);
}

TEST(Attribute, IsLimitedToTheSeenRange) {
  const Avatar a = with_attributes();
  const auto psi = [&](const std::vector<float>& amounts) {
    return condition(a.condition, a.neutral, a.attributes, amounts);
  };
  EXPECT_EQ(psi({}).size(), 4);
  EXPECT_EQ(psi({})[2], 0);
  EXPECT_EQ(psi({5, -5})[2], 1);
  EXPECT_EQ(psi({5, -5})[3], -0.25f);
  EXPECT_EQ(psi({0.5f, 0}).head(2), condition(a.condition, a.neutral));
  EXPECT_EQ(attribute_index(a.attributes, "right"), 1);
  EXPECT_EQ(attribute_index(a.attributes, "none"), -1);
}

}  // namespace
}  // namespace likeness
