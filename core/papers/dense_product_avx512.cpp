// The float products, compiled for AVX-512 (its flags are in CMakeLists.txt).
#define Eigen Eigen_avx512
#define LIKENESS_PRODUCTS products_avx512
#include "core/papers/dense_product-inl.h"

namespace likeness {

DenseProducts<float> dense_products_avx512() { return products_avx512::products<float>(); }

}  // namespace likeness
