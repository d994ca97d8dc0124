// The core's functions over whole arrays, as a scalar type computes them: for tests, which compare
// doubles with the lanes of every instruction set.
//
// Included by the kernels of each instruction set, so that all is in their unnamed namespaces.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include "multilift/multilift.hpp"

namespace multilift::bindings {

namespace {

namespace nb = nanobind;

using Numbers = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Integers = nb::ndarray<const std::uint64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Written = nb::ndarray<double, nb::c_contig, nb::device::cpu>;

/// out[i] = f(x[i], y[i]), as many at a time as R carries; the last numbers fill an R up.
template <class R, class F>
void map_arrays(const Numbers& x, const Numbers& y, const Written& out, const F& f) {
  constexpr auto width = static_cast<std::size_t>(lanes_of<R>);
  const std::size_t count = x.shape(0);
  for (std::size_t first = 0; first < count; first += width) {
    R a(0.0), b(0.0);
    for (std::size_t k = 0; k < width; ++k) {
      const std::size_t i = std::min(first + k, count - 1);
      set_lane(a, static_cast<int>(k), x.data()[i]);
      set_lane(b, static_cast<int>(k), y.data()[i]);
    }
    const R result = f(a, b);
    for (std::size_t k = 0; k < width && first + k < count; ++k)
      out.data()[first + k] = lane(result, static_cast<int>(k));
  }
}

template <class R>
void evaluate(const std::string& name, const Numbers& x, const Numbers& y, const Written& out) {
  if (y.shape(0) != x.shape(0) || out.size() != x.shape(0))
    throw std::invalid_argument("x, y and out have one length");
  const auto with = [&](const auto& f) { map_arrays<R>(x, y, out, f); };
  if (name == "sqrt") return with([](const R& a, const R&) { return sqrt(a); });
  if (name == "sin") return with([](const R& a, const R&) { return sincos(a).sin; });
  if (name == "cos") return with([](const R& a, const R&) { return sincos(a).cos; });
  if (name == "exp") return with([](const R& a, const R&) { return exp(a); });
  if (name == "log") return with([](const R& a, const R&) { return log(a); });
  if (name == "atan") return with([](const R& a, const R&) { return atan(a); });
  if (name == "atan2") return with([](const R& a, const R& b) { return atan2(a, b); });
  throw std::invalid_argument("no function is called '" + name + "'");
}

/// Seeds by draws by 2 normal numbers of one stream.
template <class R>
void fill_normals(const Integers& seeds, std::uint64_t stream, const Integers& draws,
                  const Written& out) {
  constexpr auto width = static_cast<std::size_t>(lanes_of<R>);
  const std::size_t worlds = seeds.shape(0), count = draws.shape(0);
  if (out.size() != 2 * worlds * count)
    throw std::invalid_argument("out has the shape (seeds, draws, 2)");
  for (std::size_t first = 0; first < worlds; first += width) {
    words_t<R> seed{};
    if constexpr (width == 1)
      seed = seeds.data()[first];
    else
      for (std::size_t k = 0; k < width; ++k)
        seed[k] = seeds.data()[std::min(first + k, worlds - 1)];
    for (std::size_t n = 0; n < count; ++n) {
      const auto pair = normal_pair<R>(seed, stream, words_t<R>{} + draws.data()[n]);
      for (std::size_t k = 0; k < width && first + k < worlds; ++k)
        for (std::size_t i = 0; i < 2; ++i)
          out.data()[2 * ((first + k) * count + n) + i] = lane(pair[i], static_cast<int>(k));
    }
  }
}

template <class R>
void bind_math_arrays(nb::module_& m) {
  m.def("evaluate", &evaluate<R>, nb::arg("name"), nb::arg("x"), nb::arg("y"),
        nb::arg("out").noconvert(),
        "out = sqrt, sin, cos, exp, log or atan of x, or atan2(x, y), as this module computes it.");
  m.def("normals", &fill_normals<R>, nb::arg("seeds"), nb::arg("stream"), nb::arg("draws"),
        nb::arg("out").noconvert(),
        "Fills out, shape (seeds, draws, 2), with the normal numbers of these draws.");
}

}  // namespace

}  // namespace multilift::bindings
