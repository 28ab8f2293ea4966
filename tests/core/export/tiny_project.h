// A project whose avatar is made in code, on the built-in head: enough to pose, film and export it.
#pragma once

#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "core/base/rigid.h"
#include "core/export/write_film.h"
#include "core/head/builtin_head.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness::test {

inline const HeadModel& tiny_head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

// Looks at a camera at rest, 0.8 m away. Was seen opening its jaw by 0.5 and smiling a little on the left.
inline Avatar filmed_avatar() {
  const HeadModel& model = tiny_head();
  const Eigen::Index numbers = model.expression_count() + 9;
  Avatar a = tiny_avatar();
  a.head_model_name = model.name, a.head_model_hash = model.hash;
  a.person.identity = Eigen::VectorXf::Zero(model.identity_count());
  a.person.offsets.clear();
  a.neutral = neutral_articulation(model);
  a.condition.mean = Eigen::VectorXf::Zero(numbers);
  a.condition.rows = Eigen::MatrixXf::Constant(2, numbers, 0.1f);
  a.seen.clear();
  for (const NamedAction& action : model.actions) a.seen.push_back({action.name, 0, 0});
  for (ActionRange& range : a.seen) {
    if (range.name == "jawOpen") range.high = 0.5f;
    if (range.name == "mouthSmile_L") range.high = 0.25f;
  }
  a.world_from_head = Pose::Identity();
  a.world_from_head.translate(Vec3d(0, 0, 0.8)).rotate(rotation_about(Vec3d::UnitX(), std::numbers::pi));
  a.world_from_torso = a.world_from_head;
  a.intrinsics = {96, 64, 120, 120, 48, 32, 0, 0, 0, 0};
  a.plate = Image8(96, 64, 3, 77);
  return a;
}

inline OpenedAvatar tiny_opened() {
  return {Project{"someone.likeness", {}, {}}, filmed_avatar(), tiny_head(), "0123abcd"};
}

inline Film resting_film(const Avatar& avatar, std::size_t frames = 1) {
  return listed_film(std::vector(frames, typical_camera(avatar)),
                     std::vector(frames, typical_state(avatar).pose));
}

// A folder of its own, removed at the end, with the avatar as a project in it.
class TinyProject {
 public:
  TinyProject() {
    std::string name = (std::filesystem::temp_directory_path() / "likeness_film_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    root = name;
    const auto project = open_or_create_project(folder(), {});
    if (!project || !save_project(*project).ok() ||
        !write_avatar(folder() / "avatar.bin", filmed_avatar()).ok())
      std::abort();
  }
  ~TinyProject() { std::filesystem::remove_all(root); }
  std::filesystem::path folder() const { return root / "someone.likeness"; }

  std::filesystem::path root;
};

}  // namespace likeness::test
