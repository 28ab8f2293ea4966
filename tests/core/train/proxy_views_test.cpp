// Claims about the pictures that nobody filmed: beside what was filmed they show the same head, they leave
// unsaid what is not known, and where the clip looked everywhere there are none.
#include "core/train/proxy_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/rigid.h"
#include "core/train/hair_hull.h"
#include "core/train/proxy_head.h"
#include "tests/core/train/filmed_head.h"

namespace likeness {
namespace {

constexpr double kToDegrees = 180 / std::numbers::pi;

Vec3d seen_from(const TrainingSet& set, const TrainingView& view) {
  const Vec3d middle = head_middle(set.model, pose_head(set.model, shape_head(set.model, set.person),
                                                        neutral_articulation(set.model)))
                           .cast<double>();
  const Pose head_from_cam = inverse(view.camera.cam_from_world * view.pose.world_from_head);
  return (head_from_cam.translation() - middle).normalized();
}

// Bald, so that the model itself is the truth from every side.
class ProxyViews : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    head_ = new FilmedHead;
    set_ = new TrainingSet(filmed_set(*head_, 12, 4));
    ProxyViewOptions options;
    options.least = 12, options.face_share = 0, options.face_least = 0;
    proxies_ = new std::vector<TrainingView>(make_proxy_views(*set_, options));
  }
  static void TearDownTestSuite() { delete proxies_, delete set_, delete head_; }
  static FilmedHead* head_;
  static TrainingSet* set_;
  static std::vector<TrainingView>* proxies_;
};
FilmedHead* ProxyViews::head_ = nullptr;
TrainingSet* ProxyViews::set_ = nullptr;
std::vector<TrainingView>* ProxyViews::proxies_ = nullptr;

TEST_F(ProxyViews, LieBesideEveryFilmedView) {
  ASSERT_EQ(proxies_->size(), 12u);
  for (const TrainingView& proxy : *proxies_) {
    EXPECT_FALSE(proxy.has_plate);
    for (const TrainingView& view : set_->views)
      EXPECT_GT(std::acos(std::min(1.0, seen_from(*set_, proxy).dot(seen_from(*set_, view)))) * kToDegrees,
                12);
  }
}

TEST_F(ProxyViews, ShowTheSameHeadWhereTheyTeach) {
  double error = 0, skin = 0;
  int outline_wrong = 0, taught = 0;
  for (const TrainingView& proxy : *proxies_) {
    Image8 rgb, alpha;
    head_->draw(proxy, rgb, alpha);
    for (int y = 0; y < alpha.height; ++y)
      for (int x = 0; x < alpha.width; ++x) {
        if (proxy.teaches.at(x, y) == 0) continue;
        ++taught;
        outline_wrong += (proxy.alpha.at(x, y) == 255) != (*alpha.at(x, y) == 255);
        if (proxy.alpha.at(x, y) == 0 || *alpha.at(x, y) == 0) continue;
        ++skin;
        for (int c = 0; c < 3; ++c) error += std::abs(proxy.rgb.at(x, y)[c] - rgb.at(x, y)[c]) / 3.0;
      }
  }
  ASSERT_GT(taught, 12 * 128 * 128 / 4);
  EXPECT_LT(outline_wrong, taught / 500);
  EXPECT_LT(error / skin, 6) << "levels: seen places are copied, the others guessed from those around them";
}

TEST_F(ProxyViews, AreTheSameEachTime) {
  ProxyViewOptions options;
  options.least = 12, options.face_share = 0, options.face_least = 0;
  const std::vector<TrainingView> again = make_proxy_views(*set_, options);
  ASSERT_EQ(again.size(), proxies_->size());
  for (std::size_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(again[i].rgb.data, (*proxies_)[i].rgb.data);
    EXPECT_EQ(to_image(again[i].teaches).data, to_image((*proxies_)[i].teaches).data);
  }
}

