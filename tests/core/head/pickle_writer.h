// Writes pickles as Python 2 does in protocol 2, with numpy's, scipy's and chumpy's records: as in FLAME's
// files.
#pragma once

#include <cstring>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/base/npz.h"
#include "core/head/head_model.h"
#include "tests/core/head/synthetic_head.h"

namespace likeness {

class PickleWriter {
 public:
  PickleWriter() : out_("\x80\x02") {}

  PickleWriter& raw(std::string_view code) {
    out_ += code;
    return *this;
  }
  PickleWriter& text(std::string_view value) {
    if (value.size() < 256)
      out_ += 'U', out_ += char(value.size());
    else
      out_ += 'T', little(std::uint32_t(value.size()));
    out_ += value;
    return *this;
  }
  PickleWriter& integer(std::int64_t value) {
    if (value >= 0 && value < 256) {
      out_ += 'K', out_ += char(value);
    } else if (value >= INT32_MIN && value <= INT32_MAX) {
      out_ += 'J', little(std::int32_t(value));
    } else {
      out_ += char(0x8a), out_ += char(8), little(value);
    }
    return *this;
  }
  PickleWriter& global(std::string_view module, std::string_view name) {
    out_ += 'c';
    out_ += module;
    out_ += '\n';
    out_ += name;
    out_ += '\n';
    return *this;
  }
  PickleWriter& tuple(const std::vector<std::size_t>& values) {
    out_ += '(';
    for (const std::size_t value : values) integer(std::int64_t(value));
    out_ += 't';
    return *this;
  }
  PickleWriter& dtype(const std::string& code, bool big_endian = false) {
    global("numpy", "dtype").text(code).integer(0).integer(1).raw("\x87R(").integer(3);
    return text(big_endian ? ">" : "<").raw("NNN").integer(-1).integer(-1).integer(0).raw("tb");
  }
  PickleWriter& array(const NpyArray& a, bool fortran = false, bool big_endian = false) {
    std::string code(1, a.kind);
    code += char(48 + a.item_bytes);
    return array(a.shape, code, {reinterpret_cast<const char*>(a.data.data()), a.data.size()}, fortran,
                 big_endian);
  }
  PickleWriter& array(const std::vector<std::size_t>& shape, const std::string& code, std::string_view data,
                      bool fortran = false, bool big_endian = false) {
    reconstruct().integer(1).tuple(shape).dtype(code, big_endian).raw(fortran ? "\x88" : "\x89");
    return text(data).raw("tb");
  }
  // A 0-d array of objects around what `write` writes.
  template <class Write>
  PickleWriter& object_array(Write write) {
    reconstruct().integer(1).raw(")").dtype("O8").raw("\x89](");
    write();
    return raw("etb");
  }
  PickleWriter& chumpy(const NpyArray& a) {
    global("chumpy.ch", "Ch").raw(")\x81}(").text("x").array(a);
    text("_dirty_vars").global("__builtin__", "set").raw("](").text("x").raw("e\x85R");
    return text("_itr").raw("N").text("_depends_on_deps").raw("}ub");
  }
  // A dense (rows, columns) array of f8 as scipy's compressed columns.
  PickleWriter& csc(const NpyArray& dense) {
    const std::size_t rows = dense.shape[0], columns = dense.shape[1];
    const std::vector<float> values = dense.as_float();
    std::vector<std::int32_t> starts{0}, indices;
    std::vector<double> data;
    for (std::size_t c = 0; c < columns; ++c) {
      for (std::size_t r = 0; r < rows; ++r)
        if (values[r * columns + c] != 0) indices.push_back(int(r)), data.push_back(values[r * columns + c]);
      starts.push_back(std::int32_t(indices.size()));
    }
    NpyArray numbers{{data.size()}, 'f', 8, {}};
    const auto bytes = std::as_bytes(std::span(data));
    numbers.data.assign(bytes.begin(), bytes.end());
    global("scipy.sparse.csc", "csc_matrix").raw(")\x81}(").text("_shape").tuple({rows, columns});
    text("format").text("csc").text("indptr").array(npy_from_ints({starts.size()}, starts));
    text("indices").array(npy_from_ints({indices.size()}, indices)).text("data").array(numbers);
    return text("maxprint").integer(50).raw("ub");
  }
  std::string finish() { return out_ + "."; }

