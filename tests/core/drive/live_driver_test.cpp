// Claims about driving live: surplus pictures are dropped in order, rest is learnt first, a lost face and a
// failed source are reported, and the recording is what was shown.
#include "core/drive/live_driver.h"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>

#include "core/base/rigid.h"
#include "tests/core/drive/demo_clip.h"

namespace likeness::test {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr int kNoEnd = std::numeric_limits<int>::max();

// Frames of the demo, or grey ones, at a given interval in ms, as from a camera of 25 frames a second. They
// end after `count`, or once `over`.
class Frames : public FrameSource {
 public:
  Frames(int count, int pace_ms, bool faces, bool breaks, const std::atomic<bool>* over)
      : count_(count), pace_(pace_ms), faces_(faces), breaks_(breaks), over_(over) {}
  Result<std::optional<CapturedFrame>> next(std::stop_token) override {
    if (at_ >= count_ || (over_ && *over_)) {
      if (breaks_) return Error{ErrorCode::failed, "The camera is gone.", "Plug it in again.", ""};
      return std::optional<CapturedFrame>();
    }
    std::this_thread::sleep_for(pace_);
    const auto& known = demo_frames();
    const std::size_t frame = std::size_t(at_++) % known.size();
    return std::optional(
        CapturedFrame{faces_ ? known[frame].rgb : Image8(320, 320, 3, 90), at_ / 25.0, Clock::now()});
  }
  std::string name() const override { return "frames"; }

