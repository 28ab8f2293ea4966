// Claims about a film's tag of its lens: found in the track as a phone writes it and in the film as editors
// do, as any type of number, and ignored if it is not a valid one.
#include "core/video/lens_tag.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/files.h"
#include "core/video/decode.h"
#include "core/video/frame_source.h"
#include "tests/core/video/film_boxes.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

using test::box, test::film, test::kFocalTag, test::meta, test::number;
namespace fs = std::filesystem;

class LensTag : public InFolder {
 protected:
  double of(const std::string& bytes) const {
    const fs::path path = folder_ / "film.mov";
    EXPECT_TRUE(write_text(path, bytes).ok());
    return read_focal_35mm(path);
  }
};

TEST_F(LensTag, AcceptsNumbersOfAnyType) {
  for (const auto& [type, bytes, focal] : std::vector<std::tuple<std::uint64_t, std::string, double>>{
           {1, "26", 26},
           {1, "25.50mm", 25.5},
           {21, number(27, 1), 27},
           {21, number(27, 4), 27},
           {67, number(13, 4), 13},
           {77, number(120, 4), 120},
           {78, number(24, 8), 24},
           {23, number(std::bit_cast<std::uint32_t>(26.5f), 4), 26.5},
           {24, number(std::bit_cast<std::uint64_t>(31.25), 8), 31.25}})
    EXPECT_DOUBLE_EQ(of(film(meta({{"com.apple.quicktime.make", 1, "Apple"}, {kFocalTag, type, bytes}}))),
                     focal)
        << type << " of " << bytes.size() << " bytes";
}

TEST_F(LensTag, TrackTagTakesPrecedenceOverTheFilms) {
  const std::string track = meta({{kFocalTag, 1, "26"}}), whole = meta({{kFocalTag, 1, "48"}});
  EXPECT_DOUBLE_EQ(of(film(track, whole)), 26);
  EXPECT_DOUBLE_EQ(of(film("", whole)), 48);
  EXPECT_DOUBLE_EQ(of(film("", box("udta", whole))), 48);
  EXPECT_DOUBLE_EQ(of(film(meta({{"other", 1, "26"}}), whole)), 48);
  EXPECT_DOUBLE_EQ(of(film(meta({{kFocalTag, 1, "26"}}, number(0, 4)))), 26);  // ISO's form, with a version
}

TEST_F(LensTag, IgnoresImpossibleFocalLengths) {
  for (const auto& [type, bytes] :
       std::vector<std::pair<std::uint64_t, std::string>>{{1, ""},
                                                          {1, "wide"},
                                                          {1, "nan"},
                                                          {1, "1e9"},
                                                          {1, "-26"},
                                                          {1, "0"},
                                                          {67, number(std::uint64_t(-26), 4)},
                                                          {65, number(std::uint64_t(-26), 1)},
                                                          {21, number(std::uint64_t(-26), 1)},
                                                          {22, number(26, 1) + std::string(8, '\0')},
                                                          {1, "5.1 mm (35 mm equivalent: 26.0 mm)"},
                                                          {1, "4.25"},
                                                          {23, number(0x7fc00000, 4)},  // not a number
                                                          {23, number(0, 2)},
                                                          {13, "26"}})  // a picture
    EXPECT_EQ(of(film(meta({{kFocalTag, type, bytes}}))), 0) << type << " " << bytes;
  EXPECT_EQ(of(film("")), 0);
  EXPECT_EQ(of("no film at all"), 0);
  EXPECT_EQ(read_focal_35mm(folder_ / "absent.mov"), 0);
}

TEST_F(LensTag, IsAbsentForATruncatedFilm) {
  const std::string whole = film(meta({{kFocalTag, 1, "26"}}));
  ASSERT_GT(of(whole), 0);
  for (std::size_t length = 0; length < whole.size(); ++length) EXPECT_EQ(of(whole.substr(0, length)), 0);
}

TEST_F(LensTag, IsReportedByTheProbe) {
  write_clip(folder_ / "plain.mp4", 64, 48, 5, 25);
  EXPECT_EQ(probe_video(folder_ / "plain.mp4")->focal_35mm, 0);
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "needs the ffmpeg program";
  const std::string tagged = (folder_ / "tagged.mov").string();
  ASSERT_EQ(
      std::system(("ffmpeg -loglevel error -i '" + (folder_ / "plain.mp4").string() +
                   "' -c copy -movflags use_metadata_tags -metadata " + kFocalTag + "=26 '" + tagged + "'")
                      .c_str()),
      0);
  EXPECT_DOUBLE_EQ(probe_video(tagged)->focal_35mm, 26);
  const auto source = open_clip_source(tagged);
  ASSERT_TRUE(source.ok());
  const auto frame = (*source)->next({});
  ASSERT_TRUE(frame.ok() && *frame);
  EXPECT_DOUBLE_EQ((*frame)->focal_35mm, 26);  // what drives an avatar live
}

}  // namespace
}  // namespace likeness
