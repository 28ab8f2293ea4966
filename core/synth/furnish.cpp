// The placement of the things in the room. The head is at the origin and looks along +z; the back wall is
// 1.75 m behind.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/synth/noise.h"
#include "core/synth/room.h"

namespace likeness {
namespace {

const Vec3f kSpines[] = {Vec3f(0.40f, 0.06f, 0.04f), Vec3f(0.04f, 0.10f, 0.24f), Vec3f(0.62f, 0.42f, 0.12f),
                         Vec3f(0.05f, 0.18f, 0.11f), Vec3f(0.70f, 0.66f, 0.55f), Vec3f(0.03f, 0.03f, 0.04f),
                         Vec3f(0.28f, 0.10f, 0.18f), Vec3f(0.12f, 0.28f, 0.36f), Vec3f(0.55f, 0.20f, 0.07f)};

// Of random numbers no two are drawn in one list of arguments: compilers differ in which comes first.
struct Builder {
  std::vector<RoomPatch> patches;
  RandomStream random;

  RoomPatch& add(const Vec3f& origin, const Vec3f& u, const Vec3f& v, RoomPaint paint, const Vec3f& colour,
                 const Vec3f& other = Vec3f::Zero()) {
    patches.push_back({origin, u, v, paint, colour, other, std::uint32_t(random.unit() * 1e6f) + 1, 0});
    return patches.back();
  }

