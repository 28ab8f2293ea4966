// What makes one built-in head differ from another: about forty directions with a meaning, each about one
// standard deviation of adults.
#include <cmath>
#include <functional>

#include "core/head/builtin_fields.h"
#include "core/head/builtin_head.h"
#include "core/head/builtin_sculpt.h"

namespace likeness::builtin {
namespace {

// A direction as a function of place. `deep` ones also move teeth and tongue.
struct Direction {
  const char* name;
  bool deep;
  std::function<Vec3d(const Vec3d&)> at;
};

std::function<Vec3d(const Vec3d&)> bumps(std::vector<Bump> list) {
  return [list = std::move(list)](const Vec3d& p) {
    Vec3d sum = Vec3d::Zero();
    for (const Bump& bump : list) sum += bump_at(bump, p);
    return sum;
  };
}

std::vector<Direction> directions() {
  std::vector<Direction> list;
  const auto add = [&](const char* name, bool deep, std::function<Vec3d(const Vec3d&)> at) {
    list.push_back({name, deep, std::move(at)});
  };
  // -- The whole head
  add("size", true, [](const Vec3d& p) -> Vec3d { return 0.03 * (p - Vec3d(0, 30, 50)); });
  add("width", true, [](const Vec3d& p) { return Vec3d(0.028 * p.x(), 0, 0); });
  add("height", true, [](const Vec3d& p) { return Vec3d(0, 0.025 * (p.y() - 30), 0); });
  add("depth", true, [](const Vec3d& p) { return Vec3d(0, 0, 0.035 * (p.z() - 70)); });
  add("skull_back", false, [](const Vec3d& p) {
    return Vec3d(0, 0, -5 * smoothstep(50, -80, p.z()) * smoothstep(-70, 0, p.y()));
  });
  add("skull_width", false,
      [](const Vec3d& p) { return Vec3d(0.05 * p.x() * smoothstep(10, 70, p.y()), 0, 0); });
  add("lower_face_length", true, [](const Vec3d& p) {
    return Vec3d(
        0, -3.2 * smoothstep(28, -14, p.y()) * smoothstep(-30, 40, p.z()) * smoothstep(-150, -85, p.y()), 0);
  });
  add("face_flatness", true, [](const Vec3d& p) {
    return Vec3d(0, 0, 3.0 * (std::exp(-p.x() * p.x() / 1000) - 0.4) * smoothstep(20, 90, p.z()));
  });
  add("face_pitch", true, [](const Vec3d& p) {
    return Vec3d(0, 0, 2.6 * std::clamp((p.y() - 10) / 70, -1.3, 1.3) * smoothstep(20, 90, p.z()));
  });
  add("temple_width", false, bumps({{{66, 42, 40}, {26, 34, 40}, {2.4, 0, 0}}}));
  // -- Jaw, chin, cheeks
  add("jaw_width", false, [](const Vec3d& p) {
    const double low = smoothstep(0, -45, p.y()) * smoothstep(-120, -75, p.y()) * smoothstep(-30, 10, p.z());
    return Vec3d(3.6 * low * p.x() / (12 + std::abs(p.x())), 0, 0);
  });
  add("chin_length", false, [](const Vec3d& p) {
    return Vec3d(
        0, -4.4 * smoothstep(-42, -74, p.y()) * smoothstep(-130, -85, p.y()) * smoothstep(20, 80, p.z()), 0);
  });
  add("chin_protrusion", false, bumps({{{0, -66, 104}, {30, 20, 34}, {0, 0, 3.6}}}));
  add("chin_width", false, bumps({{{20, -66, 98}, {16, 18, 24}, {2.8, 0, 0.5}}}));
  add("cheekbones", false, bumps({{{52, 12, 66}, {20, 17, 26}, {2.6, 0, 1.8}}}));
  add("cheek_fullness", false, bumps({{{46, -26, 68}, {22, 26, 30}, {3.2, 0, 2.6}}}));
  add("jowls", false,
      bumps({{{42, -58, 62}, {22, 20, 34}, {2.0, -2.6, 0.5}}, {{0, -88, 66}, {36, 18, 34}, {0, -4, 1}}}));
  // -- Nose
  add("nose_length", false, bumps({{{0, -5, 118}, {20, 15, 26}, {0, -2.6, 0.3}}}));
  add("nose_width", false, bumps({{{12, -5, 109}, {10, 11, 14}, {1.9, 0, 0}}}));
  add("nose_protrusion", false, bumps({{{0, 2, 126}, {17, 17, 20}, {0, 0, 3.2}}}));
  add("nose_bridge", false, bumps({{{0, 27, 110}, {11, 17, 18}, {0, 0, 2.2}}}));
  add("nose_tip_up", false, bumps({{{0, -1, 126}, {13, 12, 14}, {0, 2.4, 0.8}}}));
  // -- Mouth
  add("lip_thickness", false,
      bumps({{{0, -25, 114}, {20, 5.5, 22}, {0, 1.5, 0.7}}, {{0, -43, 112}, {19, 6, 22}, {0, -1.7, 0.7}}}));
  add("mouth_width", false, bumps({{{25, -35, 101}, {13, 13, 20}, {2.7, 0, -1.2}}}));
  add("mouth_height", false, bumps({{{0, -34, 106}, {36, 19, 40}, {0, 2.3, 0}}}));
  add("mouth_protrusion", false, bumps({{{0, -34, 112}, {32, 19, 34}, {0, 0, 2.6}}}));
  // -- Eyes and brows
  add("eye_distance", false, bumps({{{32, 35, 88}, {20, 18, 30}, {1.7, 0, -0.3}}}));
  add("eye_height", false, bumps({{{32, 35, 88}, {26, 17, 30}, {0, 1.7, 0}}}));
  add("eye_depth", false, bumps({{{31, 35, 90}, {22, 15, 26}, {0, 0, -2.0}}}));
  add("brow_height", false, bumps({{{30, 57, 94}, {28, 10, 26}, {0, 2.6, 0}}}));
  add("brow_tilt", false,
      bumps({{{48, 56, 88}, {15, 10, 26}, {0, 2.3, 0}}, {{14, 57, 104}, {13, 10, 22}, {0, -1.6, 0}}}));
  add("brow_ridge", false, bumps({{{24, 54, 98}, {26, 10, 20}, {0, 0, 2.2}}}));
  add("forehead_slope", false, bumps({{{0, 106, 80}, {60, 34, 50}, {0, 0, -4.2}}}));
  // -- Neck
  add("neck_width", false, [](const Vec3d& p) {
    const double window = smoothstep(-70, -105, p.y()) * smoothstep(-190, -150, p.y());
    return Vec3d(0.07 * window * p.x(), 0, 0.06 * window * (p.z() + 14));
  });
  return list;
}

}  // namespace

std::vector<NamedField> identity_fields(const WholeHead& head) {
  std::vector<NamedField> fields;
  const Vec3d ear_root(72, 13, 13);
  for (const Direction& direction : directions()) {
    Field left(head.left_count, Vec3d::Zero());
    const Vec3d eye = direction.at(kEyeCentre), ear = direction.at(ear_root);
    for (int i = 0; i < head.left_count; ++i) {
      const HalfVertex& v = head.vertices[i];
      switch (v.tissue) {
        case Tissue::eyeball:
          left[i] = eye;
          break;  // the ball stays a ball
        case Tissue::ear:
          left[i] = ear;
          break;
        case Tissue::upper_teeth:
        case Tissue::lower_teeth:
        case Tissue::tongue:
          if (direction.deep) left[i] = direction.at(v.position);
          break;
        default: {
          // Lids go with their eyeball.
          const double lock = smoothstep(0.25, 0.9, v.lid);
          left[i] = (1 - lock) * direction.at(v.position) + lock * eye;
        }
      }
    }
    fields.push_back({direction.name, mirrored(head, left)});
  }
  // The change of the lids per standard deviation, taken over two to either side: lids slide on a sphere, so
  // that a one-sided step would cut it on the other side.
  const auto lids = [&](const char* name, double upper, double lower, const Vec2d& inner,
                        const Vec2d& outer) {
    const auto opened = [&](double amount) {
      return lid_field(head, {kEyeOpen.upper + amount * upper, kEyeOpen.lower + amount * lower,
                              amount * inner, amount * outer});
    };
    Field field = opened(2);
    const Field other = opened(-2);
    for (std::size_t i = 0; i < field.size(); ++i) field[i] = 0.25 * (field[i] - other[i]);
    fields.push_back({name, field});
  };
  lids("eye_opening", 0.7, 0.4, Vec2d::Zero(), Vec2d::Zero());
  lids("eye_tilt", 0, 0, Vec2d(0, -0.5), Vec2d(0, 1.5));
  lids("eye_width", 0, 0, Vec2d(-0.5, 0), Vec2d(0.9, 0));
  Field ears(head.left_count, Vec3d::Zero());
  for (int i = 0; i < head.left_count; ++i)
    if (head.vertices[i].tissue == Tissue::ear) ears[i] = 0.09 * (head.vertices[i].position - ear_root);
  fields.push_back({"ear_size", mirrored(head, ears)});
  return fields;
}

}  // namespace likeness::builtin

namespace likeness {

std::vector<std::string> builtin_identity_names() {
  std::vector<std::string> names;
  for (const builtin::Direction& direction : builtin::directions()) names.push_back(direction.name);
  for (const char* name : {"eye_opening", "eye_tilt", "eye_width", "ear_size"}) names.push_back(name);
  return names;
}

}  // namespace likeness