// By the slightest error of the fit what stands beside a face lies over its edge: an ear, a glasses' bow.
TEST_F(ProxyViews, TakeNoColourFromTheEdgeOfAFace) {
  constexpr float kEdge = 0.25f;  // cosine
  TrainingSet edged = *set_;
  for (TrainingView& view : edged.views) {
    const std::vector<Vec3f> posed = head_->posed(view.pose.articulation),
                             normals = vertex_normals(posed, edged.model.triangles);
    const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
    const Vec3f eye = inverse(cam_from_head).translation().cast<float>();
    const Raster raster = rasterise(posed, edged.model.triangles, view.camera.intrinsics, cam_from_head);
    for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
      if (raster.triangle[i] < 0) continue;
      const Triangle& triangle = edged.model.triangles[std::size_t(raster.triangle[i])];
      Vec3f place = Vec3f::Zero(), normal = place;
      for (int c = 0; c < 3; ++c)
        place += raster.barycentric[i][c] * posed[std::size_t(triangle[c])],
            normal += raster.barycentric[i][c] * normals[std::size_t(triangle[c])];
      if (normal.normalized().dot((eye - place).normalized()) > kEdge) continue;
      view.rgb.data[3 * i] = 255, view.rgb.data[3 * i + 1] = view.rgb.data[3 * i + 2] = 0;
    }
  }
  int taught = 0, red = 0;
  ProxyViewOptions options;
  options.least = 12, options.face_share = 0, options.face_least = 0;
  for (const TrainingView& proxy : make_proxy_views(edged, options))
    for (int y = 0; y < proxy.rgb.height; ++y)
      for (int x = 0; x < proxy.rgb.width; ++x) {
        if (proxy.teaches.at(x, y) == 0 || proxy.alpha.at(x, y) == 0) continue;
        const std::uint8_t* c = proxy.rgb.at(x, y);
        if (y < 50) continue;  // hair
        ++taught, red += c[0] > 200 && c[1] < 80 && c[2] < 80;
      }
  ASSERT_GT(taught, 12 * 2000);
  EXPECT_LT(red, taught / 200) << taught;
}

TEST_F(ProxyViews, SayNothingBesideAHeadThatTheyDoNotExplain) {
  TrainingSet hands = *set_;  // beside the face in all mattes, farther out than hair may be
  for (TrainingView& view : hands.views) {
    Image8 alpha = to_image(view.alpha);
    for (int y = 40; y < 70; ++y)
      for (int x = 0; x < 128; ++x) *alpha.at(x, y) = 255;
    view.alpha = TiledMask(alpha);
  }
  for (const TrainingView& proxy : make_proxy_views(hands, {.least = 4}))
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x)
        if (proxy.alpha.at(x, y) == 0) {
          EXPECT_EQ(proxy.teaches.at(x, y), 0);
        }
}

// Hair that falls before the shoulders: the crown is explained, what is beside the cheeks is not.
TEST_F(ProxyViews, StillKnowTheCrownWhereHairHangs) {
  TrainingSet hair = *set_;
  for (TrainingView& view : hair.views) {
    Image8 alpha = to_image(view.alpha);
    for (int y = 70; y < 128; ++y)
      for (int x = 20; x < 108; ++x) *alpha.at(x, y) = 255;
    view.alpha = TiledMask(alpha);
  }
  int beside_crown = 0, beside_cheeks = 0;
  for (const TrainingView& proxy : make_proxy_views(hair, {.least = 4}))
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x) {
        if (proxy.alpha.at(x, y) != 0 || proxy.teaches.at(x, y) == 0) continue;
        ++(y < 50 ? beside_crown : beside_cheeks);
      }
  EXPECT_GT(beside_crown, 4 * 1000);
  EXPECT_LT(beside_cheeks, beside_crown / 5);
}

// The model's neck is open below: who looks up into it sees its inner side, which is nowhere.
TEST_F(ProxyViews, DoNotTeachTheInsideOfTheNeck) {
  int from_below = 0;
  for (const TrainingView& proxy : *proxies_) {
    const Pose cam_from_head = proxy.camera.cam_from_world * proxy.pose.world_from_head;
    const std::vector<Vec3f> posed = head_->posed(proxy.pose.articulation);
    const Vec3f eye = inverse(cam_from_head).translation().cast<float>();
    from_below += eye.y() < -0.2f;
    const Raster raster = rasterise(posed, head_->model.triangles, proxy.camera.intrinsics, cam_from_head);
    int inner_taught = 0;
    for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
      if (raster.triangle[i] < 0) continue;
      const Triangle& t = head_->model.triangles[std::size_t(raster.triangle[i])];
      const Vec3f &a = posed[std::size_t(t[0])], &b = posed[std::size_t(t[1])], &c = posed[std::size_t(t[2])];
      const bool inner = (b - a).cross(c - a).dot(eye - a) < 0;
      inner_taught += inner && proxy.teaches.at(int(i % 128), int(i / 128)) > 0;
    }
    EXPECT_LE(inner_taught, 5);
  }
  EXPECT_GT(from_below, 0);
}

