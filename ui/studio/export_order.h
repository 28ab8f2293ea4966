// What is to be exported and how: chosen in the panel, fixed when it is asked for, carried out by the same
// functions as the command line's render and drive.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/direct/performance.h"
#include "core/render/picture_renderer.h"
#include "ui/studio/project_contents.h"

namespace likeness::ui {

enum class ExportKind { still, orbit, performance, driven, mesh };
inline constexpr std::array kExportKinds{ExportKind::still, ExportKind::orbit, ExportKind::performance,
                                         ExportKind::driven, ExportKind::mesh};

enum class ExportGround { room, light, dark, colour, picture, transparent };
enum class ExportForm { film, pictures };  // an mp4, or a folder of PNGs
enum class MeshForm { glb, ply };

struct ExportChoice {
  ExportKind kind = ExportKind::still;
  ExportForm form = ExportForm::film;
  MeshForm mesh = MeshForm::glb;
  ExportGround ground = ExportGround::light;
  std::array<float, 3> colour{0.2f, 0.35f, 0.5f};  // 0..1, of ExportGround::colour
  std::filesystem::path picture;                   // of ExportGround::picture
  int times = 1;                                   // as many px a side as the avatar was trained with
  double frames_per_second = 25;                   // a driven clip keeps its own
  bool mark = false;
  double half_angle_deg = 25, seconds = 4;  // of the orbit
  bool moving = false;                      // the mesh performs instead of standing still
  std::filesystem::path clip;               // that drives
  std::filesystem::path performance;        // empty: the project's own
  bool side_by_side = false, keep_head = false;
  bool operator==(const ExportChoice&) const = default;
};

inline constexpr int kMostTimes = 4;

// What the choice writes: pictures with a background and a size, or a mesh.
bool makes_pictures(const ExportChoice& choice);
// Whether the filmed room may stand behind the avatar: one that a moving camera taught always, the picture
// of a resting one only where it stood.
bool room_possible(const ExportChoice& choice, const ViewPoint& view, const Avatar& avatar);
// Where transparency is asked for, pictures; where the room cannot be, a light background.
ExportChoice settled(ExportChoice choice, const ViewPoint& view, const Avatar& avatar);

// Everything an export needs, fixed when it was asked for.
struct ExportOrder {
  ExportChoice choice;
  std::shared_ptr<const ProjectContents> contents;  // with an avatar
  std::shared_ptr<const Performance> performance;   // as directed when it was asked for
  double time_s = 0;  // of the moment that stills, orbits and resting meshes show
  std::filesystem::path out;
  OpenBackend open = {};  // where its pictures are rendered; the processor goes on where that fails
  std::map<std::string, float> gains = {};  // of named actions, as a live drive has them
};
// What is wrong with the choice before any work, if anything.
Result<void> check_order(const ExportOrder& order);
// What was written, in words.
Result<std::string> write_order(const ExportOrder& order, const Progress& progress, std::stop_token stop);

// still-001.png, orbit-001.mp4, orbit-001 (a folder), ...
std::string export_file_name(const ExportChoice& choice, int number);

}  // namespace likeness::ui
