// Head models from files. Nothing in a file is executed; every index and shape is checked.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/head/head_model.h"

namespace likeness {

// A .npz in the FLAME key schema (v_template, shapedirs, posedirs, J_regressor, weights, kintree_table, f,
// lmk_faces_idx, lmk_bary_coords, optional n_shape, n_expr, part_id, expression_names).
Result<HeadModel> load_head_model(const std::filesystem::path& path);

}  // namespace likeness
