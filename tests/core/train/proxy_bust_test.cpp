// Claims about the proxy bust: made of outlines seen from the front alone, it is closed, as wide as they say,
// of a body's thickness, and in the clip's colours; what it does not explain it says.
#include "core/train/proxy_bust.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/train/head_marks.h"
#include "core/train/proxy_head.h"
#include "tests/core/train/filmed_head.h"

namespace likeness {
namespace {

// A body like a standing loaf below the head, its upper edge rounded: half as deep as it is wide at its
// thinnest, painted from left to right.
struct FilmedBody {
  FilmedHead head;
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
  static constexpr float kHalfWidth = 0.17f, kHalfDepth = 0.1f, kHeight = 0.3f;

  FilmedBody() {
    const HeadMarks marks = head_marks(head.model, head.shape);
    const float axis = neck_axis(head.model, head.shape);
    constexpr int kRows = 40, kAround = 96;
    for (int row = 0; row <= kRows; ++row) {
      const float down = kHeight * float(row) / kRows,
                  narrow = std::sqrt(std::min(1.f, 0.02f + down / 0.08f));
      for (int i = 0; i < kAround; ++i) {
        const float turn = 2 * float(M_PI) * float(i) / kAround;
        vertices.push_back({narrow * kHalfWidth * std::sin(turn), marks.base - down,
                            axis + narrow * kHalfDepth * std::cos(turn)});
      }
    }
    for (int row = 0; row < kRows; ++row)
      for (int i = 0; i < kAround; ++i) {
        const int a = row * kAround + i, b = row * kAround + (i + 1) % kAround;
        triangles.push_back({a, a + kAround, b}), triangles.push_back({b, a + kAround, b + kAround});
      }
  }

  static Vec3f colour(const Vec3f& p) { return {0.5f + 0.8f * p.x(), 0.4f, 0.6f}; }

  Image8 silhouette_in(const TrainingView& view) const {
    return silhouette(vertices, triangles, view.camera.intrinsics,
                      view.camera.cam_from_world * view.pose.world_from_torso);
  }
  // Head and body; the head hides the body.
  void draw(const TrainingView& view, Image8& rgb, Image8& alpha) const {
    head.draw(view, rgb, alpha);
    // The model has a bust of its own.
    const std::vector<Vec3f> posed = head.posed(view.pose.articulation);
    const Raster model = rasterise(posed, head.model.triangles, view.camera.intrinsics,
                                   view.camera.cam_from_world * view.pose.world_from_head);
    const float base = head_marks(head.model, head.shape).base;
    for (std::size_t i = 0; i < model.triangle.size(); ++i)
      if (model.triangle[i] >= 0 &&
          posed[std::size_t(head.model.triangles[std::size_t(model.triangle[i])][0])].y() < base)
        alpha.data[i] = 0;
    const Raster body = rasterise(vertices, triangles, view.camera.intrinsics,
                                  view.camera.cam_from_world * view.pose.world_from_torso);
    for (std::size_t i = 0; i < body.triangle.size(); ++i) {
      if (body.triangle[i] < 0 || alpha.data[i] != 0) continue;
      Vec3f place = Vec3f::Zero();
      for (int c = 0; c < 3; ++c)
        place += body.barycentric[i][c] * vertices[std::size_t(triangles[std::size_t(body.triangle[i])][c])];
      for (int c = 0; c < 3; ++c)
        rgb.data[3 * i + std::size_t(c)] = std::uint8_t(std::lround(255 * colour(place)[c]));
      alpha.data[i] = 255;
    }
  }
  TrainingSet filmed() const {
    TrainingSet set = filmed_set(head, 12, 4);
    set.has_torso = true;
    for (TrainingView& view : set.views) {
      view.camera.cam_from_world.translation().z() = 1.6;
      Image8 rgb, alpha;
      draw(view, rgb, alpha);
      view.rgb = std::move(rgb), view.alpha = TiledMask(alpha);
    }
    return set;
  }
};

double overlap(const Image8& a, const Image8& b) {
  int both = 0, either = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    both += a.data[i] != 0 && b.data[i] != 0, either += a.data[i] != 0 || b.data[i] != 0;
  return double(both) / either;
}

class ProxyBustOf : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    body_ = new FilmedBody;
    set_ = new TrainingSet(body_->filmed());
    proxy_ = new ProxyHead(make_proxy_head(*set_, body_->head.shape));
    part_ = new ProxyPart(head_part(set_->model, *proxy_));
    bust_ = new std::optional<ProxyBust>(make_proxy_bust(*set_, body_->head.shape, *part_));
  }
  static void TearDownTestSuite() { delete bust_, delete part_, delete proxy_, delete set_, delete body_; }
  void SetUp() override { ASSERT_TRUE(bust_->has_value()); }

