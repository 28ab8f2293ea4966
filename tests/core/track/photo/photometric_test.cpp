#include "core/track/photo/photometric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/base/rigid.h"
#include "core/scene/head_regions.h"
#include "core/scene/mesh_scene.h"
#include "core/track/photo/photometric_mouth.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

constexpr int kPhotoSize = 256;
const Intrinsics kPhotoLens{kPhotoSize, kPhotoSize, 400, 400, 128, 128, 0.02, -0.01, 0.001, -0.002};

const FaceSurface& surface() {
  static const FaceSurface s = face_surface(test_head(), test_shape());
  return s;
}
const ReducedPerson& person() {
  static const ReducedPerson p =
      reduced_person(test_reduced_head(), Eigen::VectorXd::Zero(test_reduced_head().identity_count()));
  return p;
}

FaceState state_of(double yaw, double jaw, double smile) {
  FaceState s;
  s.cam_from_head = facing_pose(yaw, 0, Vec3d(0, 0.01, 0.5));
  s.jaw = jaw;
  s.expression = Eigen::VectorXd::Zero(test_head().expression_count());
  for (int e = 0; e < test_head().expression_count(); ++e)
    if (test_head().expression_names[e].starts_with("mouthSmile")) s.expression[e] = smile;
  return s;
}

ShVector side_light() {
  ShVector light = ShVector::Zero();
  light << 1, 0.25, 0.15, 0.2, 0, 0, 0, 0, 0;
  return light;
}

// Skin with spots of some millimetres, red lips darker, the mouth's inside black.
double painted(int point) {
  const Vec3d p = surface().person.base.segment<3>(3 * point);
  const double spots =
      std::sin(700 * p.x() + 1) * std::sin(600 * p.y()) + 0.5 * std::sin(1500 * p.x() + 900 * p.y());
  return (surface().zone[point] == FaceZone::lip ? 0.12 : 0.30) * (1 + 0.25 * spots);
}

Image8 film(const FaceState& state, double inside_level = 12) {
  const PosedSurface posed = posed_surface(surface(), state.expression, state.jaw);
  std::vector<Vec3f> vertices = posed.points;
  Articulation face = neutral_articulation(test_head());
  face.expression = state.expression.cast<float>();
  face.jaw.x() = static_cast<float>(state.jaw);
  const std::vector<Vec3f> inside = pose_head(test_head(), test_shape(), face);
  vertices.insert(vertices.end(), inside.begin(), inside.end());
  std::vector<Triangle> triangles = surface().triangles;
  const HeadRegions regions = head_regions(test_head());
  for (std::size_t t = 0; t < test_head().triangles.size(); ++t)
    if (regions.mouth_interior[t])
      triangles.push_back(test_head().triangles[t] + Triangle::Constant(surface().points.points));
  Image8 fine(2 * kPhotoSize, 2 * kPhotoSize, 1, 40);
  Intrinsics lens = kPhotoLens;
  lens.width *= 2, lens.height *= 2, lens.fx *= 2, lens.fy *= 2, lens.cx *= 2, lens.cy *= 2;
  const Raster raster = rasterise(vertices, triangles, lens, state.cam_from_head);
  for (std::size_t i = 0; i < fine.data.size(); ++i) {
    const int t = raster.triangle[i];
    if (t < 0) continue;
    double level = inside_level;
    if (t < static_cast<int>(surface().triangles.size())) {
      double albedo = 0;
      Vec3d normal = Vec3d::Zero();
      for (int k = 0; k < 3; ++k) {
        const int p = triangles[t][k];
        albedo += raster.barycentric[i][k] * painted(p);
        normal += raster.barycentric[i][k] * posed.normals[p].cast<double>();
      }
      level = encoded_of_linear(albedo *
                                shade(side_light(), (state.cam_from_head.linear() * normal).normalized()));
    }
    fine.data[i] = static_cast<std::uint8_t>(std::clamp(level, 0.0, 255.0));
  }
  return resize(fine, kPhotoSize, kPhotoSize);
}

TEST(Lighting, FindsAlbedoAndLightUpToTheirCommonScale) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  const int points = 200;
  std::vector<std::vector<LightSample>> pictures(20);
  for (auto& picture : pictures)
    for (int p = 0; p < points; ++p) {
      const Vec3f n = Vec3f(normal(random), normal(random), -2 + normal(random)).normalized();
      const double albedo = 0.1 + 0.002 * p;
      double linear = albedo * shade(side_light(), n.cast<double>());
      if (p % 17 == 0 && &picture - pictures.data() < 4) linear = 1;  // glints
      picture.push_back({p, n, static_cast<float>(linear), 1});
    }
  const LitPoints lit = light_points(pictures, points);
  for (int p = 0; p < points; ++p)
    for (const Vec3d& n : {Vec3d(0, 0, -1), Vec3d(0.6, 0, -0.8)}) {
      const double truth = (0.1 + 0.002 * p) * shade(side_light(), n);
      EXPECT_NEAR(lit.albedo[p] * shade(lit.light, n), truth, 0.04 * truth) << p;
    }
}

