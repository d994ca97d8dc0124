// Pieces of core/math that tests check on their own.
#include <nanobind/ndarray.h>

#include "arrays.hpp"
#include "math_arrays.hpp"

namespace multilift::bindings {

void bind_math(nb::module_& m) {
  m.def(
      "sincos",
      [](double x) {
        const auto [s, c] = sincos(x);
        return nb::make_tuple(s, c);
      },
      nb::arg("x"), "Sine and cosine of x, rad.");
  m.def(
      "philox",
      [](const std::array<std::uint32_t, 4>& counter, const std::array<std::uint32_t, 2>& key) {
        const auto block =
            philox<double>({counter[0], counter[1], counter[2], counter[3]}, key[0], key[1]);
        return std::array<std::uint64_t, 4>{block.w0, block.w1, block.w2, block.w3};
      },
      nb::arg("counter"), nb::arg("key"), "One block of Philox 4x32-10.");
  m.def(
      "normal_pair",
      [](std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
        return normal_pair<double>(seed, stream, index);
      },
      nb::arg("seed"), nb::arg("stream"), nb::arg("index"),
      "Two standard normal draws, a pure function of the arguments.");
  bind_math_arrays<double>(m);
}

}  // namespace multilift::bindings
