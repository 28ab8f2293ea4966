// Products of dense column-major matrices for the baselines' networks, by Eigen. In float they run on the
// widest instructions that the processor has, chosen at run time.
#pragma once

namespace likeness {

// w: (outputs, inputs), x: (inputs, n), y: (outputs, n).
template <class Real>
struct DenseProducts {
  void (*add_forward)(const Real* w, int outputs, int inputs, const Real* x, int n, Real* y);  // y += w x
  void (*add_backward)(const Real* w, int outputs, int inputs, const Real* y, int n,
                       Real* x);  // x += w^T y
  void (*add_weights)(const Real* y, int outputs, int inputs, const Real* x, int n,
                      Real* w);  // w += y x^T
};

template <class Real>
const DenseProducts<Real>& dense_products();  // float and double

}  // namespace likeness
