// The facial actions of the built-in head, under their usual names. A mouth action is a sum of pushes, some
// on the upper or the lower lip only; a lid action rebuilds the lid over the eyeball for another opening.
#include <cmath>
#include <numbers>

#include "core/base/rigid.h"
#include "core/head/builtin_fields.h"
#include "core/head/builtin_sculpt.h"

namespace likeness::builtin {
namespace {

enum class Lip { both, upper, lower };
struct Push {
  Bump bump;
  Lip lip = Lip::both;
};

// A symmetric field of pushes on skin. Lids stay on their eyeball; teeth, tongue and ears stay.
Field push_field(const WholeHead& head, const std::vector<Push>& pushes) {
  Field left(head.left_count, Vec3d::Zero());
  for (int i = 0; i < head.left_count; ++i) {
    const HalfVertex& v = head.vertices[i];
    if (v.tissue != Tissue::skin && v.tissue != Tissue::lip_inner) continue;
    const double lower = jaw_weight(v), free = 1 - smoothstep(0.35, 0.9, v.lid);
    for (const Push& push : pushes) {
      const double share = push.lip == Lip::both ? 1 : push.lip == Lip::lower ? lower : 1 - lower;
      left[i] += free * share * bump_at(push.bump, v.position);
    }
  }
  return mirrored(head, left);
}

// The jaw as a whole: lower teeth and tongue too.
Field jaw_field(const WholeHead& head, const Vec3d& push) {
  Field field(head.vertices.size());
  for (std::size_t i = 0; i < field.size(); ++i) field[i] = jaw_weight(head.vertices[i]) * push;
  return field;
}

// A sideways shift of the lips, following the curve of the dental arch.
Field mouth_shift_field(const WholeHead& head, double shift) {
  Field field(head.vertices.size(), Vec3d::Zero());
  for (std::size_t i = 0; i < field.size(); ++i) {
    const HalfVertex& v = head.vertices[i];
    if (v.tissue != Tissue::skin && v.tissue != Tissue::lip_inner) continue;
    const Vec3d q = (v.position - Vec3d(0, -35, 108)).cwiseQuotient(Vec3d(34, 18, 40));
    const double x = v.position.x(), weight = std::exp(-q.squaredNorm());
    field[i] = weight * Vec3d(shift, 0, -shift * x * 0.022);
  }
  return field;
}

// How far the jaw can be open with the lips still closed, rad: half of jawOpen.
constexpr double kClosableOpening = 12.5 * std::numbers::pi / 180;

// Closes the lips over a jaw open by this much: both are moved to where the opening's first third would have
// put them.
Field mouth_close_field(const WholeHead& head) {
  const Mat3d open = rotation_about(Vec3d::UnitX(), kClosableOpening);
  Field left(head.left_count, Vec3d::Zero());
  for (int i = 0; i < head.left_count; ++i) {
    const HalfVertex& v = head.vertices[i];
    if (v.tissue != Tissue::skin && v.tissue != Tissue::lip_inner) continue;
    const Vec3d& p = v.position;
    const Vec3d opened = open * (p - kJawJoint) + kJawJoint - p;
    const double w = jaw_weight(v);
    const double away =
        std::hypot(std::max(std::abs(p.x()) - 22, 0.0), (p.y() + 34.5) * (p.y() > -34.5 ? 1.6 : 1.0));
    const double near = smoothstep(24, 7, away) * smoothstep(84, 100, p.z());
    // The shape comes before the jaw's blended rotation m, which then carries it.
    const Mat3d m = (1 - w) * Mat3d::Identity() + w * open;
    left[i] = near * (m.inverse() * ((0.36 - w) * opened));
  }
  return mirrored(head, left);
}

Field sum(Field a, const Field& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

}  // namespace

std::vector<NamedField> expression_fields(const WholeHead& head) {
  std::vector<NamedField> list;
  const auto both_sides = [&](const std::string& name, const Field& symmetric) {
    list.push_back({name + "_L", one_side(head, symmetric, true)});
    list.push_back({name + "_R", one_side(head, symmetric, false)});
  };
  const auto pushes = [&](const std::vector<Push>& p) { return push_field(head, p); };
  const auto leaning = [](double lean) {
    EyeOpening opening = kEyeOpen;
    opening.lean = lean;
    return opening;
  };
  const auto lids = [&](double upper, double lower) { return lid_field(head, {upper, lower}); };

  // -- Brows and cheeks
  both_sides("browDown", pushes({{{{22, 55, 97}, {24, 11, 24}, {-1.6, -5.0, 0.4}}}}));
  both_sides("browInnerUp", pushes({{{{12, 58, 102}, {17, 14, 26}, {0, 6.0, 0}}}}));
  both_sides("browOuterUp", pushes({{{{43, 57, 86}, {19, 13, 26}, {0, 5.6, 0.3}}}}));
  both_sides("cheekPuff", pushes({{{{43, -30, 72}, {22, 22, 32}, {6.5, 0, 4.5}}},
                                  {{{16, -22, 110}, {14, 9, 20}, {0, 0, 2}}}}));
  both_sides("cheekSquint", sum(pushes({{{{36, 17, 86}, {20, 12, 24}, {0.3, 3.6, 1.6}}}}), lids(6.2, 3.2)));

  // -- Lids
  both_sides("eyeBlink", lids(kEyeClosed.upper, kEyeClosed.lower));
  both_sides("eyeLookDown", lids(2.6, 5.6));
  both_sides("eyeLookIn", lid_field(head, leaning(-0.6)));
  both_sides("eyeLookOut", lid_field(head, leaning(0.6)));
  both_sides("eyeLookUp", lids(7.9, 3.7));
  both_sides("eyeSquint", sum(pushes({{{{33, 22, 90}, {18, 8, 20}, {0, 2.2, 0.6}}}}), lids(4.3, 1.6)));
  both_sides("eyeWide", lids(8.6, 5.3));

  // -- Jaw (jawOpen is the joint's)
  list.push_back({"jawForward", jaw_field(head, {0, 0, 5})});
  list.push_back({"jawLeft", jaw_field(head, {6, 0, 0})});
  list.push_back({"jawRight", jaw_field(head, {-6, 0, 0})});

  // -- Mouth
  const Vec3d corner(25.5, -35, 103);
  list.push_back({"mouthClose", mouth_close_field(head)});
  both_sides("mouthDimple", pushes({{{corner, {12, 12, 20}, {3, 0.6, -3.8}}}}));
  both_sides("mouthFrown", pushes({{{corner, {15, 14, 24}, {0.8, -6.5, -1}}},
                                   {{{13, -46, 108}, {12, 10, 18}, {0, -1.5, 0}}}}));
  list.push_back({"mouthFunnel", pushes({{{corner, {13, 14, 22}, {-7, 0, 2.5}}},
                                         {{{0, -34, 114}, {22, 13, 22}, {0, 0, 5}}},
                                         {{{0, -27, 116}, {17, 8, 22}, {0, 3.2, 1}}, Lip::upper},
                                         {{{0, -41, 114}, {17, 9, 22}, {0, -3.6, 1}}, Lip::lower}})});
  list.push_back({"mouthLeft", mouth_shift_field(head, 7)});
  both_sides("mouthLowerDown", pushes({{{{11, -42, 111}, {13, 11, 20}, {0.5, -5.0, 0.3}}, Lip::lower}}));
  both_sides("mouthPress", pushes({{{{12, -26, 113}, {14, 6, 18}, {0, -1.6, -0.9}}, Lip::upper},
                                   {{{12, -43, 111}, {14, 6, 18}, {0, 1.8, -0.9}}, Lip::lower},
                                   {{corner, {9, 9, 16}, {0.8, 0, -1}}}}));
  list.push_back({"mouthPucker", pushes({{{corner, {14, 14, 24}, {-9.5, 0, 3.5}}},
                                         {{{0, -34, 114}, {20, 12, 22}, {0, 0, 6}}}})});
  list.push_back({"mouthRight", mouth_shift_field(head, -7)});
  list.push_back({"mouthRollLower", pushes({{{{0, -40, 114}, {21, 6, 16}, {0, 2.6, -5.0}}, Lip::lower}})});
  list.push_back({"mouthRollUpper", pushes({{{{0, -28, 116}, {21, 6, 16}, {0, -2.0, -4.5}}, Lip::upper}})});
  list.push_back({"mouthShrugLower", pushes({{{{0, -50, 110}, {24, 18, 24}, {0, 4.2, 1.8}}, Lip::lower},
                                             {{{0, -30, 115}, {22, 9, 22}, {0, 2.4, 1.2}}, Lip::upper}})});
  list.push_back({"mouthShrugUpper", pushes({{{{0, -27, 116}, {20, 9, 20}, {0, 3.4, 1.6}}, Lip::upper}})});
  both_sides("mouthSmile", pushes({{{corner, {19, 16, 28}, {7.5, 8.0, -6.0}}},
                                   {{{38, 0, 84}, {20, 16, 26}, {2.0, 4.0, 3.0}}}}));
  both_sides("mouthStretch", pushes({{{corner, {18, 13, 26}, {6.5, -2.2, -5.0}}}}));
  both_sides("mouthUpperUp", pushes({{{{11, -27, 114}, {13, 10, 20}, {0.3, 4.6, 0.3}}, Lip::upper}}));
  both_sides("noseSneer", pushes({{{{12, 4, 110}, {12, 14, 22}, {0.5, 3.4, 0.3}}},
                                  {{{12, -24, 113}, {12, 10, 20}, {0, 2.4, 0}}, Lip::upper}}));
  return list;
}

}  // namespace likeness::builtin
