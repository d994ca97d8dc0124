// A planar reference's way between Python and the core.
#pragma once

#include <nanobind/stl/array.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>

#include "multilift/control/planar/reference.hpp"

namespace multilift::bindings {

namespace {

/// When a piece starts, s, and its coefficients along y and z.
using PlanarPiece = std::tuple<double, std::array<plan::Polynomial, 2>>;

inline planar::Path planar_path(const std::vector<PlanarPiece>& pieces, double end) {
  planar::Path path{{}, end};
  for (const auto& [start, coordinate] : pieces) path.pieces.push_back({start, coordinate});
  return path;
}

/// From Python: lead, age of measurements, both in s, and whether damping counts (not 0).
inline planar::View planar_view(const std::array<double, 3>& view) {
  return {view[0], view[1], view[2] != 0.0};
}

/// None where there are no pieces: the goal rests from the start.
template <class R>
std::optional<planar::Reference<R>> reference_along(const planar::Path& path,
                                                    const planar::Plant<R>& assumed,
                                                    const std::array<Vec2<R>, 2>& goal,
                                                    const planar::View& view) {
  if (path.pieces.empty()) return std::nullopt;
  return planar::Reference<R>(assumed, goal, path, view);
}

template <class R>
const planar::Reference<R>* pointer_to(const std::optional<planar::Reference<R>>& reference) {
  return reference ? &*reference : nullptr;
}

}  // namespace

}  // namespace multilift::bindings
