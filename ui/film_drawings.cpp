// Heads from the front, from the side and from above; phones, a window, arrows. See film_drawings.h.
#include "ui/film_drawings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "ui/theme.h"

namespace likeness::ui {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// A drawing's own coordinates: (0, 0) is the upper left corner of its square, (1, 1) the lower right.
struct Board {
  ImDrawList& list;
  ImVec2 at;
  float side;
  float thick;  // px, of the lines
  ImU32 ink, faint, accent, skin, hair;

  ImVec2 to(float x, float y) const { return {at.x + x * side, at.y + y * side}; }
};

Board board_at(ImDrawList& list, ImVec2 at, float side) {
  const Palette& p = theme().colours;
  return {list,
          at,
          side,
          std::max(1.5f, 0.022f * side),
          colour(p.text),
          colour(p.faint),
          colour(p.accent),
          colour(p.panel),
          colour(p.faint, 0.55f)};
}

void line(const Board& b, ImVec2 from, ImVec2 to, ImU32 ink) {
  b.list.AddLine(b.to(from.x, from.y), b.to(to.x, to.y), ink, b.thick);
}

// An arc of an ellipse, angles in radians, clockwise from the right. `fill` (0: none) is for a whole ellipse.
void ellipse(const Board& b, ImVec2 c, float rx, float ry, ImU32 ink, ImU32 fill = 0, float from = 0,
             float to = 2 * kPi) {
  constexpr int kParts = 40;
  std::array<ImVec2, kParts + 1> points;
  for (int i = 0; i <= kParts; ++i) {
    const float angle = from + (to - from) * float(i) / kParts;
    points[std::size_t(i)] = b.to(c.x + rx * std::cos(angle), c.y + ry * std::sin(angle));
  }
  if (fill) b.list.AddConvexPolyFilled(points.data(), kParts, fill);
  b.list.AddPolyline(points.data(), kParts + 1, ink, 0, b.thick);
}

// The part of an ellipse that the chord between two angles cuts off.
void segment(const Board& b, ImVec2 c, float rx, float ry, float from, float to, ImU32 fill) {
  constexpr int kParts = 24;
  std::array<ImVec2, kParts + 1> points;
  for (int i = 0; i <= kParts; ++i) {
    const float angle = from + (to - from) * float(i) / kParts;
    points[std::size_t(i)] = b.to(c.x + rx * std::cos(angle), c.y + ry * std::sin(angle));
  }
  b.list.AddConvexPolyFilled(points.data(), kParts + 1, fill);
}

void dot(const Board& b, ImVec2 c, float r, ImU32 ink) {
  b.list.AddCircleFilled(b.to(c.x, c.y), r * b.side, ink);
}

void dashes(const Board& b, ImVec2 from, ImVec2 to, ImU32 ink) {
  constexpr int kDashes = 5;
  const auto point = [&](float t) {
    return ImVec2{from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)};
  };
  for (int i = 0; i < kDashes; ++i)
    line(b, point((float(i) + 0.1f) / kDashes), point((float(i) + 0.7f) / kDashes), ink);
}

// The head of an arrow at a point, in the direction of an angle.
void arrow_head(const Board& b, ImVec2 tip, float angle, float size = 0.075f) {
  const auto corner = [&](float turn) {
    return b.to(tip.x - size * std::cos(angle + turn), tip.y - size * std::sin(angle + turn));
  };
  const float ahead = 0.5f * size;
  b.list.AddTriangleFilled(b.to(tip.x + ahead * std::cos(angle), tip.y + ahead * std::sin(angle)),
                           corner(0.6f), corner(-0.6f), b.accent);
}

// An arc with an arrow's head at its end.
void curved_arrow(const Board& b, ImVec2 c, float rx, float ry, float from, float to) {
  ellipse(b, c, rx, ry, b.accent, 0, from, to);
  const float turn = to > from ? 1.f : -1.f;
  arrow_head(b, {c.x + rx * std::cos(to), c.y + ry * std::sin(to)},
             std::atan2(turn * ry * std::cos(to), -turn * rx * std::sin(to)));
}

