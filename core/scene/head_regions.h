// Which part of the picture a triangle of the head belongs to: as masks, region scores and contour searches
// need.
#pragma once

#include <cstdint>
#include <vector>

#include "core/head/head_model.h"

namespace likeness {

// One flag per triangle (F), 1 = belongs. From the parts if the model has them; geometry decides what parts
// cannot (where a face ends, where a neck begins), on the template with its landmarks.
struct HeadRegions {
  std::vector<std::uint8_t> face;  // inside the landmark outline and the forehead; lids, lips, eyeballs too
  std::vector<std::uint8_t> head;  // everything but neck and torso
  std::vector<std::uint8_t> mouth_interior;  // socket, gums, tongue, teeth
  std::vector<std::uint8_t> eyes;            // the eyeballs
  std::vector<std::uint8_t> skin;  // outer surface: neither mouth interior, eye sockets nor eyeballs
};
HeadRegions head_regions(const HeadModel& model);

// The vertices of the flagged triangles, ascending.
std::vector<int> region_vertices(const HeadModel& model, const std::vector<std::uint8_t>& triangles);
// The flagged triangles only; `source` receives their numbers in the model.
std::vector<Triangle> region_triangles(const HeadModel& model, const std::vector<std::uint8_t>& triangles,
                                       std::vector<int>* source = nullptr);

// Vertices of each vertex's neighbours, ascending: for walks along contours and smoothing.
std::vector<std::vector<int>> vertex_neighbours(int vertex_count, const std::vector<Triangle>& triangles);

}  // namespace likeness