  // A box with one face towards +z (front) painted apart from the others. Turned by `yaw` about its centre
  // line.
  void box(const Vec3f& low, const Vec3f& size, RoomPaint paint, const Vec3f& colour, RoomPaint front,
           const Vec3f& front_colour, const Vec3f& front_other, float yaw = 0) {
    const Eigen::AngleAxisf turn(yaw, Vec3f::UnitY());
    const Vec3f foot = low + Vec3f(0.5f * size.x(), 0, 0.5f * size.z());
    const Vec3f x = turn * Vec3f(size.x(), 0, 0), z = turn * Vec3f(0, 0, size.z()), y(0, size.y(), 0);
    const Vec3f o = foot - 0.5f * x - 0.5f * z;
    add(o + z, x, y, front, front_colour, front_other);
    add(o + x, -x, y, paint, colour, front_other);
    add(o, z, y, paint, colour, front_other);
    add(o + x + z, -z, y, paint, colour, front_other);
    add(o + y + z, x, -z, paint, colour, front_other);
    add(o, x, z, paint, colour, front_other);
  }
  Vec3f spine() { return kSpines[random.below(9)]; }
  void plain_box(const Vec3f& low, const Vec3f& size, RoomPaint paint, const Vec3f& colour, float yaw = 0) {
    box(low, size, paint, colour, paint, colour, Vec3f::Zero(), yaw);
  }
};

void shelf_of_books(Builder& b, float x, float end, float y, float z, float room_above) {
  while (x < end - 0.05f) {
    const float pick = b.random.unit();
    if (pick < 0.10f) {  // a gap with a small object
      const float w = b.random.between(0.07f, 0.11f);
      const float turn = b.random.between(-0.3f, 0.3f);
      const Vec3f colour = b.spine();
      const float height = b.random.between(0.08f, 0.15f);
      b.box({x + 0.01f, y, z - 0.14f}, {w - 0.02f, height, 0.08f}, RoomPaint::cover, colour,
            RoomPaint::poster, Vec3f::Ones(), Vec3f(0.75f, 0.72f, 0.66f), turn);
      x += w;
      continue;
    }
    const float width = b.random.between(0.018f, 0.05f);
    const float height = std::min(room_above - 0.02f, b.random.between(0.17f, 0.28f));
    const float depth = b.random.between(0.13f, 0.19f), inset = b.random.between(0.01f, 0.05f);
    const float brightness = b.random.between(0.7f, 1.2f);
    const Vec3f colour = b.spine() * brightness;
    const Vec3f letters = colour.maxCoeff() > 0.35f ? Vec3f(0.05f, 0.04f, 0.03f) : Vec3f(0.72f, 0.62f, 0.38f);
    b.box({x, y, z - inset - depth}, {width - 0.0015f, height, depth}, RoomPaint::cover, colour,
          RoomPaint::spine, colour, letters);
    x += width;
  }
}

void bookcase(Builder& b, float left, float right, float back, float floor, float top) {
  const Vec3f wood(0.30f, 0.17f, 0.08f);
  const float depth = 0.28f, board = 0.022f;
  const int shelves = 7;
  b.plain_box({left, floor, back}, {board, top - floor, depth}, RoomPaint::wood, wood);
  b.plain_box({right - board, floor, back}, {board, top - floor, depth}, RoomPaint::wood, wood);
  b.add({left, floor, back + 0.01f}, {right - left, 0, 0}, {0, top - floor, 0}, RoomPaint::wood, 0.7f * wood);
  for (int i = 0; i <= shelves; ++i) {
    const float step = (top - floor - board) / float(shelves), y = floor + step * float(i);
    b.plain_box({left, y, back}, {right - left, board, depth}, RoomPaint::wood, wood);
    if (i < shelves)
      shelf_of_books(b, left + board, right - board, y + board, back + depth - 0.01f, step - board);
  }
}

void plant(Builder& b, const Vec3f& pot, float height) {
  const Vec3f clay(0.45f, 0.17f, 0.09f);
  for (int i = 0; i < 12; ++i) {  // a round pot
    const float a = 2 * std::numbers::pi_v<float> * float(i) / 12, c = a + 2 * std::numbers::pi_v<float> / 12;
    const Vec3f p(0.11f * std::cos(a), 0, 0.11f * std::sin(a)),
        q(0.11f * std::cos(c), 0, 0.11f * std::sin(c));
    b.add(pot + q, p - q, {0, 0.22f, 0}, RoomPaint::cloth, clay, Vec3f(0.6f, 0.5f, 0.4f));
  }
  for (int i = 0; i < 46; ++i) {
    const float angle = b.random.between(0, 6.28f), lean = b.random.between(0.15f, 0.95f);
    const float length = b.random.between(0.22f, 0.42f), width = b.random.between(0.05f, 0.10f);
    const Vec3f out(std::cos(angle), 0, std::sin(angle));
    const Vec3f side = Vec3f(-std::sin(angle), 0, std::cos(angle));
    Vec3f root = pot + Vec3f(0, 0.2f + b.random.between(0, 0.5f) * height, 0) + 0.06f * out;
    Vec3f green;
    green.z() = b.random.between(0.02f, 0.05f);
    green.y() = b.random.between(0.09f, 0.17f);
    green.x() = b.random.between(0.03f, 0.08f);
    for (int piece = 0; piece < 3; ++piece) {  // bends outwards; both sides are seen
      const float bend = lean + 0.45f * float(piece);
      const Vec3f up = (std::cos(bend) * Vec3f::UnitY() + std::sin(bend) * out) * (length / 3);
      const float w = width * (piece == 1 ? 1.0f : 0.62f);
      b.add(root - 0.5f * w * side, w * side, up, RoomPaint::leaf, green, Vec3f(0.20f, 0.28f, 0.11f));
      b.add(root + 0.5f * w * side - 0.0005f * out, -w * side, up, RoomPaint::leaf, 0.8f * green,
            Vec3f(0.17f, 0.25f, 0.10f));
      root += up;
    }
  }
}

void picture(Builder& b, const Vec3f& low, float width, float height, RoomPaint paint,
             bool on_right_wall = false) {
  const Vec3f frame(0.08f, 0.05f, 0.03f), paper(0.78f, 0.75f, 0.68f);
  if (on_right_wall) {
    b.add(low, {0, 0, width}, {0, height, 0}, paint, Vec3f::Ones(),
          paint == RoomPaint::poster ? paper : frame);
    return;
  }
  b.box(low, {width, height, 0.025f}, RoomPaint::wood, frame, paint, Vec3f::Ones(),
        paint == RoomPaint::poster ? paper : frame);
}

void desk(Builder& b, float floor) {
  const Vec3f wood(0.42f, 0.27f, 0.14f);
  b.plain_box({0.42f, -0.36f, -1.45f}, {1.25f, 0.035f, 0.6f}, RoomPaint::wood, wood);
  for (const float x : {0.45f, 1.6f})
    b.plain_box({x, floor, -1.4f}, {0.05f, -0.36f - floor, 0.5f}, RoomPaint::wood, wood);
  const float y = -0.325f;
  for (int i = 0; i < 5; ++i) {  // a pile of magazines
    const float turn = b.random.between(-0.25f, 0.25f);
    const Vec3f sides = b.spine(), cover = b.spine();
    b.box({0.5f, y + 0.018f * float(i), -1.30f}, {0.27f, 0.017f, 0.2f}, RoomPaint::cover, cover,
          RoomPaint::spine, sides, Vec3f(0.7f, 0.65f, 0.5f), turn);
  }
  b.box({0.88f, y, -1.25f}, {0.10f, 0.11f, 0.10f}, RoomPaint::cloth, Vec3f(0.10f, 0.2f, 0.35f),
        RoomPaint::cloth, Vec3f(0.10f, 0.2f, 0.35f), Vec3f(0.75f, 0.7f, 0.6f), 0.5f);
  b.box({1.05f, y, -1.36f}, {0.22f, 0.30f, 0.03f}, RoomPaint::wood, Vec3f(0.2f, 0.12f, 0.06f),
        RoomPaint::landscape, Vec3f::Ones(), Vec3f(0.2f, 0.12f, 0.06f), -0.3f);
  b.box({1.33f, y, -1.2f}, {0.2f, 0.16f, 0.14f}, RoomPaint::wood, Vec3f(0.5f, 0.35f, 0.2f), RoomPaint::poster,
        Vec3f::Ones(), Vec3f(0.2f, 0.2f, 0.2f), 0.2f);
}

// Paper lanterns on strings and a tower of boxes between the person and the walls: without things at many
// depths the room is two planes, and structure from motion bends the path.
void hang_lanterns(Builder& b, float ceiling) {
  const RoomPaint paints[] = {RoomPaint::poster, RoomPaint::cloth, RoomPaint::poster, RoomPaint::landscape};
  for (int i = 0; i < 18; ++i) {
    const float share = (float(i) + 0.5f) / 18;
    const float x = -1.25f + 2.6f * share + b.random.between(-0.05f, 0.05f);
    const float z = -0.55f - 0.85f * hash_unit(std::uint32_t(i) * 3 + 1),
                y = 0.02f + 0.55f * hash_unit(std::uint32_t(i) * 7 + 2);
    const float size = b.random.between(0.09f, 0.15f), turn = b.random.between(-0.7f, 0.7f);
    const RoomPaint paint = paints[b.random.below(4)];
    const Vec3f colour = paint == RoomPaint::cloth ? b.spine() : Vec3f(Vec3f::Ones());
    b.box({x - 0.5f * size, y, z - 0.5f * size}, {size, size * b.random.between(1.0f, 1.5f), size}, paint,
          colour, paint, colour, Vec3f(0.75f, 0.70f, 0.60f), turn);
    b.plain_box({x - 0.0015f, y + size, z - 0.0015f}, {0.003f, ceiling - y - size, 0.003f}, RoomPaint::plain,
                Vec3f(0.2f, 0.18f, 0.15f));
  }
}

void stack_boxes(Builder& b, float x, float z, float floor, float top) {
  for (float y = floor; y < top;) {
    const float height = b.random.between(0.14f, 0.26f), width = b.random.between(0.26f, 0.40f);
    const RoomPaint paint = b.random.unit() < 0.6f ? RoomPaint::poster : RoomPaint::cloth;
    const Vec3f colour = paint == RoomPaint::poster ? Vec3f(Vec3f::Ones()) : b.spine();
    b.box({x - 0.5f * width, y, z - 0.5f * width}, {width, height, width}, paint, colour, paint, colour,
          Vec3f(0.7f, 0.62f, 0.5f), b.random.between(-0.4f, 0.4f));
    y += height;
  }
}

}  // namespace

std::vector<RoomPatch> furnish_room(std::uint32_t seed) {
  Builder b{{}, RandomStream{hash_u32(seed + 4242)}};
  const float left = -2.3f, right = 2.15f, back = kBackWall_m, front = 2.4f, floor = -1.15f, ceiling = 1.35f;
  const Vec3f wall(0.30f, 0.40f, 0.40f), brick(0.46f, 0.19f, 0.12f), mortar(0.45f, 0.42f, 0.38f);
  b.add({left, floor, back}, {right - left, 0, 0}, {0, ceiling - floor, 0}, RoomPaint::plaster, wall);
  b.add({left, floor, front}, {0, 0, back - front}, {0, ceiling - floor, 0}, RoomPaint::brick, brick, mortar);
  b.add({right, floor, back}, {0, 0, front - back}, {0, ceiling - floor, 0}, RoomPaint::plaster,
        Vec3f(0.55f, 0.50f, 0.42f));
  b.add({right, floor, front}, {left - right, 0, 0}, {0, ceiling - floor, 0}, RoomPaint::plaster,
        Vec3f(0.5f, 0.48f, 0.45f));
  b.add({left, floor, front}, {right - left, 0, 0}, {0, 0, back - front}, RoomPaint::floor,
        Vec3f(0.36f, 0.22f, 0.12f));
  b.add({left, ceiling, back}, {right - left, 0, 0}, {0, 0, front - back}, RoomPaint::plaster,
        Vec3f(0.7f, 0.7f, 0.68f));
  bookcase(b, -1.55f, -0.15f, back, floor, 1.05f);
  // The window on the right wall's back half, and a curtain.
  b.add({right - 0.02f, -0.3f, -1.25f}, {0, 0, 1.0f}, {0, 1.25f, 0}, RoomPaint::outdoors, Vec3f::Ones())
      .glow = 0.75f;
  b.plain_box({right - 0.06f, -0.34f, -1.29f}, {0.05f, 0.04f, 1.08f}, RoomPaint::wood,
              Vec3f(0.7f, 0.68f, 0.62f));
  b.plain_box({right - 0.06f, 0.93f, -1.29f}, {0.05f, 0.04f, 1.08f}, RoomPaint::wood,
              Vec3f(0.7f, 0.68f, 0.62f));
  for (const float z : {-1.29f, -0.78f, -0.25f}) {
    b.plain_box({right - 0.06f, -0.34f, z}, {0.05f, 1.3f, 0.04f}, RoomPaint::wood, Vec3f(0.7f, 0.68f, 0.62f));
  }
  for (int i = 0; i < 7; ++i) {
    const float z = -1.72f + 0.07f * float(i), fold = i % 2 == 0 ? 0.05f : 0.11f,
                next = i % 2 == 0 ? 0.11f : 0.05f;
    b.add({right - fold, floor + 0.1f, z}, {fold - next, 0, 0.07f}, {0, 2.2f, 0}, RoomPaint::cloth,
          Vec3f(0.50f, 0.22f, 0.10f), Vec3f(0.65f, 0.55f, 0.38f));
  }
  // Pictures on the back wall, right of the bookcase.
  picture(b, {0.02f, 0.22f, back}, 0.38f, 0.52f, RoomPaint::poster);
  picture(b, {0.50f, 0.30f, back}, 0.56f, 0.40f, RoomPaint::landscape);
  picture(b, {1.16f, 0.12f, back}, 0.40f, 0.56f, RoomPaint::poster);
  picture(b, {0.06f, -0.26f, back}, 0.30f, 0.36f, RoomPaint::landscape);
  picture(b, {0.46f, -0.12f, back}, 0.26f, 0.32f, RoomPaint::poster);
  picture(b, {0.80f, -0.14f, back}, 0.30f, 0.34f, RoomPaint::poster);
  picture(b, {0.52f, 0.80f, back}, 0.46f, 0.34f, RoomPaint::poster);
  picture(b, {1.62f, 0.30f, back}, 0.30f, 0.44f, RoomPaint::landscape);
  desk(b, floor);
  plant(b, {-0.62f, floor + 0.62f, -1.05f}, 0.42f);
  b.plain_box({-0.80f, floor, -1.23f}, {0.36f, 0.62f, 0.36f}, RoomPaint::wood, Vec3f(0.4f, 0.3f, 0.2f));
  plant(b, {1.72f, floor, -1.35f}, 0.9f);
  // Boxes along the brick wall and an armchair behind the person's right shoulder.
  b.box({-2.28f, floor, -0.9f}, {0.4f, 0.9f, 0.7f}, RoomPaint::wood, Vec3f(0.35f, 0.3f, 0.26f),
        RoomPaint::wood, Vec3f(0.35f, 0.3f, 0.26f), Vec3f::Zero());
  b.box({-2.2f, floor + 0.9f, -0.75f}, {0.25f, 0.3f, 0.3f}, RoomPaint::poster, Vec3f::Ones(),
        RoomPaint::poster, Vec3f::Ones(), Vec3f(0.8f, 0.75f, 0.6f), 0.3f);
  b.box({0.95f, floor, -0.95f}, {0.62f, 0.98f, 0.16f}, RoomPaint::cloth, Vec3f(0.34f, 0.30f, 0.10f),
        RoomPaint::cloth, Vec3f(0.34f, 0.30f, 0.10f), Vec3f(0.55f, 0.48f, 0.30f), -0.35f);
  hang_lanterns(b, ceiling);
  stack_boxes(b, -0.98f, -0.72f, floor, -0.02f);
  stack_boxes(b, 0.78f, -0.62f, floor, -0.12f);
  stack_boxes(b, 1.5f, -0.75f, floor, 0.10f);
  return std::move(b.patches);
}

std::vector<RoomPatch> bare_wall(bool plaster) {
  const float half_width = 12, half_height = 6;
  return {{Vec3f(-half_width, -half_height, kBackWall_m), Vec3f(2 * half_width, 0, 0),
           Vec3f(0, 2 * half_height, 0), plaster ? RoomPaint::plaster : RoomPaint::blank,
           Vec3f(0.52f, 0.50f, 0.47f), Vec3f::Zero(), 7, 0}};
}

}  // namespace likeness