enum class Mouth { rest, smile, open, pursed };
struct Face {
  float yaw = 0, pitch = 0;  // -1..1: where the features move to, right and down
  Mouth mouth = Mouth::rest;
  bool brows_up = false, eyes_shut = false;
};

void draw_mouth(const Board& b, ImVec2 c, float r, Mouth mouth) {
  switch (mouth) {
    case Mouth::rest:
      ellipse(b, {c.x, c.y - 0.12f * r}, 0.36f * r, 0.16f * r, b.ink, 0, 0.15f * kPi, 0.85f * kPi);
      return;
    case Mouth::smile:
      ellipse(b, {c.x, c.y - 0.2f * r}, 0.46f * r, 0.36f * r, b.accent, 0, 0.12f * kPi, 0.88f * kPi);
      return;
    case Mouth::open:
      ellipse(b, {c.x, c.y + 0.05f * r}, 0.26f * r, 0.34f * r, b.accent, b.accent);
      return;
    case Mouth::pursed:
      ellipse(b, c, 0.13f * r, 0.13f * r, b.accent);
      return;
  }
}

void draw_face(const Board& b, ImVec2 c, float r, const Face& face) {
  const float x = c.x + 0.42f * r * face.yaw, y = c.y + 0.34f * r * face.pitch;
  const float apart = 0.4f * r * (1 - 0.25f * std::abs(face.yaw)), eyes = y - 0.16f * r;
  for (const float eye : {x - apart, x + apart}) {
    if (face.eyes_shut) {
      ellipse(b, {eye, eyes - 0.05f * r}, 0.17f * r, 0.12f * r, b.accent, 0, 0.1f * kPi, 0.9f * kPi);
    } else {
      dot(b, {eye, eyes}, 0.085f * r, b.ink);
    }
    const float brow = eyes - (face.brows_up ? 0.3f : 0.1f) * r;
    if (face.brows_up) ellipse(b, {eye, brow}, 0.2f * r, 0.12f * r, b.accent, 0, 1.15f * kPi, 1.85f * kPi);
  }
  const float nose = face.yaw < 0 ? -1.f : 1.f;  // the side its tip is drawn on
  line(b, {x + 0.04f * r * face.yaw, eyes + 0.1f * r}, {x + 0.1f * r * nose, eyes + 0.38f * r}, b.ink);
  line(b, {x + 0.1f * r * nose, eyes + 0.38f * r}, {x - 0.04f * r * nose, eyes + 0.4f * r}, b.ink);
  draw_mouth(b, {x, y + 0.58f * r}, r, face.mouth);
}

// From the front: r is half the head's width.
void draw_head(const Board& b, ImVec2 c, float r, const Face& face) {
  ellipse(b, c, r, 1.28f * r, b.skin, b.skin);
  // The hairline tips and turns with the head.
  const float low = 0.2f - 0.09f * face.pitch, tip = 0.05f * face.yaw;
  segment(b, c, r, 1.28f * r, (1 + low - tip) * kPi, (2 - low - tip) * kPi, b.hair);
  ellipse(b, c, r, 1.28f * r, b.ink);
  draw_face(b, c, r, face);
}

// Shoulders and neck below a head, cut at `floor`.
void draw_shoulders(const Board& b, ImVec2 c, float r, float floor) {
  const float neck = c.y + 1.05f * r, top = c.y + 1.75f * r;
  b.list.PathClear();
  b.list.PathLineTo(b.to(c.x - 2.1f * r, floor));
  b.list.PathBezierCubicCurveTo(b.to(c.x - 2.05f * r, top), b.to(c.x - 0.5f * r, top + 0.1f * r),
                                b.to(c.x - 0.42f * r, neck));
  b.list.PathLineTo(b.to(c.x + 0.42f * r, neck));
  b.list.PathBezierCubicCurveTo(b.to(c.x + 0.5f * r, top + 0.1f * r), b.to(c.x + 2.05f * r, top),
                                b.to(c.x + 2.1f * r, floor));
  b.list.PathStroke(b.ink, 0, b.thick);
}

void draw_bust(const Board& b, ImVec2 c, float r, float floor, const Face& face) {
  draw_shoulders(b, c, r, floor);
  draw_head(b, c, r, face);
}

