// The products for every processor, and the choice among them.
#define LIKENESS_PRODUCTS products_plain
#include "core/papers/dense_product-inl.h"

namespace likeness {

#ifdef LIKENESS_X86_PRODUCTS
DenseProducts<float> dense_products_avx2();
DenseProducts<float> dense_products_avx512();
#endif

namespace {

DenseProducts<float> widest() {
#ifdef LIKENESS_X86_PRODUCTS
  __builtin_cpu_init();
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    return dense_products_avx512();
  if (avx2) return dense_products_avx2();
#endif
  return products_plain::products<float>();
}

}  // namespace

template <>
const DenseProducts<float>& dense_products() {
  static const DenseProducts<float> chosen = widest();
  return chosen;
}

template <>
const DenseProducts<double>& dense_products() {
  static const DenseProducts<double> plain = products_plain::products<double>();
  return plain;
}

}  // namespace likeness
