// FLAME's own model files: Li, Bolkart, Black, Li, Romero, "Learning a model of facial shape and expression
// from 4D scans", SIGGRAPH Asia 2017; https://flame.is.tue.mpg.de. generic_model.pkl, female_model.pkl,
// male_model.pkl, flame2023.pkl, flame2023_no_jaw.pkl: Python 2 pickles of a dict with v_template (5023,3),
// shapedirs (5023,3,400: 300 identity, 100 expression), posedirs (5023,3,36), J_regressor (5,5023 sparse),
// weights (5023,5), kintree_table (2,5), f (9976,3), some of them wrapped in chumpy objects.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "core/base/npz.h"
#include "core/base/result.h"

namespace likeness {

// The model's arrays under their FLAME keys; shapes are checked later, by the loader of head models. Other
// models of the family (SMPL, SMPL-X, MANO) are refused by name.
Result<NpzArchive> read_flame_pickle(std::span<const std::byte> file, const std::string& where);

// The relative of FLAME with this many vertices and joints: "SMPL, a body model"; nullptr if there is none.
const char* flame_relative(std::size_t vertices, std::size_t joints);

// Arrays of Python objects (NpyArray kind O) in an .npz that hold one numeric array each, unpacked.
Result<void> unpack_objects(NpzArchive& archive, const std::string& where);

// "FLAME 2020" by the names of file and folder; "FLAME" if they do not say.
std::string flame_name(const std::filesystem::path& path);

}  // namespace likeness
