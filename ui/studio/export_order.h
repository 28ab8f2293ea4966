// What is to be exported and how: chosen in the panel, fixed when it is asked for, carried out by the same
// functions as the command line's render and drive.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/direct/direct_avatar.h"
#include "core/direct/performance.h"
#include "core/image/image.h"
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
  ExportGround ground = ExportGround::room;        // as the Direct step shows it
  std::array<float, 3> colour{0.2f, 0.35f, 0.5f};  // 0..1, of ExportGround::colour
  std::filesystem::path picture;                   // of ExportGround::picture
  int times = 1;                                   // as many px a side as the avatar was trained with
  double frames_per_second = 25;                   // a driven clip keeps its own
  bool mark = false;
  std::optional<double> half_angle_deg{};  // of the orbit; nullopt: as far as orbit_of goes
  double seconds = 4;                      // of it
  bool moving = false;                     // the mesh performs instead of standing still
  std::filesystem::path clip;              // that drives
  std::filesystem::path performance;       // empty: the project's own
  bool side_by_side = false, keep_head = false;
  bool operator==(const ExportChoice&) const = default;
};

inline constexpr int kMostTimes = 4;

// What the choice writes: pictures with a background and a size, or a mesh.
bool makes_pictures(const ExportChoice& choice);
// What is directed, as far as a choice depends on it.
struct DirectedScene {
  ViewPoint view{};           // on screen
  bool camera_stands = true;  // where the clip's camera rested, all through the performance; it may zoom
};
DirectedScene directed_scene(const Performance& performance, const ViewPoint& view);
// Whether the filmed room may stand behind the avatar: one that a moving camera taught always, the picture
// of a resting one only where it stood.
bool room_possible(const ExportChoice& choice, const DirectedScene& scene, const Avatar& avatar);
// What is carried out of a choice: where transparency is asked for, pictures; where the room cannot be, a
// light background.
ExportChoice settled(ExportChoice choice, const DirectedScene& scene, const Avatar& avatar);
// The choice after `shown`, which was settled, became `asked` by the user's hand: what was only settled stays
// as it was wished.
ExportChoice with_wishes(const ExportChoice& wished, const ExportChoice& shown, ExportChoice asked);

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
// The first picture that the order would write, coarsely; of a driven clip, before anybody drives.
Result<Image8> first_picture(const ExportOrder& order);
// What was written, in words.
Result<std::string> write_order(const ExportOrder& order, const Progress& progress, std::stop_token stop);

// still-001.png, orbit-001.mp4, orbit-001 (a folder), ...
std::string export_file_name(const ExportChoice& choice, int number);

}  // namespace likeness::ui
