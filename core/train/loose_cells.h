// Pieces that hang in the air beside the person: density that no picture denied, as it lies where none looks
// past the head, or that only some expressions show.
#pragma once

#include <cstddef>

#include "core/render/avatar.h"

namespace likeness {

// FieldPart::opacity from which a cell is solid. Clothes, seen from one side, are learnt as a thick haze.
inline constexpr int kSolidHead = 40, kSolidTorso = 15;

// Empties the occupied cells that are no part of the largest solid piece, or of one a tenth as large, nor
// close to it, and returns how many they were. Glasses, hair and collars touch the rest. Nothing is done
// where opacities are not known, nor while most of what there is is haze: a young field.
std::size_t drop_loose_cells(FieldPart& part, int solid_from);

}  // namespace likeness
