// How a parameter struct describes itself, once, for every reader: the scenario schema, its error
// messages, the generated reference page, and the packing into flat arrays.
//
// A struct offers `template <class Self, class V> static void visit(Self& self, V&& v)`, which
// calls `v(Field{...}, self.member)` for each member in a fixed order. A member is an R, a Vec2<R>
// or Vec3<R>, or a std::array or std::vector of these; its shape follows from its type and its
// default from its initialiser. A default of NaN means that the scenario must give the value. A
// struct with vectors is constructed with the number of vehicles, which is their length.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

#include "multilift/math/vec2.hpp"
#include "multilift/math/vec3.hpp"

namespace multilift {

enum class Range { any, positive, non_negative };

struct Field {
  const char* name;
  const char* unit;
  Range range;
  const char* doc;
};

inline constexpr double required = std::numeric_limits<double>::quiet_NaN();
inline constexpr double unlimited = std::numeric_limits<double>::infinity();

/// Calls f on every scalar of a member, in memory order.
template <Real R, class F>
void for_each_scalar(R& member, F&& f) {
  f(member);
}
template <Real R, class F>
void for_each_scalar(const R& member, F&& f) {
  f(member);
}
template <class R, class F>
void for_each_scalar(Vec2<R>& member, F&& f) {
  f(member.y);
  f(member.z);
}
template <class R, class F>
void for_each_scalar(const Vec2<R>& member, F&& f) {
  f(member.y);
  f(member.z);
}
template <class R, class F>
void for_each_scalar(Vec3<R>& member, F&& f) {
  f(member.x);
  f(member.y);
  f(member.z);
}
template <class R, class F>
void for_each_scalar(const Vec3<R>& member, F&& f) {
  f(member.x);
  f(member.y);
  f(member.z);
}
template <class T, std::size_t N, class F>
void for_each_scalar(std::array<T, N>& member, F&& f) {
  for (T& entry : member) for_each_scalar(entry, f);
}
template <class T, std::size_t N, class F>
void for_each_scalar(const std::array<T, N>& member, F&& f) {
  for (const T& entry : member) for_each_scalar(entry, f);
}
template <class T, class F>
void for_each_scalar(std::vector<T>& member, F&& f) {
  for (T& entry : member) for_each_scalar(entry, f);
}
template <class T, class F>
void for_each_scalar(const std::vector<T>& member, F&& f) {
  for (const T& entry : member) for_each_scalar(entry, f);
}

/// How many scalars a parameter struct holds; `size` is what it is constructed with, if anything.
template <class P, class... Size>
std::size_t count_scalars(Size... size) {
  std::size_t count = 0;
  P parameters(size...);
  P::visit(parameters,
           [&](const Field&, auto& member) { for_each_scalar(member, [&](auto&) { ++count; }); });
  return count;
}

/// Numbers of one world or of several side by side: `worlds` rows of doubles, `stride` apart. A
/// scalar of more lanes than there are worlds repeats the last one.
struct Rows {
  const double* first;
  std::size_t stride;
  int worlds{1};

  template <Real R>
  R at(std::size_t column) const {
    R x(0.0);
    for (int k = 0; k < lanes_of<R>; ++k) {
      const auto row = static_cast<std::size_t>(k < worlds ? k : worlds - 1);
      set_lane(x, k, lane_scalar_t<R>(first[row * stride + column]));
    }
    return x;
  }
};

/// Fills a parameter struct from count_scalars<P>(size...) columns of Rows, or of what offers the
/// same, and moves `column` on.
template <class P, class Columns, class... Size>
  requires(!std::is_pointer_v<Columns>)
P unpack(const Columns& rows, std::size_t& column, Size... size) {
  P parameters(size...);
  P::visit(parameters, [&](const Field&, auto& member) {
    for_each_scalar(member, [&](auto& scalar) {
      scalar = rows.template at<std::remove_reference_t<decltype(scalar)>>(column++);
    });
  });
  return parameters;
}

/// The same from count_scalars<P>(size...) consecutive numbers, the struct's own or doubles.
template <class P, class Number, class... Size>
P unpack(const Number* values, Size... size) {
  P parameters(size...);
  P::visit(parameters, [&](const Field&, auto& member) {
    for_each_scalar(member, [&](auto& scalar) { scalar = *values++; });
  });
  return parameters;
}

}  // namespace multilift