 private:
  PickleWriter& reconstruct() {
    global("numpy.core.multiarray", "_reconstruct").global("numpy", "ndarray").integer(0).raw("\x85");
    return text("b").raw("\x87R(");
  }
  template <class T>
  void little(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof value);
    out_.append(bytes, sizeof bytes);
  }
  std::string out_;
};

inline NpyArray npy_from_doubles(std::vector<std::size_t> shape, const std::vector<float>& values) {
  NpyArray array{std::move(shape), 'f', 8, {}};
  array.data.resize(8 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = values[i];
    std::memcpy(array.data.data() + 8 * i, &value, 8);
  }
  return array;
}

inline NpyArray as_doubles(const NpyArray& a) { return npy_from_doubles(a.shape, a.as_float()); }
inline NpyArray as_unsigned(NpyArray a) {
  a.kind = 'u';
  return a;
}

// The model as FLAME's pickle: Python 2, chumpy and scipy objects, doubles, the shapes in Fortran order.
inline std::string flame_pickle(const HeadModel& model) {
  NpzArchive a = archive_of(model);
  PickleWriter w;
  w.raw("}(");
  w.text("f").array(as_unsigned(a["f"]));
  w.text("J_regressor").csc(a["J_regressor"]);
  w.text("kintree_table").array(as_unsigned(a["kintree_table"]));
  w.text("J").chumpy(npy_from_doubles({5, 3}, std::vector<float>(15)));
  w.text("weights").array(as_doubles(a["weights"]));
  w.text("bs_style").text("lbs");
  w.text("posedirs").array(as_doubles(a["posedirs"]));
  w.text("v_template").chumpy(as_doubles(a["v_template"]));
  w.text("shapedirs").chumpy(as_doubles(a["shapedirs"]));
  w.text("bs_type").text("lrotmin").raw("u");
  return w.finish();
}

// A head of FLAME's size: 5023 points on an ellipsoid, 9976 triangles between neighbours, 300 + 100
// directions.
inline HeadModel flame_sized_head() {
  HeadModel model;
  const int count = 5023;
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  for (int v = 0; v < count; ++v) {
    const float height = 1 - 2 * (float(v) + 0.5f) / count, around = 2.399963f * float(v);
    const float ring = std::sqrt(1 - height * height);
    model.vertices.emplace_back(0.08f * ring * std::sin(around), 0.12f * height,
                                0.1f * ring * std::cos(around));
  }
  for (int t = 0; t < 9976; ++t) model.triangles.emplace_back(t % count, (t + 8) % count, (t + 13) % count);
  const auto fill = [&](Eigen::MatrixXf& matrix, Eigen::Index rows, Eigen::Index columns, float scale) {
    matrix.resize(rows, columns);
    // One row of noise, shifted: six million draws would be the slowest part of the test.
    std::vector<float> noise(4099);
    for (float& value : noise) value = scale * normal(random);
    for (Eigen::Index i = 0; i < matrix.size(); ++i)
      matrix.data()[i] = noise[std::size_t(i * 7) % noise.size()];
  };
  fill(model.identity_basis, 3 * count, 300, 0.001f);
  fill(model.expression_basis, 3 * count, 100, 0.001f);
  fill(model.pose_basis, 3 * count, kPoseFeatureCount, 0.001f);
  fill(model.joint_regressor, kJointCount, count, 1);
  model.joint_regressor = model.joint_regressor.cwiseAbs();
  model.skinning_weights = Eigen::MatrixXf::Zero(count, kJointCount);
  for (int v = 0; v < count; ++v)
    model.skinning_weights(v, v % 7 == 0 ? kLeftEye : v % 5 == 0 ? kJaw : kNeck) = 1;
  for (int j = 0; j < kJointCount; ++j) model.joint_regressor.row(j) /= model.joint_regressor.row(j).sum();
  return model;
}

}  // namespace likeness