// From the side, looking to the left.
void draw_profile(const Board& b, ImVec2 c, float r) {
  line(b, {c.x - 0.1f * r, c.y + 0.9f * r}, {c.x - 0.15f * r, c.y + 1.6f * r}, b.ink);
  ellipse(b, {c.x + 0.3f * r, c.y + 3.05f * r}, 1.3f * r, 1.5f * r, b.ink, 0, 1.02f * kPi, 1.75f * kPi);
  ellipse(b, c, r, 1.2f * r, b.skin, b.skin);
  segment(b, c, r, 1.2f * r, 1.3f * kPi, 2.2f * kPi, b.hair);
  ellipse(b, c, r, 1.2f * r, b.ink);
  line(b, {c.x - 0.98f * r, c.y - 0.06f * r}, {c.x - 1.24f * r, c.y + 0.3f * r}, b.ink);
  line(b, {c.x - 1.24f * r, c.y + 0.3f * r}, {c.x - 0.94f * r, c.y + 0.36f * r}, b.ink);
  line(b, {c.x - 0.78f * r, c.y + 0.66f * r}, {c.x - 0.5f * r, c.y + 0.62f * r}, b.ink);
  dot(b, {c.x - 0.55f * r, c.y - 0.16f * r}, 0.11f * r, b.ink);
}

void draw_phone(const Board& b, ImVec2 low, ImVec2 high, ImU32 ink, float rounding = 0.04f) {
  b.list.AddRectFilled(b.to(low.x, low.y), b.to(high.x, high.y), b.skin, rounding * b.side);
  b.list.AddRect(b.to(low.x, low.y), b.to(high.x, high.y), ink, rounding * b.side, 0, b.thick);
}

void draw_light(const Board& b) {
  // A window, and its light on the face.
  b.list.AddRect(b.to(0.06f, 0.2f), b.to(0.3f, 0.66f), b.accent, 0, 0, b.thick);
  line(b, {0.18f, 0.2f}, {0.18f, 0.66f}, b.accent);
  line(b, {0.06f, 0.43f}, {0.3f, 0.43f}, b.accent);
  for (const float y : {0.3f, 0.43f, 0.56f}) {
    line(b, {0.36f, y}, {0.48f, y}, b.accent);
    arrow_head(b, {0.48f, y}, 0, 0.05f);
  }
  draw_profile(b, {0.74f, 0.42f}, 0.155f);
}

void draw_portrait(const Board& b) {
  draw_phone(b, {0.22f, 0.05f}, {0.78f, 0.95f}, b.accent, 0.07f);
  b.list.PushClipRect(b.to(0.24f, 0.06f), b.to(0.76f, 0.93f), true);
  draw_bust(b, {0.5f, 0.42f}, 0.15f, 0.97f, {});
  b.list.PopClipRect();
}

void draw_camera_at_rest(const Board& b) {
  // A phone on a stand, at the height of the eyes.
  draw_phone(b, {0.12f, 0.2f}, {0.19f, 0.46f}, b.accent, 0.02f);
  line(b, {0.155f, 0.46f}, {0.155f, 0.68f}, b.faint);
  line(b, {0.155f, 0.68f}, {0.06f, 0.93f}, b.faint);
  line(b, {0.155f, 0.68f}, {0.25f, 0.93f}, b.faint);
  line(b, {0.02f, 0.93f}, {0.98f, 0.93f}, b.faint);
  dashes(b, {0.22f, 0.335f}, {0.53f, 0.335f}, b.accent);
  draw_profile(b, {0.74f, 0.36f}, 0.155f);
}

void draw_walk(const Board& b) {
  // From above: the head looks down the page, the phone goes half round it.
  const ImVec2 c{0.5f, 0.34f};
  ellipse(b, {c.x, c.y - 0.02f}, 0.27f, 0.1f, b.ink, b.skin);
  ellipse(b, c, 0.12f, 0.15f, b.ink, b.skin);
  segment(b, c, 0.12f, 0.15f, 0.95f * kPi, 2.05f * kPi, b.hair);
  b.list.AddTriangleFilled(b.to(c.x - 0.04f, c.y + 0.13f), b.to(c.x + 0.04f, c.y + 0.13f),
                           b.to(c.x, c.y + 0.2f), b.ink);
  curved_arrow(b, c, 0.42f, 0.48f, 0.93f * kPi, 0.1f * kPi);
  const ImVec2 phone{c.x, c.y + 0.48f};
  draw_phone(b, {phone.x - 0.09f, phone.y - 0.035f}, {phone.x + 0.09f, phone.y + 0.035f}, b.accent, 0.02f);
}

