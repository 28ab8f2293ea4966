// The products for one instruction set. Included once by a source file with its own compiler flags, which
// renames Eigen's namespace: two versions of one template must not meet in the linker.
#include <Eigen/Core>

#include "core/papers/dense_product.h"

namespace likeness::LIKENESS_PRODUCTS {
namespace {

template <class Real>
using Given = Eigen::Map<const Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>>;
template <class Real>
using Changed = Eigen::Map<Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>>;

template <class Real>
void add_forward(const Real* w, int outputs, int inputs, const Real* x, int n, Real* y) {
  Changed<Real>(y, outputs, n).noalias() += Given<Real>(w, outputs, inputs) * Given<Real>(x, inputs, n);
}
template <class Real>
void add_backward(const Real* w, int outputs, int inputs, const Real* y, int n, Real* x) {
  Changed<Real>(x, inputs, n).noalias() +=
      Given<Real>(w, outputs, inputs).transpose() * Given<Real>(y, outputs, n);
}
template <class Real>
void add_weights(const Real* y, int outputs, int inputs, const Real* x, int n, Real* w) {
  Changed<Real>(w, outputs, inputs).noalias() +=
      Given<Real>(y, outputs, n) * Given<Real>(x, inputs, n).transpose();
}

}  // namespace

template <class Real>
DenseProducts<Real> products() {
  return {add_forward<Real>, add_backward<Real>, add_weights<Real>};
}

}  // namespace likeness::LIKENESS_PRODUCTS