 private:
  int count_, at_ = 0;
  milliseconds pace_;
  bool faces_, breaks_;
  const std::atomic<bool>* over_;
};

LiveDriver::Open frames(int count, int pace_ms, bool faces = true, bool breaks = false,
                        const std::atomic<bool>* over = nullptr) {
  return [=]() -> Result<std::unique_ptr<FrameSource>> {
    return std::unique_ptr<FrameSource>(std::make_unique<Frames>(count, pace_ms, faces, breaks, over));
  };
}

// Waits until it is so; false after two minutes: then it hangs, however busy the computer.
bool until(const LiveDriver& driver, const std::function<bool(const LiveStatus&)>& so) {
  for (int i = 0; i < 6000; ++i) {
    if (so(driver.status())) return true;
    std::this_thread::sleep_for(milliseconds(20));
  }
  return false;
}
bool is_over(const LiveStatus& status) {
  return status.state == LiveState::ended || status.state == LiveState::failed;
}

TEST(LiveDriver, DropsFramesItCannotKeepUpWithAndKeepsTheOrder) {
  std::vector<DrivenFrame> shown;
  std::atomic<int> pictures = 0;
  std::atomic<bool> over = false;
  LiveDriver driver(frames(kNoEnd, 5, true, false, &over), driven_subject(), {.rest_s = 0.3},
                    [&](const DrivenFrame& frame, Clock::time_point) {
                      shown.push_back(frame);
                      ++pictures;
                      std::this_thread::sleep_for(milliseconds(30));  // a slow picture
                    });
  driver.record(true);
  // The camera goes on until there is something to judge, however slow the machine.
  EXPECT_TRUE(until(driver, [&](const LiveStatus& s) { return pictures >= 10 && s.dropped > 100; }));
  over = true;
  ASSERT_TRUE(until(driver, is_over));
  const LiveStatus status = driver.status();
  EXPECT_EQ(status.state, LiveState::ended);
  EXPECT_EQ(status.tracked + status.dropped, status.captured);  // none is lost in another way
  ASSERT_GE(shown.size(), 10u);
  for (std::size_t i = 1; i < shown.size(); ++i) EXPECT_GT(shown[i].time_s, shown[i - 1].time_s);
  EXPECT_GE(shown.front().time_s, 0.3);  // rest comes first
  const std::vector<DrivenFrame> kept = driver.take_recording();
  EXPECT_LE(kept.size(), shown.size());
  ASSERT_FALSE(kept.empty());
  EXPECT_TRUE(std::ranges::all_of(kept, [&](const DrivenFrame& k) {
    return std::ranges::any_of(shown, [&](const DrivenFrame& s) { return s.time_s == k.time_s; });
  }));
  EXPECT_TRUE(driver.take_recording().empty());
}

TEST(LiveDriver, DrivesFromAFileAtItsOwnPace) {
  std::atomic<int> turned = 0;
  const Pose rest = driven_subject().world_from_head;
  LiveDriver driver(
      [] { return open_clip_source(demo_folder() / "demo.mp4"); }, driven_subject(), {.rest_s = 0.5},
      [&](const DrivenFrame& frame, Clock::time_point captured) {
        EXPECT_LE(captured, Clock::now());
        turned += (inverse(rest) * frame.pose.world_from_head).linear().isIdentity(0.02) ? 0 : 1;
      });
  const auto start = Clock::now();
  ASSERT_TRUE(until(driver, is_over));
  EXPECT_GE(Clock::now() - start, milliseconds(2500));  // no faster than it was filmed
  EXPECT_EQ(driver.status().state, LiveState::ended);
  EXPECT_EQ(driver.status().source, "demo.mp4");
  EXPECT_NE(driver.status().picture, nullptr);
  // A machine too busy to follow drops the frames in which the head turns, as it should.
  constexpr int kFollowed = 30;
  EXPECT_TRUE(turned > 0 || driver.status().tracked < kFollowed) << driver.status().tracked;
}

TEST(LiveDriver, ReportsALostFaceAndDrivesNothing) {
  std::atomic<int> driven = 0;
  LiveDriver driver(frames(kNoEnd, 5, false), driven_subject(), {.rest_s = 0.1},
                    [&](const DrivenFrame&, Clock::time_point) { ++driven; });
  ASSERT_TRUE(until(driver, [](const LiveStatus& s) { return s.state == LiveState::lost && s.error; }));
  EXPECT_FALSE(driver.status().reason.empty());
  EXPECT_FALSE(driver.status().error->fix.empty());
  EXPECT_EQ(driven, 0);
  driver.stop();
  EXPECT_TRUE(until(driver, is_over));
}

TEST(LiveDriver, ReportsASourceThatFails) {
  LiveDriver driver(frames(3, 5, true, true), driven_subject(), {},
                    [](const DrivenFrame&, Clock::time_point) {});
  ASSERT_TRUE(until(driver, is_over));
  EXPECT_EQ(driver.status().state, LiveState::failed);
  EXPECT_EQ(driver.status().error->what, "The camera is gone.");
  LiveDriver absent([] { return open_clip_source("/no/such.mp4"); }, driven_subject(), {},
                    [](const DrivenFrame&, Clock::time_point) {});
  ASSERT_TRUE(until(absent, is_over));
  EXPECT_FALSE(absent.status().error->fix.empty());
}

TEST(LiveDriver, GainsAmplifyAnAction) {
  const auto widest = [](float gain) {
    float most = 0;
    std::atomic<int> shown = 0;
    LiveDriver driver(frames(kNoEnd, 30), driven_subject(), {.rest_s = 0.3},
                      [&](const DrivenFrame& frame, Clock::time_point) {
                        most = std::max(most, frame.pose.articulation.jaw.norm());
                        ++shown;
                      });
    driver.set_gains({{"jawOpen", gain}});
    // However slow the machine, the mouth has opened by then.
    EXPECT_TRUE(until(driver, [&](const LiveStatus&) { return shown >= 40; }));
    driver.stop();
    EXPECT_TRUE(until(driver, is_over));
    return most;
  };
  EXPECT_GT(widest(1), 1.5f * widest(0));
}

TEST(ClipSource, LateReaderSkipsThePicturesInBetween) {
  auto source = open_clip_source(demo_folder() / "demo.mp4");
  ASSERT_TRUE(source.ok());
  const auto first = (*source)->next({});
  ASSERT_TRUE(first.ok() && *first);
  EXPECT_EQ((*first)->time_s, 0);
  std::this_thread::sleep_for(milliseconds(600));
  const auto later = (*source)->next({});
  ASSERT_TRUE(later.ok() && *later);
  EXPECT_GT((*later)->time_s, 0.4);
  std::stop_source stopped;
  stopped.request_stop();
  const auto none = (*source)->next(stopped.get_token());
  EXPECT_TRUE(none.ok() && !*none);
}

}  // namespace
}  // namespace likeness::test
