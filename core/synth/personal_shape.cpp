// Random fields over the rest head and their part outside the model's span.
#include "core/synth/personal_shape.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/dense_solves.h"
#include "core/head/builtin_head.h"
#include "core/synth/noise.h"

namespace likeness {
namespace {

using Landmarks3 = std::array<Vec3f, kLandmarkCount>;

float unit_normal(RandomStream& random) {
  return (random.unit() + random.unit() + random.unit() + random.unit() - 2) * 1.7f;
}

Vec3f noise3(const Vec3f& p, std::uint32_t seed) {
  return {noise(p, seed), noise(p, seed + 1), noise(p, seed + 2)};
}

// Smooth shape: half of it the same on both sides, half different; broad masses and, weaker, the forms
// between.
Vec3f smooth_shape(const Vec3f& p, std::uint32_t seed) {
  const Vec3f m(std::abs(p.x()), p.y(), 0.6f * p.z()), q(p.x(), p.y(), 0.6f * p.z());
  Vec3f even = noise3(m * 25.0f, seed) + 0.28f * noise3(m * 46.0f, seed + 10);
  even.x() *= std::tanh(p.x() / 0.015f);
  const Vec3f odd = 0.8f * noise3(q * 21.0f, seed + 20) + 0.18f * noise3(q * 42.0f, seed + 30);
  return (even + odd).cwiseProduct(Vec3f(0.85f, 0.85f, 1.0f));
}

// Distance in the frontal plane from a bent line, and how far along it, 0..1.
float line_distance(const Vec3f& p, const Vec3f& a, const Vec3f& b, float bend, float& along) {
  const Vec2f ab = (b - a).head<2>(), ap = (p - a).head<2>();
  along = ap.dot(ab) / ab.squaredNorm();
  const float t = std::clamp(along, 0.0f, 1.0f);
  const Vec2f side = Vec2f(ab.y(), -ab.x()).normalized();
  return (ap - t * ab - 4 * t * (1 - t) * bend * side).norm();
}

float groove(float distance, float width) { return std::exp(-distance * distance / (width * width)); }

// The fold from the wing of the nose past the corner of the mouth: a valley with a roll on its outer side.
float nasolabial(const Vec3f& p, const Landmarks3& l, bool left) {
  const float sign = left ? 1.0f : -1.0f;
  const Vec3f top = l[left ? 35 : 31] + Vec3f(sign * 0.005f, 0.003f, -0.004f);
  const Vec3f end = l[left ? 54 : 48] + Vec3f(sign * 0.010f, -0.007f, 0);
  float along = 0, roll_along = 0;
  const float valley = line_distance(p, top, end, sign * -0.003f, along);
  const Vec3f out(sign * 0.009f, 0.003f, 0);
  const float roll = line_distance(p, top + out, end + out, sign * -0.004f, roll_along);
  const float window = smoothstep(-0.25f, 0.15f, along) * (1 - smoothstep(0.85f, 1.25f, along)) *
                       smoothstep(0.045f, 0.065f, p.z());
  return window * (0.9f * groove(roll, 0.008f) - groove(valley, 0.0042f));
}

// Lines across the forehead.
float furrows(const Vec3f& p, const Landmarks3& l) {
  const float brow = 0.5f * (l[19].y() + l[24].y()), height = p.y() - brow - 0.10f * std::abs(p.x());
  const float window = smoothstep(0.006f, 0.018f, height) * (1 - smoothstep(0.038f, 0.055f, height)) *
                       (1 - smoothstep(0.030f, 0.050f, std::abs(p.x()))) * smoothstep(0.03f, 0.06f, p.z());
  return window * std::cos(6.2831853f * height / 0.0125f + 1.5f * noise(p * 30.0f, 71));
}

struct Eyes {
  std::array<Vec3f, 2> centres;  // left first
  // 1 on an eyeball and its lids, 0 away from it.
  float near(const Vec3f& p, int side) const {
    return 1 - smoothstep(0.0165f, 0.030f, (p - centres[std::size_t(side)]).norm());
  }
  float any(const Vec3f& p) const { return std::max(near(p, 0), near(p, 1)); }
};

bool inside_mouth(HeadPart part) { return part == HeadPart::teeth || part == HeadPart::gums_tongue; }

// The raw offsets of the whole head before anything is removed from them, m, of arbitrary size.
std::vector<Vec3f> raw_offsets(const HeadModel& model, const HeadShape& shape, const DemoPerson& person,
                               std::uint32_t seed) {
  const Landmarks3 l = landmark_positions(model, shape.vertices);
  const Eyes eyes{{shape.joints[kLeftEye], shape.joints[kRightEye]}};
  const float chin = l[8].y();
  const Vec3f mouth = 0.5f * (l[62] + l[66]);
  std::array<Vec3f, 2> at_eye;
  for (std::size_t side = 0; side < 2; ++side) {
    at_eye[side] = 0.6f * smooth_shape(eyes.centres[side] + Vec3f(0, 0, 0.012f), seed);
    at_eye[side].z() *= 0.5f;
  }
  const Vec3f at_mouth = smooth_shape(mouth, seed);
  std::vector<Vec3f> offsets(shape.vertices.size());
  for (std::size_t v = 0; v < offsets.size(); ++v) {
    const Vec3f& p = shape.vertices[v];
    Vec3f o = smooth_shape(p, seed);
    o.z() += person.skin.wrinkles *
             (0.55f * (nasolabial(p, l, true) + nasolabial(p, l, false)) + 0.22f * furrows(p, l));
    // Lips and what lies behind them shift together, or the teeth would come through.
    const float oral =
        inside_mouth(model.parts[v])
            ? 1.0f
            : (1 - smoothstep(0.012f, 0.030f, (p - mouth).cwiseProduct(Vec3f(0.6f, 1, 0.7f)).norm()));
    o = mix(o, at_mouth, oral);
    const int side = p.x() > 0 ? 0 : 1;
    o = mix(o, at_eye[std::size_t(side)],
            model.parts[v] == HeadPart::left_eyeball    ? 1.0f
            : model.parts[v] == HeadPart::right_eyeball ? 1.0f
                                                        : eyes.near(p, side));
    const float throat = smoothstep(chin - 0.050f, chin - 0.005f, p.y() + 0.4f * (p.z() - 0.08f));
    const float crown = 0.35f + 0.65f * smoothstep(-0.05f, 0.05f, p.z());
    offsets[v] = throat * crown * o;
  }
  return offsets;
}

// Columns that the fit of a person may use: identity, translation, rotation and size, over `chosen`.
Eigen::MatrixXd span_over(const HeadModel& model, const std::vector<int>& chosen) {
  const int identity = model.identity_count();
  Eigen::MatrixXd span(3 * int(chosen.size()), identity + 7);
  for (int i = 0; i < int(chosen.size()); ++i) {
    const int v = chosen[std::size_t(i)];
    const Vec3d p = model.vertices[std::size_t(v)].cast<double>();
    span.block(3 * i, 0, 3, identity) = model.identity_basis.middleRows(3 * v, 3).cast<double>();
    span.block<3, 3>(3 * i, identity).setIdentity();
    span.block<3, 1>(3 * i, identity + 3) = Vec3d::UnitX().cross(p);
    span.block<3, 1>(3 * i, identity + 4) = Vec3d::UnitY().cross(p);
    span.block<3, 1>(3 * i, identity + 5) = Vec3d::UnitZ().cross(p);
    span.block<3, 1>(3 * i, identity + 6) = p;
  }
  return span;
}

std::vector<int> face_vertices(const HeadModel& model) {
  std::vector<int> chosen;
  for (int v = 0; v < model.vertex_count(); ++v)
    if (model.parts[std::size_t(v)] == HeadPart::face) chosen.push_back(v);
  return chosen;
}

Eigen::VectorXd stacked(const std::vector<Vec3f>& field, const std::vector<int>& chosen) {
  Eigen::VectorXd flat(3 * int(chosen.size()));
  for (int i = 0; i < int(chosen.size()); ++i)
    flat.segment<3>(3 * i) = field[std::size_t(chosen[std::size_t(i)])].cast<double>();
  return flat;
}

double residual_rms(const HeadModel& model, const std::vector<Vec3f>& displacement) {
  const std::vector<int> chosen = face_vertices(model);
  const Eigen::MatrixXd span = span_over(model, chosen);
  const Eigen::VectorXd wanted = stacked(displacement, chosen);
  const Eigen::MatrixXd gram = span.transpose() * span;
  // The diagonal grows by so little that only directions without effect on the face are affected.
  const Eigen::MatrixXd damped =
      gram + 1e-9 * gram.trace() / double(gram.rows()) * Eigen::MatrixXd::Identity(gram.rows(), gram.cols());
  const Eigen::VectorXd fit = solve_symmetric(damped, span.transpose() * wanted);
  return std::sqrt((wanted - span * fit).squaredNorm() / double(chosen.size()));
}

float coefficient(const HeadModel& model, const Articulation& a, const char* name) {
  for (std::size_t i = 0; i < model.expression_names.size(); ++i)
    if (model.expression_names[i] == name) return a.expression[Eigen::Index(i)];
  return 0;
}

float both(const HeadModel& model, const Articulation& a, const std::string& name) {
  return 0.5f * (coefficient(model, a, (name + "_L").c_str()) + coefficient(model, a, (name + "_R").c_str()));
}

}  // namespace

PersonShape make_personal_shape(const HeadModel& model, const DemoPerson& person, int number, int seed) {
  PersonShape shape;
  shape.identity = Eigen::VectorXf::Zero(model.identity_count());
  RandomStream random{hash_u32(std::uint32_t(seed) + 2024 + 97 * std::uint32_t(number))};
  for (int i = 0; i < std::min(20, model.identity_count()); ++i)
    shape.identity[i] = person.scatter * unit_normal(random);
  const std::vector<std::string> names = builtin_identity_names();
  for (const auto& [name, amount] : person.identity) {
    const auto found = std::find(names.begin(), names.end(), name);
    LIKENESS_CHECK(found != names.end(), "no identity direction %s", name.c_str());
    const int index = int(found - names.begin());
    if (index < model.identity_count()) shape.identity[index] += amount;
  }
  const std::uint32_t pattern = hash_u32(std::uint32_t(seed) * 131 + std::uint32_t(number) * 17 + 5);
  shape.offsets = raw_offsets(model, shape_head(model, shape.identity), person, pattern);
  const double left = residual_rms(model, shape.offsets);
  for (Vec3f& o : shape.offsets) o *= float(kOffSpanRms / left);
  return shape;
}

double off_span_rms(const HeadModel& model, const std::vector<Vec3f>& vertices) {
  LIKENESS_CHECK(int(vertices.size()) == model.vertex_count(), "%d vertices, the model has %d",
                 int(vertices.size()), model.vertex_count());
  std::vector<Vec3f> displacement(vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) displacement[v] = vertices[v] - model.vertices[v];
  return residual_rms(model, displacement);
}

PersonalPlay::PersonalPlay(const HeadModel& model, const HeadShape& shape, const DemoPerson& person)
    : model_(model), shape_(shape) {
  const Landmarks3 l = landmark_positions(model, shape.vertices);
  const Eyes eyes{{shape.joints[kLeftEye], shape.joints[kRightEye]}};
  const float strong = std::abs(person.lopsided), sign = person.lopsided < 0 ? -1.0f : 1.0f;
  const Vec3f corner = l[sign > 0 ? 54 : 48], brow = l[sign > 0 ? 24 : 19], lower = l[57], chin = l[8];
  const auto bump = [](const Vec3f& p, const Vec3f& c, float across, float high) {
    const Vec3f d = p - c;
    return std::exp(-(d.x() * d.x() + 0.6f * d.z() * d.z()) / (across * across) -
                    d.y() * d.y() / (high * high));
  };
  const auto add = [&](const char* name, auto&& at) {
    PersonalAction action{name, std::vector<Vec3f>(shape.vertices.size(), Vec3f::Zero())};
    for (std::size_t v = 0; v < shape.vertices.size(); ++v) {
      const HeadPart part = model.parts[v];
      if (part != HeadPart::face && part != HeadPart::mouth_socket && part != HeadPart::scalp_neck) continue;
      const Vec3f& p = shape.vertices[v];
      const float deep = part == HeadPart::mouth_socket ? smoothstep(-0.016f, -0.004f, p.z() - l[62].z()) : 1;
      action.field[v] = deep * (1 - eyes.any(p)) * Vec3f(at(p));
    }
    actions_.push_back(std::move(action));
  };
  const float mm = 0.001f;
  add("crooked smile", [&](const Vec3f& p) -> Vec3f {
    // The corner is hitched up and pulled aside while the lip beside it is drawn flat.
    const Vec3f beside = corner + Vec3f(-sign * 0.014f, -0.002f, 0.006f),
                cheek = corner + Vec3f(sign * 0.013f, 0.016f, -0.010f);
    return strong * (bump(p, corner, 0.010f, 0.010f) * Vec3f(sign * 1.6f * mm, 3.0f * mm, 0) -
                     bump(p, beside, 0.010f, 0.012f) * Vec3f(0, 1.6f * mm, 0.5f * mm) +
                     bump(p, cheek, 0.012f, 0.012f) * Vec3f(0, 0, 1.8f * mm));
  });
  const float depth = 1.5f * mm * (1 + 0.5f * person.skin.wrinkles);
  add("fold beside the nose", [&](const Vec3f& p) -> Vec3f {
    const float fold = (sign > 0 ? 1.0f : 0.55f) * nasolabial(p, l, true) +
                       (sign > 0 ? 0.55f : 1.0f) * nasolabial(p, l, false);
    return Vec3f(0, 0, depth * fold);
  });
  add("one brow", [&](const Vec3f& p) -> Vec3f {
    const Vec3f middle = brow + Vec3f(sign * 0.004f, 0.002f, 0), inner = brow + Vec3f(-sign * 0.016f, 0, 0);
    return strong * (bump(p, middle, 0.011f, 0.011f) * Vec3f(0, 3.4f * mm, 0) -
                     bump(p, inner, 0.008f, 0.009f) * Vec3f(0, 1.4f * mm, 0)) +
           Vec3f(0, 0, (0.4f + 0.4f * person.skin.wrinkles) * mm * furrows(p, l));
  });
  add("skewed lip", [&](const Vec3f& p) -> Vec3f {
    const float under = 1 - smoothstep(-0.001f, 0.003f, p.y() - 0.5f * (l[62].y() + l[66].y()));
    return strong * under * bump(p, lower + Vec3f(sign * 0.006f, 0, 0), 0.011f, 0.009f) *
           Vec3f(sign * 2.2f * mm, -1.2f * mm, 0.6f * mm);
  });
  add("dimpled chin", [&](const Vec3f& p) -> Vec3f {
    const Vec3f pad = chin + Vec3f(0, 0.012f, 0);
    return bump(p, pad, 0.013f, 0.009f) * Vec3f(0, 0.8f * mm, 0.8f * mm * noise(p * 160.0f, 31) + 0.5f * mm);
  });
  // Out and a little forward, from the cheekbone to the jaw, with a dimple in its middle.
  add("puffed cheek", [&](const Vec3f& p) -> Vec3f {
    const Vec3f cheek = 0.5f * (l[48] + l[4]) + Vec3f(0, 0.012f, 0);
    const float round = bump(p, cheek, 0.018f, 0.017f), dimple = bump(p, cheek, 0.005f, 0.005f);
    return (round * 7.5f - dimple * 4.5f) * mm * Vec3f(-0.75f, 0, 0.66f);
  });
  habit_ = std::move(actions_.back().field);
  actions_.pop_back();
}

std::vector<float> PersonalPlay::strengths(const Articulation& a) const {
  const float smile = both(model_, a, "mouthSmile"), sneer = both(model_, a, "noseSneer"),
              lift = both(model_, a, "mouthUpperUp"), brows = both(model_, a, "browInnerUp"),
              frown = both(model_, a, "mouthFrown"), pucker = coefficient(model_, a, "mouthPucker");
  const float jaw = a.jaw.norm() / 0.44f;
  return {smile, std::min(1.3f, smile + 0.5f * sneer + 0.4f * lift), brows, std::min(1.0f, 1.4f * jaw),
          std::min(1.2f, pucker + frown)};
}

std::vector<Vec3f> PersonalPlay::pose(const Articulation& articulation, float habit) const {
  HeadShape played = shape_;
  for (std::size_t v = 0; v < played.vertices.size() && habit != 0; ++v)
    played.vertices[v] += habit * habit_[v];
  const std::vector<float> strong = strengths(articulation);
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    if (strong[i] == 0) continue;
    for (std::size_t v = 0; v < played.vertices.size(); ++v)
      played.vertices[v] += strong[i] * actions_[i].field[v];
  }
  return pose_head(model_, played, articulation);
}

}  // namespace likeness
