// The float products, compiled for AVX2 (its flags are in CMakeLists.txt).
#define Eigen Eigen_avx2
#define LIKENESS_PRODUCTS products_avx2
#include "core/papers/dense_product-inl.h"

namespace likeness {

DenseProducts<float> dense_products_avx2() { return products_avx2::products<float>(); }

}  // namespace likeness
