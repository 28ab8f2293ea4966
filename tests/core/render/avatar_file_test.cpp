// Claims about avatar.bin: nothing is lost, and no damaged file is accepted or crashes the reader.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <limits>
#include <random>
#include <string_view>

#include "core/base/files.h"
#include "core/render/avatar.h"
#include "core/render/room_picture.h"
#include "core/render/section_file.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness {
namespace {

class AvatarFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("likeness_avatar_" + std::to_string(getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    path_ = folder_ / "avatar.bin";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_, path_;
};

TEST_F(AvatarFile, DetailIsStoredOnlyWhereThereIsSome) {
  Avatar a = tiny_avatar();
  ASSERT_TRUE(write_avatar(path_, a).ok());
  const auto plain = read_file(path_);
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(std::string_view(reinterpret_cast<const char*>(plain->data()), plain->size()).find("detail"),
            std::string_view::npos);
  ExpressionDetail& d = a.detail;
  d.vertices = {1, 5, 6};
  d.mean = Eigen::VectorXf::LinSpaced(3, -0.002f, 0.001f);
  d.basis = Eigen::MatrixXf::Random(3, 2) * 0.001f;
  d.middle = Eigen::VectorXf::Random(5), d.rows = Eigen::MatrixXf::Random(2, 5);  // 2 expressions and the jaw
  d.low = Eigen::VectorXf::LinSpaced(2, -2, -1), d.high = Eigen::VectorXf::LinSpaced(2, 1, 3);
  ASSERT_TRUE(write_avatar(path_, a).ok());
  const auto b = read_avatar(path_);
  ASSERT_TRUE(b.ok()) << b.error().what;
  EXPECT_EQ(b->detail.vertices, d.vertices);
  EXPECT_EQ(b->detail.mean, d.mean);
  EXPECT_EQ(b->detail.basis, d.basis);
  EXPECT_EQ(b->detail.middle, d.middle);
  EXPECT_EQ(b->detail.rows, d.rows);
  EXPECT_EQ(b->detail.low, d.low);
  EXPECT_EQ(b->detail.high, d.high);
  d.rows(1, 2) = std::numeric_limits<float>::infinity();
  ASSERT_TRUE(write_avatar(path_, a).ok());
  EXPECT_FALSE(read_avatar(path_).ok());
}

TEST_F(AvatarFile, WhatHoldsIsStoredOnlyWhereItIsKnown) {
  Avatar a = tiny_avatar();
  ASSERT_TRUE(write_avatar(path_, a).ok());
  const auto before = read_avatar(path_);  // as avatars were before trainings looked for it
  ASSERT_TRUE(before.ok()) << before.error().what;
  EXPECT_FALSE(before->holds.has_value());
  HoldingRange& range = a.holds.emplace();
  range.yaw_low = {-22.5, "loose"}, range.yaw_high = {45, ""};
  range.pitch_low = {-7.25, "drift"}, range.pitch_high = {25, ""};
  range.actions = {{"jawOpen", 0.625f, "mouth"}, {"jawOpen+mouthSmile", 1, ""}};
  ASSERT_TRUE(write_avatar(path_, a).ok());
  const auto b = read_avatar(path_);
  ASSERT_TRUE(b.ok()) << b.error().what;
  ASSERT_TRUE(b->holds.has_value());
  EXPECT_EQ(b->holds->yaw_low.deg, -22.5);
  EXPECT_EQ(b->holds->yaw_low.fault, "loose");
  EXPECT_EQ(b->holds->yaw_high.deg, 45);
  EXPECT_EQ(b->holds->yaw_high.fault, "");
  EXPECT_EQ(b->holds->pitch_low.deg, -7.25);
  EXPECT_EQ(b->holds->pitch_high.deg, 25);
  ASSERT_EQ(b->holds->actions.size(), 2u);
  EXPECT_EQ(b->holds->actions[0].name, "jawOpen");
  EXPECT_EQ(b->holds->actions[0].amount, 0.625f);
  EXPECT_EQ(b->holds->actions[0].fault, "mouth");
  EXPECT_EQ(b->holds->actions[1].amount, 1);
  range.yaw_low.deg = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(write_avatar(path_, a).ok());
  EXPECT_FALSE(read_avatar(path_).ok());
  range.yaw_low.deg = -500;
  ASSERT_TRUE(write_avatar(path_, a).ok());
  EXPECT_FALSE(read_avatar(path_).ok());
}

TEST_F(AvatarFile, RoundTripKeepsEverything) {
  Avatar a = tiny_avatar();
  a.neck = {-0.16f, -0.11f, {0.001f, -0.135f, -0.02f}};
  a.room = *a.torso;
  a.room->cube.side = 5;
  const int n = a.head.occupancy.resolution;
  for (int i = 0; i < n * n * n; ++i) a.head.opacity.push_back(std::uint8_t(i % 251));
  a.background_fault = "The background was not learnt.";
  a.torso_modes.hem = TorsoHem{-0.2f, 0.01f, -0.1f};
  a.parts = {{"torso", false, true, "none", "It was asked for."},
             {"grid", true, false, "small", "It suffices."}};
  ASSERT_TRUE(write_avatar(path_, a).ok());
  const auto read = read_avatar(path_);
  ASSERT_TRUE(read.ok()) << read.error().what;
  const Avatar& b = *read;
  EXPECT_EQ(a.head.field.parameters, b.head.field.parameters);
  EXPECT_TRUE(a.head.field.config == b.head.field.config);
  EXPECT_EQ(a.head.cube.origin, b.head.cube.origin);
  EXPECT_EQ(a.head.cube.side, b.head.cube.side);
  EXPECT_EQ(a.head.occupancy.bits, b.head.occupancy.bits);
  EXPECT_EQ(a.head.opacity, b.head.opacity);
  ASSERT_TRUE(b.room.has_value());
  EXPECT_EQ(a.room->field.parameters, b.room->field.parameters);
  EXPECT_EQ(b.room->cube.side, 5);
  ASSERT_TRUE(b.torso.has_value());
  EXPECT_EQ(a.torso->field.parameters, b.torso->field.parameters);
  EXPECT_EQ(a.torso->occupancy.bits, b.torso->occupancy.bits);
  EXPECT_EQ(b.background_fault, a.background_fault);
  ASSERT_TRUE(b.torso_modes.hem.has_value());
  EXPECT_EQ(b.torso_modes.hem->height, a.torso_modes.hem->height);
  EXPECT_EQ(b.torso_modes.hem->slope_x, a.torso_modes.hem->slope_x);
  EXPECT_EQ(b.torso_modes.hem->slope_z, a.torso_modes.hem->slope_z);
  ASSERT_EQ(b.parts.size(), 2u);
  EXPECT_EQ(b.parts[0].name, "torso");
  EXPECT_FALSE(b.parts[0].on);
  EXPECT_TRUE(b.parts[0].asked);
  EXPECT_EQ(b.parts[1].value, "small");
  EXPECT_EQ(b.parts[1].reason, "It suffices.");
  EXPECT_EQ(a.condition.mean, b.condition.mean);
  EXPECT_EQ(a.condition.rows, b.condition.rows);
  EXPECT_EQ(a.condition.low, b.condition.low);
  EXPECT_EQ(a.condition.high, b.condition.high);
  EXPECT_EQ(a.person.identity, b.person.identity);
  EXPECT_EQ(a.person.offsets, b.person.offsets);
  EXPECT_EQ(a.head_model_hash, b.head_model_hash);
  EXPECT_EQ(a.neutral.expression, b.neutral.expression);
  ASSERT_EQ(b.seen.size(), 1u);
  EXPECT_EQ(a.seen[0].high, b.seen[0].high);
  EXPECT_EQ(a.world_from_head.matrix(), b.world_from_head.matrix());
  EXPECT_EQ(a.intrinsics.k1, b.intrinsics.k1);
  EXPECT_EQ(a.neck.base, b.neck.base);
  EXPECT_EQ(a.neck.top, b.neck.top);
  EXPECT_EQ(a.neck.middle, b.neck.middle);
  EXPECT_EQ(a.plate.data, b.plate.data);
  EXPECT_EQ(a.steps, b.steps);
  EXPECT_EQ(a.train_seconds, b.train_seconds);
}

TEST_F(AvatarFile, SeparateRoomRoundTripsAndIsRefusedWhenDamaged) {
  const FieldPart room = *tiny_avatar().torso;
  ASSERT_TRUE(write_room(path_, room).ok());
  const auto read = read_room(path_);
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(read->field.parameters, room.field.parameters);
  EXPECT_EQ(read->occupancy.bits, room.occupancy.bits);
  EXPECT_FALSE(read_avatar(path_).ok());
  EXPECT_FALSE(write_room(path_, tiny_avatar().head).ok() && read_room(path_).ok());  // needs an expression
  ASSERT_TRUE(write_room(path_, room).ok());
  const auto bytes = *read_file(path_);
  ASSERT_TRUE(write_file(path_, std::span(bytes.data(), bytes.size() / 2)).ok());
  const auto cut = read_room(path_);
  ASSERT_FALSE(cut.ok());
  EXPECT_NE(cut.error().fix.find("likeness fit"), std::string::npos);
}

TEST_F(AvatarFile, RefusesAnyTruncationWithARemedy) {
  ASSERT_TRUE(write_avatar(path_, tiny_avatar()).ok());
  const auto bytes = *read_file(path_);
  for (const double share : {0.0, 0.00001, 0.001, 0.3, 0.9, 0.99999}) {
    const auto length = std::size_t(share * double(bytes.size()));
    ASSERT_TRUE(write_file(path_, std::span(bytes.data(), length)).ok());
    const auto read = read_avatar(path_);
    ASSERT_FALSE(read.ok()) << length;
    EXPECT_FALSE(read.error().fix.empty());
  }
}

TEST_F(AvatarFile, RefusesAnyFlippedByte) {
  ASSERT_TRUE(write_avatar(path_, tiny_avatar()).ok());
  const auto whole = *read_file(path_);
  std::mt19937 engine(1);
  for (int i = 0; i < 40; ++i) {
    auto bytes = whole;
    const std::size_t at = engine() % bytes.size();
    bytes[at] ^= std::byte(1 + engine() % 255);
    ASSERT_TRUE(write_file(path_, bytes).ok());
    EXPECT_FALSE(read_avatar(path_).ok()) << "byte " << at;
  }
}

// A hostile writer can compute checksums: the contents themselves must be checked.
TEST_F(AvatarFile, RefusesSizesThatContradictTheContents) {
  const SectionFormat format{"LKNSAVTR", 6, "avatar", "fix"};
  ASSERT_TRUE(write_avatar(path_, tiny_avatar()).ok());
  const auto sections = read_sections(path_, format);
  ASSERT_TRUE(sections.ok());
  const std::string meta(reinterpret_cast<const char*>(sections->at("meta").data()),
                         sections->at("meta").size());
  const auto with_meta = [&](const std::string& from, const std::string& to) {
    std::string text = meta;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    Sections changed = *sections;
    changed["meta"] = to_section(std::span<const char>(text.data(), text.size()));
    EXPECT_TRUE(write_sections(path_, format, changed).ok());
    const auto read = read_avatar(path_);
    EXPECT_FALSE(read.ok()) << from << " -> " << to;
    if (!read.ok()) {
      EXPECT_FALSE(read.error().fix.empty());
    }
  };
  with_meta("\"slice_width\":8", "\"slice_width\":9");
  with_meta("\"slice_levels\":2", "\"slice_levels\":1");
  with_meta("\"slice_levels\":2", "\"slice_levels\":0");
  with_meta("\"slice_width\":8", "\"slice_width\":-8");
  with_meta("\"slice_width\":8", "\"slice_width\":1000000000");
  with_meta("\"occupancy_resolution\":8", "\"occupancy_resolution\":400");
  with_meta("\"occupancy_resolution\":8", "\"occupancy_resolution\":2000000");
  with_meta("\"plate_width\":24", "\"plate_width\":25");
  with_meta("\"condition_count\":2", "\"condition_count\":3");
  with_meta("\"position\":[3,3,4,8,4,16]", "\"position\":[3,3,3,8,4,16]");
  with_meta("\"position\":[3,3,4,8,4,16]", "\"position\":[3,3,4,8,16,4]");
  with_meta("\"position\":[3,3,4,8,4,16]", "\"position\":[3,3]");
  with_meta("\"identity\":[", "\"identity\":[\"x\",");
  with_meta("\"torso\":{", "\"torso\":{{");
  with_meta("\"neck\":[0.0,0.0,", "\"neck\":[0.0,0.001,");
  with_meta("\"neck\":[0.0,0.0,", "\"neck\":[null,0.0,");

  Sections missing = *sections;
  missing.erase("head.params");
  ASSERT_TRUE(write_sections(path_, format, missing).ok());
  EXPECT_FALSE(read_avatar(path_).ok());
  Sections nan = *sections;
  const float bad = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(nan["head.params"].data() + 40, &bad, 4);
  ASSERT_TRUE(write_sections(path_, format, nan).ok());
  EXPECT_FALSE(read_avatar(path_).ok());
}

TEST_F(AvatarFile, AMissingFileIsNotFound) {
  const auto read = read_avatar(folder_ / "absent.bin");
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace likeness
