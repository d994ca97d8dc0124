// How fast this core multiplies and adds with this instruction set: what kernels stand against.
#include <nanobind/nanobind.h>

#include <chrono>
#include <cmath>

#include "multilift/scalar/lanes.hpp"

namespace multilift::bindings {

namespace {

using R = Lanes<MULTILIFT_LANES>;

/// Two roundings, as in the kernels.
struct Separate {
  static MULTILIFT_INLINE R step(const R& x, const R& a, const R& b) { return x * a + b; }
};

/// One rounding, in one instruction; the kernels do without, so that their bits are those of
/// processors that lack it.
#if defined(__AVX512F__)
#define MULTILIFT_FUSED
struct Fused {
  static MULTILIFT_INLINE R step(const R& x, const R& a, const R& b) {
    return R(reinterpret_cast<R::Vector>(_mm512_fmadd_pd(reinterpret_cast<__m512d>(x.v),
                                                         reinterpret_cast<__m512d>(a.v),
                                                         reinterpret_cast<__m512d>(b.v))));
  }
};
#endif

/// Floating-point operations a nanosecond of a loop over so many independent chains.
template <class Operation, int chains>
double rate(long repetitions) {
  R x[chains];
  for (int k = 0; k < chains; ++k) x[k] = R(1.0 + k);
  // Towards 1: neither overflow nor subnormal numbers, which are slow.
  double shrink = 0.999;
  asm volatile("" : "+x"(shrink));  // no constant, or the loop would be worked out beforehand
  const R a(shrink), b(1.0 - shrink);
  const auto begin = std::chrono::steady_clock::now();
  for (long n = 0; n < repetitions; ++n)
    for (int k = 0; k < chains; ++k) x[k] = Operation::step(x[k], a, b);
  const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - begin;
  R sum(0.0);
  for (int k = 0; k < chains; ++k) sum += x[k];
  if (!std::isfinite(sum[0])) return 0.0;  // keeps the loop
  return 2.0 * MULTILIFT_LANES * chains * static_cast<double>(repetitions) / spent.count();
}

/// The best over numbers of chains: too few wait for each other, too many do not fit registers.
template <class Operation>
double best_rate(long repetitions) {
  return std::fmax(std::fmax(rate<Operation, 8>(repetitions), rate<Operation, 10>(repetitions)),
                   std::fmax(rate<Operation, 12>(repetitions), rate<Operation, 16>(repetitions)));
}

}  // namespace

void bind_batch_peak(nanobind::module_& m) {
  m.def(
      "multiply_add_rate", &best_rate<Separate>, nanobind::arg("repetitions"),
      "Floating-point operations a nanosecond of a pure loop of products and sums, each rounded.");
#if defined(MULTILIFT_FUSED)
  m.def("fused_rate", &best_rate<Fused>, nanobind::arg("repetitions"),
        "The same with products and sums fused, which the kernels do not use.");
#else
  m.def(
      "fused_rate", [](long) { return std::nan(""); }, nanobind::arg("repetitions"),
      "NaN: fused products and sums are not part of this instruction set.");
#endif
}

}  // namespace multilift::bindings
