// Vectors and quaternions out of and into flat arrays, one after the other.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <stdexcept>
#include <string>

#include "multilift/math/rotation.hpp"

namespace multilift::bindings {

namespace nb = nanobind;

using FlatIn = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using FlatOut = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

template <class Array>
void check_length(const Array& array, std::size_t wanted, const char* what) {
  if (array.shape(0) != wanted)
    throw std::invalid_argument(std::string(what) + " takes " + std::to_string(wanted) +
                                " numbers, got " + std::to_string(array.shape(0)));
}

class Reader {
 public:
  explicit Reader(const FlatIn& array) : at_(array.data()) {}
  explicit Reader(const double* at) : at_(at) {}
  double number() { return *at_++; }
  // Braces fill in order.
  Vec3<double> vector() { return {number(), number(), number()}; }
  Quaternion<double> quaternion() { return {number(), number(), number(), number()}; }

 private:
  const double* at_;
};

class Writer {
 public:
  explicit Writer(double* at) : at_(at) {}
  void put(double x) { *at_++ = x; }
  void put(const Vec3<double>& v) { put(v.x), put(v.y), put(v.z); }
  void put(const Quaternion<double>& q) { put(q.w), put(q.x), put(q.y), put(q.z); }

 private:
  double* at_;
};

}  // namespace multilift::bindings
