// Damaged head models: pickles, landmark embeddings, .npz and .npy, .obj, lists of names.
#include <gtest/gtest.h>
#include <zlib.h>

#include "core/base/npz.h"
#include "core/head/flame.h"
#include "core/head/flame_landmarks.h"
#include "core/head/ict_folder.h"
#include "core/head/load_head_model.h"
#include "core/head/pickle.h"
#include "core/head/pickle_arrays.h"
#include "tests/core/head/pickle_writer.h"
#include "tests/fuzz/fuzz.h"

namespace likeness {
namespace {

using namespace std::string_literals;

// A head of a few vertices: the structure is what is damaged, not the size.
HeadModel tiny_head() {
  HeadModel model;
  for (int v = 0; v < 6; ++v) model.vertices.emplace_back(0.05f * (v % 2), 0.04f * (v / 2), 0.03f * (v % 3));
  model.triangles = {{0, 1, 2}, {2, 3, 4}, {3, 4, 5}};
  model.identity_basis = Eigen::MatrixXf::Constant(18, 2, 0.001f);
  model.expression_basis = Eigen::MatrixXf::Constant(18, 2, 0.002f);
  model.pose_basis = Eigen::MatrixXf::Constant(18, kPoseFeatureCount, 0.001f);
  model.joint_regressor = Eigen::MatrixXf::Constant(kJointCount, 6, 1.0f / 6);
  model.skinning_weights = Eigen::MatrixXf::Constant(6, kJointCount, 0.2f);
  for (int l = 0; l < kLandmarkCount; ++l) model.landmark_barycentric[std::size_t(l)] = Vec3f::UnitX();
  model.parts.assign(6, HeadPart::face);
  return model;
}

// A zip of one entry, deflated: write_npz stores, numpy's savez_compressed deflates.
std::string deflated_zip(const std::string& name, const std::string& plain) {
  std::string packed(compressBound(uLong(plain.size())), '\0');
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
  stream.avail_in = uInt(plain.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = uInt(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  const auto number = [](std::uint64_t value, int bytes) {
    std::string text;
    for (; bytes > 0; --bytes, value >>= 8) text += char(value);
    return text;
  };
  const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(plain.data()), plain.size());
  const std::string shared = number(20, 2) + number(0, 2) + number(8, 2) + number(0, 4) + number(sum, 4) +
                             number(packed.size(), 4) + number(plain.size(), 4) + number(name.size(), 2) +
                             number(0, 2);
  const std::string local = "PK\3\4"s + shared + name + packed;
  const std::string directory = "PK\1\2"s + number(20, 2) + shared + number(0, 2 + 2 + 2 + 4 + 4) + name;
  return local + directory + "PK\5\6"s + number(0, 4) + number(1, 2) + number(1, 2) +
         number(directory.size(), 4) + number(local.size(), 4) + number(0, 2);
}

std::string npy(const std::string& header, const std::string& body) {
  return "\x93NUMPY\x01\x00"s + char(header.size()) + '\0' + header + body;
}

bool reads_every_array(std::span<const std::byte> bytes) {
  const auto document = read_pickle(bytes, "fuzz");
  if (!document) return false;
  bool all = true;
  int tried = 0;
  for (PickleRef ref = 0; ref < document->nodes.size() && tried < 200; ++ref) {
    if (document->node(ref).kind != PickleKind::object) continue;
    ++tried;
    all = pickle_array(*document, ref).ok() && all;
    static_cast<void>(pickle_elements(*document, ref));
  }
  return true;
}

std::string small_protocols(int which) {
  switch (which) {
    case 0:
      return "(dp0\nS'a\\n\\x41'\np1\nI01\nsVb\\u0041\nL-12345678901L\nsS\"c\"\n(lp2\nI5\naF1.5\nag2\nas.";
    case 1:
      return "\x80\x04\x95\x12\x00\x00\x00\x00\x00\x00\x00]\x94(\x8c\x02ok\x94h\x01K\x01K\x02\x86K\x03\x85h\x00"s +
             "0e.";
    default:
      return "\x80\x05\x8f(K\x01\x8a\x02\x00\xff\x90}(C\x01"
             "aG\x3f\xf8\x00\x00\x00\x00\x00\x00u\x86."s;
  }
}

TEST(FuzzHeadFiles, Pickle) {
  FuzzTarget target;
  target.name = "pickle";
  const HeadModel model = tiny_head();
  PickleWriter select;
  select.global("chumpy.reordering", "Select").raw(")\x81}(").text("a").chumpy(npy_from_doubles({2}, {1, 2}));
  select.text("idxs").array(npy_from_ints({2}, std::vector<std::int32_t>{1, 0}));
  select.text("preferred_shape").tuple({2, 1}).raw("ub");
  target.seeds = {flame_pickle(model), select.finish(), small_protocols(0), small_protocols(1),
                  small_protocols(2)};
  target.read = [](std::span<const std::byte> bytes) {
    const auto archive = read_flame_pickle(bytes, "fuzz.pkl");
    if (archive) static_cast<void>(head_model_from_archive(*archive, "/nowhere/fuzz.pkl"));
    return reads_every_array(bytes) || archive.ok();
  };
  fuzz(target);
}

TEST(FuzzHeadFiles, LandmarkEmbedding) {
  FuzzTarget target;
  target.name = "landmark embedding";
  const std::size_t rows = 3;
  const auto write = [&](PickleWriter& w) {
    w.raw("}(").text("static_lmk_faces_idx").array(npy_from_ints({51}, std::vector<std::int32_t>(51, 1)));
    w.text("static_lmk_bary_coords").array(npy_from_doubles({51, 3}, std::vector<float>(153, 1.0f / 3)));
    w.text("dynamic_lmk_faces_idx").array(npy_from_ints({rows, 17}, std::vector<std::int32_t>(17 * rows, 2)));
    w.text("dynamic_lmk_bary_coords")
        .array(npy_from_doubles({rows, 17, 3}, std::vector<float>(51 * rows, 1.0f / 3)));
    w.raw("u");
  };
  PickleWriter plain, wrapped;
  write(plain);
  wrapped.object_array([&] { write(wrapped); });
  const std::string header = "{'descr': '|O', 'fortran_order': False, 'shape': (), }     \n";
  target.seeds = {plain.finish(),
                  "\x93NUMPY\x01\x00"s + char(header.size()) + '\0' + header + wrapped.finish()};
  target.read = [](std::span<const std::byte> bytes) { return parse_landmark_embedding(bytes, "fuzz").ok(); };
  fuzz(target);
}

TEST(FuzzHeadFiles, Npz) {
  FuzzTarget target;
  target.name = "npz";
  const ScratchFolder scratch;
  NpzArchive archive = archive_of(tiny_head());
  archive["expression_names"] = text_array({"jawOpen", "b"});
  archive["fortran"] = npy_from_floats({2, 3}, std::vector<float>{1, 2, 3, 4, 5, 6});
  ASSERT_TRUE(write_npz(scratch.path() / "seed.npz", archive).ok());
  target.seeds = {
      scratch.get("seed.npz"),
      deflated_zip("v_template.npy", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (30, 3), }\n",
                                         std::string(200, 'a') + std::string(160, '\x3c')))};
  target.read = [](std::span<const std::byte> bytes) {
    auto read = parse_npz(bytes, "fuzz.npz");
    if (!read) return false;
    static_cast<void>(unpack_objects(*read, "fuzz.npz"));
    static_cast<void>(head_model_from_archive(*read, "/nowhere/fuzz.npz"));
    return true;
  };
  fuzz(target);
}

TEST(FuzzHeadFiles, Npy) {
  FuzzTarget target;
  target.name = "npy";
  target.seeds = {npy("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3), }\n", std::string(48, 'x')),
                  npy("{'descr': '<U3', 'fortran_order': False, 'shape': (2,), }\n", std::string(24, 'a')),
                  npy("{'descr': '|b1', 'fortran_order': False, 'shape': (), }\n", "\x01")};
  target.read = [](std::span<const std::byte> bytes) {
    const auto array = parse_npy(bytes, "fuzz.npy");
    if (!array) return false;
    static_cast<void>(array->as_float());
    static_cast<void>(array->as_int());
    static_cast<void>(array->as_strings());
    return true;
  };
  fuzz(target);
}

TEST(FuzzHeadFiles, Obj) {
  FuzzTarget target;
  target.name = "obj";
  target.seeds = {
      "mtllib a.mtl\no x\nv 4e-06 -7.64247 8.87459\nv 1 2 3 0.5 0.5\r\nv -1 0 +0\nvt 0.5 0.5\nvn 0 0 1\n"s +
          "v 1 1 1\ns off\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -1 -2 -3\nf 1//2 2//2 4//2\n",
      "v 0 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\n"};
  target.seeds[0].erase(target.seeds[0].find('+'), 1);
  target.read = [](std::span<const std::byte> bytes) {
    const auto mesh = parse_obj(bytes, "fuzz.obj");
    const bool positions = parse_obj(bytes, "fuzz.obj", false).ok();
    return mesh.ok() && positions;
  };
  fuzz(target);
}

TEST(FuzzHeadFiles, ExpressionNames) {
  FuzzTarget target;
  target.name = "expression names";
  const ScratchFolder scratch;
  const NpzArchive archive = archive_of(tiny_head());
  target.seeds = {"jawOpen\nmouthSmile_L\n", "jawOpen mouthSmile_L"};
  target.read = [&](std::span<const std::byte> bytes) {
    scratch.put("a_expression_names.txt", bytes);
    const auto model = head_model_from_archive(archive, scratch.path() / "fuzz.npz");
    return model.ok() && model->expression_names.size() == 2;
  };
  fuzz(target);
}

// The folder as a whole: its list of files and their agreement. Any mesh this small must be refused.
TEST(FuzzHeadFiles, IctFolder) {
  FuzzTarget target;
  target.name = "ICT folder";
  const ScratchFolder scratch;
  const std::string mesh = "v 0 0 0\nv 0 10 0\nv 10 0 0\nf 1 2 3\n";
  scratch.put("jawOpen.obj", std::as_bytes(std::span(mesh)));
  target.seeds = {mesh};
  target.read = [&](std::span<const std::byte> bytes) {
    scratch.put("generic_neutral_mesh.obj", bytes);
    EXPECT_FALSE(load_ict_folder(scratch.path()).ok());
    return true;
  };
  fuzz(target);
}

}  // namespace
}  // namespace likeness
