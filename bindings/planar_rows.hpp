// The rows in which worlds' numbers come: plant | assumed plant | gains | actuators | sensors |
// free coordinates (10) | goal (4) | for each push: force (2), torque, start, duration, frequency.
//
// Included by the kernels of each instruction set, so that all is in their unnamed namespaces.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "multilift/multilift.hpp"
#include "push_names.hpp"

namespace multilift::bindings {

namespace {

namespace nb = nanobind;

template <class T>
using Array1 = nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <class T>
using Array2 = nb::ndarray<T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// What worlds of one batch share about a push; force, torque and times are each world's own.
struct PushShapes {
  planar::Body body;
  PushShape shape;
  std::vector<double> sample_times, sample_values;
};

/// Body, shape, sample times, sample values.
using PushTuple = std::tuple<std::string, std::string, std::vector<double>, std::vector<double>>;

inline std::vector<PushShapes> shapes_from(const std::vector<PushTuple>& pushes) {
  std::vector<PushShapes> shapes;
  for (const auto& [body, shape, times, values] : pushes)
    shapes.push_back({body_from(body), shape_from(shape), times, values});
  return shapes;
}

template <class Next>
auto start_from(const Next& next) {
  using R = decltype(next());
  planar::State<R> start;
  start.bar = {next(), next()};
  for (R& x : start.theta) x = next();
  start.bar_velocity = {next(), next()};
  for (R& x : start.theta_dot) x = next();
  return start;
}

template <class Next>
auto pushes_from(const std::vector<PushShapes>& all, const Next& next) {
  using R = decltype(next());
  std::vector<planar::Push<R>> pushes;
  for (const PushShapes& shapes : all) {
    planar::Push<R> push{shapes.body, {}, R(0.0), {}};
    push.force = {next(), next()};
    push.torque = next();
    const R begin = next(), duration = next(), frequency = next();
    push.profile = {shapes.shape,        begin, duration, frequency, shapes.sample_times,
                    shapes.sample_values};
    pushes.push_back(std::move(push));
  }
  return pushes;
}

/// Refuses rows of the wrong length for a law's gains and the pushes.
template <class Gains>
void check_columns(std::size_t columns, std::size_t pushes) {
  using R = double;
  const std::size_t expected = 2 * count_scalars<planar::Parameters<R>>() + count_scalars<Gains>() +
                               count_scalars<planar::ActuatorParameters<R>>() +
                               count_scalars<planar::SensorParameters<R>>() + 14 + 6 * pushes;
  if (columns != expected)
    throw std::invalid_argument("a world takes " + std::to_string(expected) + " numbers, got " +
                                std::to_string(columns));
}

}  // namespace

}  // namespace multilift::bindings
