// Head models from files. Nothing in a file is executed; every index and shape is checked.
#pragma once

#include <filesystem>

#include "core/base/npz.h"
#include "core/base/result.h"
#include "core/head/head_model.h"

namespace likeness {

// - A .npz in the FLAME key schema (v_template, shapedirs, posedirs, J_regressor, weights, kintree_table, f,
//   lmk_faces_idx, lmk_bary_coords, optional n_shape, n_expr, part_id, expression_names);
// - FLAME's own .pkl or .npz, its landmark embedding beside it (flame.h, flame_landmarks.h);
// - the folder of ICT-FaceKit's .obj files (ict_folder.h).
// Where expressions have no names, the named actions are solved for (transfer_actions.h).
Result<HeadModel> load_head_model(const std::filesystem::path& path);

// The model of an archive in the schema above, its actions and hash included, `where` for messages. Without
// the lmk_* keys the landmarks are sought as for FLAME.
Result<HeadModel> head_model_from_archive(const NpzArchive& archive, const std::filesystem::path& where);

// Hash of everything load_head_model would read for a path: the file and its companions, or a folder's files.
Result<std::string> head_model_files_hash(const std::filesystem::path& path);

}  // namespace likeness
