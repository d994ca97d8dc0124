// What scenarios call the bodies and shapes of pushes.
//
// Included by the kernels of each instruction set, so that all is in their unnamed namespaces.
#pragma once

#include <stdexcept>
#include <string>

#include "multilift/sim/planar/loads.hpp"

namespace multilift::bindings {

namespace {

inline PushShape shape_from(const std::string& name) {
  if (name == "pulse") return PushShape::pulse;
  if (name == "half_sine") return PushShape::half_sine;
  if (name == "sine") return PushShape::sine;
  if (name == "samples") return PushShape::samples;
  throw std::invalid_argument("no push shape is called '" + name + "'");
}

inline planar::Body body_from(const std::string& name) {
  if (name == "vehicle_1") return planar::Body::vehicle_1;
  if (name == "vehicle_2") return planar::Body::vehicle_2;
  if (name == "bar") return planar::Body::bar;
  throw std::invalid_argument("no body is called '" + name + "'");
}

}  // namespace

}  // namespace multilift::bindings