// A head that moves, with an arrow beside or below it.
void draw_turn(const Board& b, float yaw, float pitch) {
  const ImVec2 c{0.5f, 0.4f};
  draw_bust(b, c, 0.2f, 0.97f, {.yaw = yaw, .pitch = pitch});
  if (yaw != 0) {
    const float middle = 0.5f * kPi;
    curved_arrow(b, {c.x, c.y + 0.2f}, 0.42f, 0.17f, middle, middle + (yaw < 0 ? 0.44f : -0.44f) * kPi);
  } else {
    curved_arrow(b, {c.x + 0.22f, c.y}, 0.17f, 0.26f, 0, (pitch > 0 ? 0.4f : -0.4f) * kPi);
  }
}

void draw_speech(const Board& b) {
  draw_bust(b, {0.4f, 0.44f}, 0.18f, 0.97f, {.mouth = Mouth::open});
  for (const float r : {0.1f, 0.18f, 0.26f})
    ellipse(b, {0.56f, 0.54f}, r, r, b.accent, 0, -0.22f * kPi, 0.22f * kPi);
}

}  // namespace

void draw_film_drawing(ImDrawList& list, ImVec2 at, float side, FilmDrawing drawing) {
  const Board b = board_at(list, at, side);
  const auto close_up = [&](const Face& face) { draw_bust(b, {0.5f, 0.42f}, 0.225f, 0.97f, face); };
  list.PushClipRect(at, b.to(1, 1), true);
  switch (drawing) {
    case FilmDrawing::light:
      draw_light(b);
      break;
    case FilmDrawing::framing:
      draw_portrait(b);
      break;
    case FilmDrawing::camera_rests:
      draw_camera_at_rest(b);
      break;
    case FilmDrawing::camera_walks:
      draw_walk(b);
      break;
    case FilmDrawing::look_ahead:
      close_up({});
      break;
    case FilmDrawing::turn_left:
      draw_turn(b, -1, 0);
      break;
    case FilmDrawing::turn_right:
      draw_turn(b, 1, 0);
      break;
    case FilmDrawing::raise_chin:
      draw_turn(b, 0, -1);
      break;
    case FilmDrawing::lower_chin:
      draw_turn(b, 0, 1);
      break;
    case FilmDrawing::smile:
      close_up({.mouth = Mouth::smile});
      break;
    case FilmDrawing::open_mouth:
      close_up({.mouth = Mouth::open});
      break;
    case FilmDrawing::purse_lips:
      close_up({.mouth = Mouth::pursed});
      break;
    case FilmDrawing::raise_brows:
      close_up({.brows_up = true});
      break;
    case FilmDrawing::close_eyes:
      close_up({.eyes_shut = true});
      break;
    case FilmDrawing::speak:
      draw_speech(b);
      break;
  }
  list.PopClipRect();
}

void draw_framing(ImDrawList& list, ImVec2 at, ImVec2 size) {
  // A dark shadow makes the line visible on any picture.
  const ImVec2 c{at.x + 0.5f * size.x, at.y + 0.46f * size.y};
  const float ry = 0.3f * size.y, rx = ry / 1.28f;
  constexpr int kDashes = 28;
  for (const auto& [ink, thick] :
       {std::pair{IM_COL32(0, 0, 0, 110), px(4)}, {IM_COL32(255, 255, 255, 190), px(2)}})
    for (int i = 0; i < kDashes; ++i) {
      const auto point = [&](float t) {
        const float angle = 2 * kPi * t / kDashes;
        return ImVec2{c.x + rx * std::cos(angle), c.y + ry * std::sin(angle)};
      };
      list.AddLine(point(float(i)), point(float(i) + 0.5f), ink, thick);
    }
}

}  // namespace likeness::ui
