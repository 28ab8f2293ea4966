// A head and shoulders of flat ellipses, which networks for real faces take for one: litert_outputs.py beside
// this draws the same.
#pragma once

#include <array>
#include <cstdlib>

#include "core/image/image.h"

namespace likeness {

struct DrawnEllipse {
  std::array<int, 2> half_axes, centre;  // hundredths of the side
  std::array<int, 3> colour;
};

// RGB, square. Only whole numbers: every compiler draws the same.
inline Image8 drawn_face(int side) {
  static constexpr DrawnEllipse kEllipses[] = {
      {{48, 40}, {50, 118}, {40, 60, 110}},                                        // shoulders
      {{13, 20}, {50, 78}, {196, 150, 126}},                                       // neck
      {{27, 36}, {50, 42}, {60, 44, 36}},                                          // hair
      {{23, 31}, {50, 47}, {214, 168, 142}},                                       // face
      {{6, 1}, {40, 37}, {70, 50, 40}},                                            // brows
      {{6, 1}, {60, 37}, {70, 50, 40}},      {{5, 2}, {40, 42}, {240, 238, 236}},  // eyes
      {{5, 2}, {60, 42}, {240, 238, 236}},   {{2, 2}, {40, 42}, {50, 40, 36}},
      {{2, 2}, {60, 42}, {50, 40, 36}},      {{3, 7}, {50, 50}, {200, 152, 128}},  // nose
      {{4, 1}, {50, 57}, {150, 104, 88}},    {{8, 2}, {50, 65}, {176, 84, 84}},    // mouth
  };
  Image8 picture(side, side, 3);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const long x = (2 * column + 1) * 50, y = (2 * row + 1) * 50;  // of the centre, times the side
      std::array<int, 3> colour{150, 170, 180};
      for (const DrawnEllipse& e : kEllipses) {
        const long u = (x - e.centre[0] * side) * e.half_axes[1],
                   v = (y - e.centre[1] * side) * e.half_axes[0];
        const long reach = long(e.half_axes[0]) * e.half_axes[1] * side;
        if (u * u + v * v <= reach * reach) colour = e.colour;
      }
      const int shade = int(std::labs(x - 50 * side) / (2 * side));  // darker to the sides
      for (std::size_t c = 0; c < 3; ++c) picture.at(column, row)[c] = std::uint8_t(colour[c] - shade);
    }
  return picture;
}

}  // namespace likeness