TEST(FaceSurface, TheMouthByItselfMovesWithTheFaceAndTheModel) {
  const MouthSurface& mouth = surface().mouth;
  ASSERT_GT(mouth.skin.size(), 100u);
  ASSERT_GT(mouth.triangles.size(), mouth.skin_triangles);
  const FaceState state = state_of(0, 0.25, 0.6);
  const PosedSurface all = posed_surface(surface(), state.expression, state.jaw),
                     own = posed_surface(mouth, state.expression, state.jaw);
  for (std::size_t p = 0; p < mouth.skin.size(); ++p)
    EXPECT_LT((own.points[p] - all.points[mouth.skin[p]]).norm(), 1e-6f) << p;
  Articulation face = neutral_articulation(test_head());
  face.expression = state.expression.cast<float>();
  face.jaw.x() = static_cast<float>(state.jaw);
  const std::vector<Vec3f> model = pose_head(test_head(), test_shape(), face);
  const HeadRegions regions = head_regions(test_head());
  std::size_t t = mouth.skin_triangles;
  for (std::size_t m = 0; m < test_head().triangles.size(); ++m) {
    if (!regions.mouth_interior[m]) continue;
    ASSERT_LT(t, mouth.triangles.size());
    for (int k = 0; k < 3; ++k)
      EXPECT_LT((own.points[mouth.triangles[t][k]] - model[test_head().triangles[m][k]]).norm(), 1e-4f) << m;
    ++t;
  }
  EXPECT_EQ(t, mouth.triangles.size());
}

TEST(Photometric, DerivativesMatchFiniteDifferences) {
  FacePicture picture = face_picture(Image8(kPhotoSize, kPhotoSize, 1), kPhotoLens);
  for (int l = 0; l < kPictureLevels; ++l)
    for (int y = 0; y < picture.picture[l].height; ++y)
      for (int x = 0; x < picture.picture[l].width; ++x)
        *picture.picture[l].at(x, y) =
            static_cast<float>(120 + 60 * std::sin(0.11 * (x << l)) * std::cos(0.07 * (y << l) + 0.3));
  const FaceState state = state_of(0.3, 0.1, 0.4);
  FaceTarget target;
  target.level = 0;
  for (int p : surface().fine) {
    target.point.push_back(p);
    target.value.push_back(110 + 40 * std::sin(0.3 * p));
    target.scale.push_back(1.0 / 12);
  }
  const int unknowns = 7 + test_head().expression_count();
  const auto cost = [&](const FaceState& s) {
    FrameSystem system;
    add_photometric(surface(), picture, target, 0.5, s, &system);
    return system.cost;
  };
  FrameSystem system;
  system.hessian = Eigen::MatrixXd::Zero(unknowns, unknowns);
  system.gradient = Eigen::VectorXd::Zero(unknowns);
  add_photometric(surface(), picture, target, 0.5, state, &system);
  EXPECT_NEAR(system.cost, cost(state), 1e-9 * system.cost);
  const double largest = system.gradient.cwiseAbs().maxCoeff();
  for (int k = 0; k < unknowns; ++k) {
    // Small steps: between two pixels the picture is smooth, at a pixel's border its slope jumps.
    const double step = 1e-7;
    Eigen::VectorXd increment = Eigen::VectorXd::Zero(unknowns);
    increment[k] = step;
    const double numeric = (cost(moved(state, increment)) - cost(moved(state, -increment))) / (2 * step);
    EXPECT_NEAR(system.gradient[k], numeric, 1e-4 * largest + 1e-3 * std::abs(numeric)) << "unknown " << k;
  }
}

// A short clip whose landmarks say that the jaw is more open than it is, in some frames.
struct JawClip {
  std::vector<FaceState> truth;
  std::vector<Image8> greys;
  std::vector<FaceFrame> faces;
  std::vector<PhotometricFrame> pictures;
};
JawClip make_jaw_clip(int count) {
  JawClip clip;
  for (int i = 0; i < count; ++i) {
    const double jaw = 0.12 + 0.12 * std::sin(0.8 * i);
    clip.truth.push_back(
        state_of(0.25 * std::sin(0.5 * i), std::max(0.0, jaw), 0.3 + 0.3 * std::cos(0.6 * i)));
    clip.greys.push_back(film(clip.truth.back()));
    FaceFrame f;
    f.frame = i;
    f.seen = f.pose_given = true;
    f.held_out = i + 3 >= count;
    FaceState wrong = clip.truth.back();
    wrong.jaw += i % 2 ? 0.03 : -0.02;
    f.observation = observe_state(test_reduced_head(), person(), wrong, 1.0, 7 + i);
    f.observation.focal_px = kPhotoLens.fx;
    f.state = wrong;
    f.state.cam_from_head.translation() += Vec3d(0.0004, -0.0003, 0.001);
    clip.faces.push_back(f);
  }
  for (const Image8& g : clip.greys) clip.pictures.push_back({&g, kPhotoLens, Mat3d::Identity()});
  return clip;
}

