// A person's shape as delivered by other programs: identity coefficients of the head model, or the person's
// mesh in its topology. MICA (Zielonka et al., ECCV 2022) writes both for FLAME, from a single photograph and
// in metres.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/head/head_model.h"

namespace likeness {

// Reads
//   .npy   (I) or (1, I): identity coefficients, standard deviations; or (V, 3) or (1, V, 3): vertices, m
//   .npz   the same under the key identity or shape, or vertices; or the only array in the file
//   .obj   vertices, m, with the model's own faces if it has any
// Vertices are those of the face at rest in the model's own frame, in its order. They become the identity
// that explains them best, and the remainder becomes the person's offsets, so that both together reproduce
// the mesh.
//
// An Error says what was found and what is needed: wrong number of coefficients or vertices, values that are
// not finite, implausible coefficients, other faces, a unit other than the metre, another frame.
Result<PersonShape> read_person(const std::filesystem::path& path, const HeadModel& model);

}  // namespace likeness