  static FilmedBody* body_;
  static TrainingSet* set_;
  static ProxyHead* proxy_;
  static ProxyPart* part_;
  static std::optional<ProxyBust>* bust_;
};
FilmedBody* ProxyBustOf::body_ = nullptr;
TrainingSet* ProxyBustOf::set_ = nullptr;
ProxyHead* ProxyBustOf::proxy_ = nullptr;
ProxyPart* ProxyBustOf::part_ = nullptr;
std::optional<ProxyBust>* ProxyBustOf::bust_ = nullptr;

TEST_F(ProxyBustOf, AnOutlineIsClosed) {
  std::map<std::pair<int, int>, int> edges;  // each is met once in either direction
  for (const Triangle& t : (*bust_)->part.triangles)
    for (int c = 0; c < 3; ++c) ++edges[{t[std::size_t(c)], t[std::size_t((c + 1) % 3)]}];
  ASSERT_GT(edges.size(), 1000u);
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    ASSERT_NE(back, edges.end());
    EXPECT_EQ(back->second, count);
  }
}

TEST_F(ProxyBustOf, ABodyLooksAboutLikeItFromTheSide) {
  for (const double degrees : {-70.0, -30.0, 0.0, 30.0, 70.0}) {
    TrainingView view = set_->views[0];
    Pose turn = Pose::Identity();
    turn.linear() = Eigen::AngleAxisd(degrees * M_PI / 180, Vec3d::UnitY()).toRotationMatrix();
    view.pose.world_from_torso = view.pose.world_from_torso * turn;
    const PosedSurface posed = (*bust_)->part.pose(view);
    const Image8 bust = silhouette(posed.vertices, (*bust_)->part.triangles, view.camera.intrinsics,
                                   view.camera.cam_from_world * posed.world_from_surface);
    EXPECT_GT(overlap(bust, body_->silhouette_in(view)), 0.8) << degrees;
  }
}

TEST_F(ProxyBustOf, AClipHasItsColours) {
  const PosedSurface posed = (*bust_)->part.pose(set_->views[0]);
  float lowest = 0;  // where the picture ends, nearer places are cut off above farther ones
  for (const Vec3f& p : posed.vertices) lowest = std::min(lowest, p.y());
  int front = 0;
  for (std::size_t v = 0; v < posed.vertices.size(); ++v) {
    const Vec3f& p = posed.vertices[v];
    if (p.z() < (*bust_)->axis_z + 0.08f || p.y() > (*bust_)->top - 0.1f || p.y() < lowest + 0.05f ||
        std::abs(p.x()) > 0.12f)
      continue;
    ++front;
    const Vec3f error = (*bust_)->part.colours[v] - FilmedBody::colour(p);
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 0.05f) << p.transpose();
  }
  EXPECT_GT(front, 200);
}

TEST_F(ProxyBustOf, ABodyExplainsIt) {
  EXPECT_LT((*bust_)->unexplained, 0.04);
  TrainingSet waving = *set_;  // an arm beside the body in some of the frames
  for (std::size_t v = 0; v < waving.views.size(); v += 3) {
    Image8 alpha = to_image(waving.views[v].alpha);
    for (int y = 100; y < 128; ++y)
      for (int x = 0; x < 26; ++x) *alpha.at(x, y) = 255;
    waving.views[v].alpha = TiledMask(alpha);
  }
  const auto bust = make_proxy_bust(waving, body_->head.shape, *part_);
  ASSERT_TRUE(bust.has_value());
  EXPECT_GT(bust->unexplained, (*bust_)->unexplained + 0.02);
}

TEST_F(ProxyBustOf, NoBodyIsNone) {
  TrainingSet head_alone = *set_;
  head_alone.has_torso = false;
  EXPECT_FALSE(make_proxy_bust(head_alone, body_->head.shape, *part_).has_value());
  head_alone.has_torso = true;  // mattes that end at the neck
  const float base = head_marks(set_->model, body_->head.shape).base;
  for (TrainingView& view : head_alone.views) {
    Image8 alpha = to_image(view.alpha);
    const HalfPicture below = other_half(above_place(view, view.pose.world_from_torso, {0, double(base), 0}));
    for (int y = 0; y < alpha.height; ++y)
      for (int x = 0; x < alpha.width; ++x)
        if (below.at(x, y)) *alpha.at(x, y) = 0;
    view.alpha = TiledMask(alpha);
  }
  EXPECT_FALSE(make_proxy_bust(head_alone, body_->head.shape, *part_).has_value());
}

}  // namespace
}  // namespace likeness