// Sides that a further clip filmed need no proxy.
TEST_F(ProxyViews, KeepAwayFromFurtherClipsToo) {
  TrainingSet more = *set_;
  for (const double turn : {-0.6, 0.6}) {
    TrainingView side = more.views[0];
    side.further_clip = 2;
    side.pose.world_from_head.linear() = head_turn(turn, 0, 0);
    more.views.push_back(side);
  }
  const std::vector<TrainingView> proxies =
      make_proxy_views(more, {.least = 12, .face_share = 0, .face_least = 0});
  ASSERT_FALSE(proxies.empty());
  for (const TrainingView& proxy : proxies)
    for (const TrainingView& view : more.views)
      EXPECT_GT(std::acos(std::min(1.0, seen_from(more, proxy).dot(seen_from(more, view)))) * kToDegrees, 12);
}

// Faces at rest in all views: proxies open the mouth, and show the same head where they say what it looks
// like.
TEST_F(ProxyViews, PerformWhatTheClipNeverShows) {
  const std::vector<TrainingView> faces =
      make_proxy_views(*set_, {.share = 0, .least = 0, .face_least = 24, .face_yaw_deg = 10});
  ASSERT_EQ(faces.size(), 24u);
  double error = 0, compared = 0;
  int open = 0, moved = 0;
  for (const TrainingView& proxy : faces) {
    EXPECT_EQ(proxy.part, LearntPart::head);
    const Articulation& face = proxy.pose.articulation;
    open += face.jaw.norm() > 0.1f, moved += face.expression.norm() > 0.1f;
    Image8 rgb, alpha;
    head_->draw(proxy, rgb, alpha);
    const std::vector<Vec3f> posed = head_->posed(face);
    const Raster raster = rasterise(posed, head_->model.triangles, proxy.camera.intrinsics,
                                    proxy.camera.cam_from_world * proxy.pose.world_from_head);
    for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
      const int x = int(i % 128), y = int(i / 128);
      if (raster.triangle[i] < 0 || proxy.teaches.at(x, y) == 0 || proxy.alpha.at(x, y) == 0) continue;
      const int v = head_->model.triangles[std::size_t(raster.triangle[i])][0];
      if (!is_skin(head_->model, std::size_t(v))) continue;  // what was hidden is guessed
      ++compared;
      for (int c = 0; c < 3; ++c) error += std::abs(proxy.rgb.at(x, y)[c] - rgb.at(x, y)[c]) / 3.0;
    }
  }
  EXPECT_GT(open, 6);
  EXPECT_GT(moved, 12);
  EXPECT_GT(compared, 24 * 2000);
  EXPECT_LT(error / compared, 6);
}

TEST_F(ProxyViews, NeedMattesAndSidesThatWereNotFilmed) {
  TrainingSet bare = *set_;
  bare.views[3].alpha = {};
  EXPECT_TRUE(make_proxy_views(bare).empty());
  TrainingSet few = *set_;
  few.views.resize(4);
  EXPECT_TRUE(make_proxy_views(few).empty());
  ProxyViewOptions all_seen;
  all_seen.face_share = 0, all_seen.face_least = 0;
  all_seen.yaw_deg = 8, all_seen.pitch_deg = 5;  // nothing there lies 12 degrees beside
  EXPECT_TRUE(make_proxy_views(*set_, all_seen).empty());
}

TEST(HairHull, IsAsThickAsTheMatteSaysAndLeavesEarsAlone) {
  constexpr float kHair = 0.02f;
  FilmedHead head;
  head.hair = kHair;
  const TrainingSet set = filmed_set(head, 8, 4, 256);
  const ProxyHead proxy = make_proxy_head(set, head.shape);
  const std::vector<Vec3f> rest = pose_head(head.model, head.shape, neutral_articulation(head.model));
  const HeadMarks marks = head_marks(head.model, head.shape);
  std::vector<float> crown;
  float on_face = 0;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    if (!is_skin(head.model, v)) {
      EXPECT_EQ(proxy.hair[v], 0) << "an eye, a tooth";
    } else if (rest[v].y() > marks.brow + 0.08f && std::abs(rest[v].z() - marks.ear_z) < 0.03f) {
      crown.push_back(proxy.hair[v]);
    } else if (hairiness(marks, rest[v]) == 0) {
      on_face = std::max(on_face, proxy.hair[v]);
    }
  }
  ASSERT_GT(crown.size(), 20u);
  std::nth_element(crown.begin(), crown.begin() + std::ptrdiff_t(crown.size() / 2), crown.end());
  EXPECT_NEAR(crown[crown.size() / 2], kHair, 0.004f);
  EXPECT_EQ(on_face, 0);
  EXPECT_LT(proxy.unexplained, 0.04);
  head.hair = 0;
  const ProxyHead bald = make_proxy_head(filmed_set(head, 8, 4, 256), head.shape);
  for (const float thickness : bald.hair) EXPECT_LT(thickness, 0.006f);
}

}  // namespace
}  // namespace likeness
