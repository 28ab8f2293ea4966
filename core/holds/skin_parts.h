// Parts of a face's skin whose colours are compared between pictures, and where the posed head is in one.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/camera/camera.h"
#include "core/head/pose_head.h"
#include "core/image/image.h"
#include "core/scene/mesh_scene.h"

namespace likeness {

enum class SkinPart : std::uint8_t { none, forehead, nose, left_cheek, right_cheek, chin };
inline constexpr int kSkinParts = 6;

// What does not change with a pose. All flags are of the model's triangles (F).
struct SkinMap {
  std::vector<SkinPart> part;          // of skin that is neither lips nor lids; the rest is `none`
  std::vector<std::uint8_t> skin;      // of the face, lips and lids with it
  std::vector<std::uint8_t> head;      // everything but neck and bust
  std::vector<std::uint8_t> eyes;      // the eyeballs
  std::vector<std::uint8_t> mouth;     // what is behind the lips
  std::vector<std::uint8_t> lips;      // about the opening
  std::vector<std::uint8_t> drawn;     // all but the bust
  std::vector<Triangle> triangles;     // those drawn
  std::vector<std::int32_t> of_drawn;  // their numbers in the model
  std::vector<int> forehead_vertices;  // above the brows
};
// resting: the person's vertices at rest, head frame, m.
SkinMap make_skin_map(const HeadModel& model, const std::vector<Vec3f>& resting);

// The posed head in a picture, without a bust.
struct HeadInPicture {
  const SkinMap* map = nullptr;
  std::vector<Vec3f> posed, normals;  // (V) head frame
  Intrinsics intrinsics;
  Pose cam_from_head = Pose::Identity();
  Raster raster;  // of map->triangles

  // The model's triangle at a pixel; -1: none.
  int triangle(std::size_t pixel) const {
    const int t = raster.triangle[pixel];
    return t < 0 ? -1 : map->of_drawn[std::size_t(t)];
  }
  // Cosine between the surface's normal and the way to the eye; below zero it faces away.
  double facing(const Vec3f& point, const Vec3f& normal) const;
};
HeadInPicture head_in_picture(const HeadModel& model, const SkinMap& map, std::vector<Vec3f> posed,
                              const Intrinsics& intrinsics, const Pose& cam_from_head);

// 255 where a flagged triangle is seen. One channel.
Image8 seen_mask(const HeadInPicture& head, const std::vector<std::uint8_t>& triangles);

}  // namespace likeness
