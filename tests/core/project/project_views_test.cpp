// Claims about a track from a file: what cannot be its head model's is refused, before anything poses it.
#include "core/project/project_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "tests/core/lab/truth/acted_track.h"

namespace likeness {
namespace {

Track fitting_track() {
  Track track = acted_truth(3).track;
  track.head_model_hash = acting_head().hash;
  track.person.identity = Eigen::VectorXf::Zero(acting_head().identity_count());
  track.neutral = neutral_articulation(acting_head());
  return track;
}

TEST(CheckTrackFits, AHeadThatLiesElsewhereIsRefused) {
  const HeadModel& model = acting_head();
  ASSERT_TRUE(check_track_fits(fitting_track(), model).ok());
  const std::pair<const char*, std::function<void(Track&)>> faults[] = {
      {"offsets of 2 m",
       [&](Track& t) { t.person.offsets.assign(std::size_t(model.vertex_count()), Vec3f(0, 2, 0)); }},
      {"identity of 300 each", [](Track& t) { t.person.identity.setConstant(300); }},
      {"a rest of 5 expressions", [](Track& t) { t.neutral.expression = Eigen::VectorXf::Zero(5); }},
      {"a rest of 552", [](Track& t) { t.neutral.expression = Eigen::VectorXf::Zero(552); }}};
  for (const auto& [name, apply] : faults) {
    Track track = fitting_track();
    apply(track);
    const auto fits = check_track_fits(track, model);
    ASSERT_FALSE(fits.ok()) << name;
    EXPECT_EQ(fits.error().code, ErrorCode::bad_input) << name;
    EXPECT_THAT(fits.error().fix, testing::HasSubstr("likeness fit")) << name;
  }
}

}  // namespace
}  // namespace likeness
