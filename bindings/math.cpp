// Pieces of core/math that tests check on their own.
#include <nanobind/ndarray.h>

#include "arrays.hpp"
#include "multilift/math/philox.hpp"

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
      "sincos_lanes",
      [](double x) {
        const auto [s, c] = sincos(Lanes<4>(x));
        return nb::make_tuple(s[3], c[3]);
      },
      nb::arg("x"), "Sine and cosine of x, rad, as a lane of a SIMD register computes them.");
  m.def(
      "philox",
      [](const std::array<std::uint32_t, 4>& counter, const std::array<std::uint32_t, 2>& key) {
        return philox(counter, key);
      },
      nb::arg("counter"), nb::arg("key"), "One block of Philox 4x32-10.");
  m.def(
      "normal_pair",
      [](std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
        return normal_pair(seed, stream, index);
      },
      nb::arg("seed"), nb::arg("stream"), nb::arg("index"),
      "Two standard normal draws, a pure function of the arguments.");
}

}  // namespace multilift::bindings
