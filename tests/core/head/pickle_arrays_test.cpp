// Claims about arrays in pickles: the numbers are recovered however they are wrapped, and false sizes are
// refused.
#include "core/head/pickle_arrays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/base/files.h"
#include "tests/core/head/bytes_of.h"
#include "tests/core/head/pickle_writer.h"

namespace likeness {
namespace {

using namespace std::string_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Result<NpyArray> read_array(const std::string& pickle) {
  const auto document = read_pickle(bytes_of(pickle), "x.pkl");
  if (!document) return document.error();
  return pickle_array(*document, document->root);
}
std::string array_fault(const std::string& pickle) {
  const auto array = read_array(pickle);
  return array ? "no fault found" : array.error().what;
}

const NpyArray kSix = npy_from_doubles({2, 3}, {0, 1, 2, 3, 4, 5});

TEST(PickleArray, ReadsBothOrdersAndBothEndians) {
  auto array = read_array(PickleWriter().array(kSix).finish());
  ASSERT_TRUE(array.ok()) << array.error().what;
  EXPECT_THAT(array->shape, ElementsAre(2u, 3u));
  EXPECT_THAT(array->as_float(), ElementsAre(0, 1, 2, 3, 4, 5));
  array = read_array(PickleWriter().array(kSix, true).finish());
  ASSERT_TRUE(array.ok());
  EXPECT_THAT(array->as_float(), ElementsAre(0, 2, 4, 1, 3, 5));
  array = read_array(PickleWriter().array({2}, "i2", "\x01\x02\xff\xfe"s, false, true).finish());
  ASSERT_TRUE(array.ok());
  EXPECT_THAT(array->as_int(), ElementsAre(258, -2));
}

TEST(PickleArray, ReadsBytesThatPythonThreeStoredAsText) {
  // bytes([0, 255, 65, 194]) in protocol 2: _codecs.encode(u'\0\u00ff A \u00c2', 'latin1').
  PickleWriter good;
  good.global("numpy._core.multiarray", "_reconstruct").global("numpy", "ndarray").integer(0).raw("\x85");
  good.text("b").raw("\x87R(").integer(1).tuple({4}).dtype("u1").raw("\x89");
  good.global("_codecs", "encode")
      .raw("X\x06\x00\x00\x00\x00\xc3\xbf"s + "A\xc3\x82")
      .raw("U\x06latin1")
      .raw("\x86Rtb");
  const auto read_back = read_array(good.finish());
  ASSERT_TRUE(read_back.ok()) << read_back.error().what;
  EXPECT_THAT(read_back->as_int(), ElementsAre(0, 255, 65, 194));
}

TEST(PickleArray, UnwrapsChumpyAndSparse) {
  auto array = read_array(PickleWriter().chumpy(kSix).finish());
  ASSERT_TRUE(array.ok()) << array.error().what;
  EXPECT_EQ(array->data, kSix.data);
  const NpyArray sparse = npy_from_doubles({2, 3}, {0, 7, 0, 0, 0, -2});
  array = read_array(PickleWriter().csc(sparse).finish());
  ASSERT_TRUE(array.ok()) << array.error().what;
  EXPECT_THAT(array->shape, ElementsAre(2u, 3u));
  EXPECT_THAT(array->as_float(), ElementsAre(0, 7, 0, 0, 0, -2));
}

TEST(PickleArray, SelectionsPickAndReshape) {
  PickleWriter w;
  w.global("chumpy.reordering", "Select").raw(")\x81}(").text("a").chumpy(kSix);
  w.text("idxs").array(npy_from_ints({4}, std::vector<std::int32_t>{5, 0, 0, 2}));
  w.text("preferred_shape").tuple({2, 2}).raw("ub");
  const auto array = read_array(w.finish());
  ASSERT_TRUE(array.ok()) << array.error().what;
  EXPECT_THAT(array->shape, ElementsAre(2u, 2u));
  EXPECT_THAT(array->as_float(), ElementsAre(5, 0, 0, 2));
}

TEST(PickleArray, NumbersAndListsOfNumbersAreArrays) {
  auto array = read_array("(lI1\naI2\naF0.5\na.");
  ASSERT_TRUE(array.ok());
  EXPECT_THAT(array->as_float(), ElementsAre(1, 2, 0.5f));
  array = read_array("I7\n.");
  ASSERT_TRUE(array.ok());
  EXPECT_TRUE(array->shape.empty());
  EXPECT_THAT(array->as_int(), ElementsAre(7));
}

TEST(PickleArray, RefusesDataOfTheWrongSize) {
  EXPECT_THAT(array_fault(PickleWriter().array({2, 4}, "f8", std::string(48, 'x')).finish()),
              HasSubstr("48 bytes"));
  EXPECT_THAT(
      array_fault(PickleWriter().array({std::size_t(1) << 40, std::size_t(1) << 40}, "f8", "").finish()),
      HasSubstr("its shape needs more"));
  EXPECT_THAT(array_fault(PickleWriter().array({6}, "O8", std::string(48, 'x')).finish()),
              HasSubstr("plain numbers"));
  EXPECT_THAT(array_fault("cos\nsystem\n(S'x'\ntR."), HasSubstr("an object of os system"));
  EXPECT_THAT(array_fault("S'x'\n."), HasSubstr("text"));
}

TEST(PickleArray, RefusesASparseMatrixThatClaimsAHugeSize) {
  std::string pickle = PickleWriter().csc(npy_from_doubles({2, 3}, {0, 7, 0, 0, 0, -2})).finish();
  const std::string small = "(K\x02K\x03t"s;
  pickle.replace(pickle.find(small), small.size(), "(J\xff\xff\xff\x7fJ\xff\xff\xff\x7ft"s);
  EXPECT_THAT(array_fault(pickle), HasSubstr("too large for its file"));
}

TEST(PickleArray, RefusesAChumpyObjectInsideItself) {
  const std::string pickle =
      "\x80\x02"
      "cchumpy.ch\nCh\n)\x81q\x00}U\x01xh\x00sb."s;
  EXPECT_THAT(array_fault(pickle), HasSubstr("wrapped too deeply"));
}

// If a Python with numpy and scipy is installed, everything it writes in every protocol must be readable.
TEST(PickleArray, ReadsWhatNumpyAndScipyWrite) {
  const char* chosen = std::getenv("LIKENESS_PYTHON");
  const std::string python = chosen ? chosen : "python3";
  if (std::system((python + " -c 'import numpy, scipy.sparse' 2>/dev/null").c_str()) != 0)
    GTEST_SKIP() << "needs a python3 with numpy and scipy (LIKENESS_PYTHON names one)";
  const auto folder = std::filesystem::temp_directory_path() /
                      std::string("likeness_pickles_").append(std::to_string(std::random_device{}()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "write.py") << R"(import pickle, sys, numpy as np, scipy.sparse as sp
r = np.random.default_rng(1)
a = {'f8': r.normal(size=(4, 3, 2)), 'fortran': np.asfortranarray(r.normal(size=(4, 3))),
     'f4': r.normal(size=(5,)).astype('f4'), 'u4': np.array([[4294967295, 1]], 'u4'), 'i8': np.arange(6).reshape(2, 3),
     'big': np.arange(4, dtype='>i4'), 'flag': np.array([True, False]), 'scalar': np.float64(2.5), 'zero': np.zeros((0, 3)),
     'single': np.array(3.0), 'csc': sp.csc_matrix(np.diag([1., 2., 3.])), 'csr': sp.csr_matrix(np.eye(2, 3)),
     'list': [1, 2.5]}
d = {k: np.asarray(v.todense() if sp.issparse(v) else v) for k, v in a.items()}
d = {k: np.ascontiguousarray(v.astype(v.dtype.newbyteorder('<'))).reshape(v.shape) for k, v in d.items()}
np.savez(sys.argv[1] + '/want.npz', **d)
for p in range(6):
    pickle.dump(a, open('%s/%d.pkl' % (sys.argv[1], p), 'wb'), p)
)";
  ASSERT_EQ(std::system((python + " " + (folder / "write.py").string() + " " + folder.string()).c_str()), 0);
  const auto want = read_npz(folder / "want.npz");
  ASSERT_TRUE(want.ok()) << want.error().what;
  for (int protocol = 0; protocol <= 5; ++protocol) {
    const auto bytes = read_file(folder / std::to_string(protocol).append(".pkl"));
    ASSERT_TRUE(bytes.ok());
    const auto document = read_pickle(*bytes, "x");
    ASSERT_TRUE(document.ok()) << protocol << ": " << document.error().what;
    for (const auto& [key, array] : *want) {
      const PickleRef* found = find_key(*document, document->root, key);
      ASSERT_NE(found, nullptr) << key;
      const auto got = pickle_array(*document, *found);
      ASSERT_TRUE(got.ok()) << protocol << " " << key << ": " << got.error().what;
      EXPECT_EQ(got->shape, array.shape) << protocol << " " << key;
      EXPECT_EQ(got->as_float(), array.as_float()) << protocol << " " << key;
    }
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace likeness