Result<PhotometricSummary> refine(JawClip& clip, std::stop_token stop = {}) {
  const ExpressionPrior prior = expression_prior(test_head());
  PhotometricOptions options;
  options.expression_change = 0.5;  // this clip jumps from frame to frame
  return refine_photometric(test_head(), test_shape(), test_reduced_head(), person(), prior, clip.pictures,
                            options, clip.faces, Progress(), stop);
}

double jaw_error(const JawClip& clip) {
  double sum = 0;
  for (std::size_t i = 0; i < clip.truth.size(); ++i)
    sum += std::abs(clip.faces[i].state.jaw - clip.truth[i].jaw) / static_cast<double>(clip.truth.size());
  return sum;
}

TEST(Photometric, PicturesCorrectWhatLandmarksSayOfTheJaw) {
  JawClip clip = make_jaw_clip(14);
  const double before = jaw_error(clip);
  const auto summary = refine(clip);
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->refined, 14);
  EXPECT_LT(summary->error_after, summary->error_before);
  EXPECT_LT(jaw_error(clip), 0.7 * before);
}

// Usual error of the heads' turns, degrees, after poses that were off by about two, to either side.
double turn_error_after(bool pose_given) {
  JawClip clip = make_jaw_clip(14);
  for (std::size_t i = 0; i < clip.greys.size(); ++i) {
    clip.pictures[i].grey = &clip.greys[i];
    FaceFrame& face = clip.faces[i];
    face.pose_given = pose_given;
    const Vec3d off(0.03 * std::cos(2.4 * double(i)), 0.04 * std::sin(1.7 * double(i)), 0);
    face.state.cam_from_head.linear() = turn_from_vector(off) * face.state.cam_from_head.linear();
  }
  EXPECT_TRUE(refine(clip));
  double sum = 0;
  for (std::size_t i = 0; i < clip.truth.size(); ++i) {
    const Mat3d off =
        clip.faces[i].state.cam_from_head.linear() * clip.truth[i].cam_from_head.linear().transpose();
    sum += vector_from_turn(off).squaredNorm();
  }
  return std::sqrt(sum / double(clip.truth.size())) * 180 / std::numbers::pi;
}

TEST(Photometric, APoseByLandmarksYieldsAndADenseOneHolds) {
  const double dense = turn_error_after(true), landmarks = turn_error_after(false);
  EXPECT_GT(dense, 1.7);
  EXPECT_LT(landmarks, 0.6 * dense);
}

TEST(Photometric, HeldOutPicturesInfluenceNoTrainingFrame) {
  JawClip a = make_jaw_clip(9), b = a;
  for (std::size_t i = 0; i < b.greys.size(); ++i) b.pictures[i].grey = &b.greys[i];
  for (std::size_t i = 0; i < a.greys.size(); ++i) a.pictures[i].grey = &a.greys[i];
  for (std::size_t i = 0; i < b.greys.size(); ++i)
    if (b.faces[i].held_out) std::fill(b.greys[i].data.begin(), b.greys[i].data.end(), std::uint8_t(200));
  ASSERT_TRUE(refine(a));
  ASSERT_TRUE(refine(b));
  for (std::size_t i = 0; i < a.faces.size(); ++i)
    if (!a.faces[i].held_out) {
      EXPECT_EQ(a.faces[i].state.jaw, b.faces[i].state.jaw);
      EXPECT_EQ(a.faces[i].state.expression, b.faces[i].state.expression);
      EXPECT_EQ(a.faces[i].state.cam_from_head.matrix(), b.faces[i].state.cam_from_head.matrix());
    }
}

TEST(Photometric, StopsOnRequest) {
  JawClip clip = make_jaw_clip(6);
  std::stop_source source;
  source.request_stop();
  const auto result = refine(clip, source.get_token());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::cancelled);
}

