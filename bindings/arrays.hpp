// Small fixed vectors between NumPy and the core.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include "fields.hpp"
#include "multilift/multilift.hpp"

namespace multilift::bindings {

namespace nb = nanobind;

using Four = std::array<double, 4>;  // [y1, z1, y2, z2]

inline std::array<Vec2<double>, 2> pair_from(const Four& x) {
  return {Vec2<double>{x[0], x[1]}, Vec2<double>{x[2], x[3]}};
}
inline Four four_from(const std::array<Vec2<double>, 2>& x) {
  return {x[0].y, x[0].z, x[1].y, x[1].z};
}

/// [u1..u4, vehicle pushes 4, bar push 2, bar torque]
using ElevenLoads = std::array<double, 11>;

inline planar::Loads<double> loads_from(const ElevenLoads& x) {
  return {pair_from({x[0], x[1], x[2], x[3]}),
          pair_from({x[4], x[5], x[6], x[7]}),
          {x[8], x[9]},
          x[10]};
}

inline planar::Plant<double> plant_from(const std::vector<double>& values) {
  return planar::Plant<double>(
      unpack_checked<planar::Parameters<double>>(values, "the planar plant"));
}

}  // namespace multilift::bindings
