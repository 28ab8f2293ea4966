// Claims about core/lab/bench/field_error.h: the standard field's fast path is as exact as single precision
// lets it be, and an error would be seen.
#include "core/lab/bench/field_error.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

TEST(FieldError, OfTheStandardFieldIsThatOfSinglePrecision) {
  const Field field = standard_field(3);
  const FieldError error = field_error(field, standard_batch(field.config, 700, 4));
  EXPECT_GT(error.outputs, 0);
  EXPECT_LE(error.outputs, 1e-5);
  EXPECT_GT(error.networks, 0);
  EXPECT_LE(error.networks, 1e-4);
  EXPECT_GT(error.tables, 0);
  EXPECT_LE(error.tables, 1e-4);
  EXPECT_LE(error.adam, 1e-5);
  EXPECT_LT(error.left_out, 350u);
}

TEST(FieldError, OfBf16IsThatOfItsRounding) {
  const Field field = standard_field(3);
  if (!has_bf16(field.config)) GTEST_SKIP() << "this processor has no AVX-512 BF16";
  const FieldError error = field_error(field, standard_batch(field.config, 700, 4), FieldPrecision::bf16);
  EXPECT_GT(error.outputs, 1e-4);
  EXPECT_LE(error.outputs, 1e-2);
  EXPECT_GT(error.networks, 1e-4);
  EXPECT_LE(error.networks, 0.1);
  EXPECT_GT(error.tables, 1e-4);
  EXPECT_LE(error.tables, 0.1);
  EXPECT_LE(error.adam, 1e-5);
}

}  // namespace
}  // namespace likeness