// The skin as painted, and the mouth's inside as an open mouth of one level shows it.
Appearance known_appearance(double inside_level) {
  Appearance appearance;
  LitPoints lit;
  for (int p = 0; p < surface().points.points; ++p) {
    lit.albedo.push_back(static_cast<float>(painted(p)));
    lit.spread.push_back(8);
  }
  appearance.light = lit.light = side_light();
  appearance.level.fill(lit);
  std::array<double, Appearance::kTones> counts{};
  const FaceState open = state_of(0, 0.25, 0);
  count_cavity(surface(), face_picture(film(open, inside_level), kPhotoLens), open, &counts);
  for (double& c : counts) c *= 20;  // as if from many frames
  appearance.cavity_known = cavity_from_counts(counts, &appearance.cavity);
  return appearance;
}

double gap_of(const FaceState& state) { return lip_gap(test_reduced_head(), person(), state); }

TEST(PhotometricMouth, DarkPixelsBetweenTheLipsIndicateAnOpenMouth) {
  const FaceState open = state_of(0, 0.25, 0), closed = state_of(0, 0, 0);
  const Appearance appearance = known_appearance(12);
  ASSERT_TRUE(appearance.cavity_known);
  const FacePicture of_open = face_picture(film(open), kPhotoLens),
                    of_closed = face_picture(film(closed), kPhotoLens);
  const auto gain = [&](const FacePicture& picture, const FaceState& from, const FaceState& to) {
    return mouth_gain(surface(), appearance, picture, Mat3d::Identity(), from, to);
  };
  EXPECT_GT(gain(of_open, closed, open), 5);
  EXPECT_GT(gain(of_closed, open, closed), 5);
  EXPECT_NEAR(gain(of_open, closed, open), -gain(of_open, open, closed), 6);
}

TEST(PhotometricMouth, OpeningIsReadWhateverTheFitAndWhateverLiesInside) {
  for (double inside : {12.0, 215.0}) {  // a dark cavity; teeth and tongue in bright light
    const Appearance appearance = known_appearance(inside);
    ASSERT_TRUE(appearance.cavity_known);
    for (const auto& [yaw, exposure] : {std::pair(0.0, 1.0), std::pair(0.45, 0.85)})
      for (double jaw : {0.0, 0.1, 0.25}) {
        const FaceState truth = state_of(yaw, jaw, 0);
        Image8 grey = film(truth, inside);
        for (std::uint8_t& v : grey.data) v = static_cast<std::uint8_t>(exposure * v);
        const auto mouth =
            read_mouth(test_head(), test_reduced_head(), person(), surface(), appearance,
                       face_picture(grey, kPhotoLens), Mat3d::Identity(), state_of(yaw, 0.14, 0));
        ASSERT_TRUE(mouth);
        EXPECT_NEAR(mouth->lips.gap_m, gap_of(truth), std::max(0.002, 2 * mouth->lips.sigma_m))
            << inside << " " << yaw << " " << jaw;
        EXPECT_LT(mouth->lips.sigma_m, 0.003);
      }
  }
}

TEST(PhotometricMouth, UnknownTonesInsideGiveNoReading) {
  const FaceState state = state_of(0, 0.1, 0);
  EXPECT_FALSE(read_mouth(test_head(), test_reduced_head(), person(), surface(), Appearance(),
                          face_picture(film(state), kPhotoLens), Mat3d::Identity(), state));
}

TEST(PhotometricMouth, JawAloneOpensAndFullyShutsTheMouth) {
  FaceState face = state_of(0, 0.15, 0.3);
  for (int e = 0; e < test_head().expression_count(); ++e)
    if (test_head().expression_names[e].starts_with("mouthLowerDown")) face.expression[e] = 0.6;
  double last = -1;
  for (double jaw = 0; jaw < 0.4; jaw += 0.05) {
    const double gap = gap_of(with_jaw(test_head(), face, jaw));
    EXPECT_GT(gap, last) << jaw;
    last = gap;
  }
  EXPECT_NEAR(gap_of(with_jaw(test_head(), face, 0)), gap_of(state_of(0, 0, 0.3)), 1e-9);
  EXPECT_NEAR(gap_of(with_jaw(test_head(), face, face.jaw)), gap_of(face), 1e-12);
}

TEST(PhotometricMouth, LandmarkUncertaintyGrowsWithTheirError) {
  FaceObservation before;
  before.sigma_px.fill(1);
  const auto doubt = [&](double fitted) {
    FaceObservation after = before;
    observe_mouth({true, 0.005, 0.001}, fitted, &after);
    for (int k = 17; k < 48; ++k) EXPECT_EQ(after.sigma_px[k], 1) << k;
    return after.sigma_px[62];
  };
  EXPECT_EQ(doubt(0.005), 1);
  EXPECT_GT(doubt(0.008), doubt(0.006));
  EXPECT_GT(doubt(0.002), 1.5);
  EXPECT_LE(doubt(0.05), 10);
}

}  // namespace
}  // namespace likeness
