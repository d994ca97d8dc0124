// Parameter structs as Python sees them: a table of fields, and flat arrays of numbers.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "multilift/fields.hpp"

namespace multilift::bindings {

namespace nb = nanobind;

template <class R>
nb::tuple shape_of(const R&) {
  return nb::make_tuple();
}
template <class R>
nb::tuple shape_of(const Vec2<R>&) {
  return nb::make_tuple(2);
}
template <class R>
nb::tuple shape_of(const Vec3<R>&) {
  return nb::make_tuple(3);
}
template <class T, std::size_t N>
nb::tuple shape_of(const std::array<T, N>& member) {
  return nb::tuple(nb::make_tuple(N) + shape_of(member[0]));
}

/// A vector's length is the number of vehicles, "n".
template <class T>
nb::tuple shape_of(const std::vector<T>& member) {
  return nb::tuple(nb::make_tuple("n") + shape_of(member.at(0)));
}

inline const char* name_of(Range range) {
  switch (range) {
    case Range::positive:
      return "positive";
    case Range::non_negative:
      return "non_negative";
    case Range::any:
      return "any";
  }
  return "any";
}

/// [(name, unit, range, shape, defaults, doc), ...] of a self-describing parameter struct; one that
/// is constructed with the number of vehicles gets 1, so that defaults are a single vehicle's.
template <class P>
nb::list field_table() {
  nb::list table;
  P parameters = [] {
    if constexpr (std::is_default_constructible_v<P>)
      return P();
    else
      return P(1);
  }();
  P::visit(parameters, [&](const Field& field, auto& member) {
    nb::list defaults;
    for_each_scalar(member, [&](auto& scalar) { defaults.append(value(scalar)); });
    table.append(nb::make_tuple(field.name, field.unit, name_of(field.range), shape_of(member),
                                defaults, field.doc));
  });
  return table;
}

/// A parameter struct from the numbers of its fields in order; rejects a wrong count.
template <class P>
P unpack_checked(const std::vector<double>& values, const char* what) {
  const std::size_t expected = count_scalars<P>();
  if (values.size() != expected)
    throw std::invalid_argument(std::string(what) + " takes " + std::to_string(expected) +
                                " numbers, got " + std::to_string(values.size()));
  return unpack<P>(values.data());
}

/// A dict from anything that reports its entries by v(Field, value).
template <class Reporter>
nb::dict as_dict(const Reporter& reporter) {
  nb::dict result;
  reporter.report([&](const Field& field, double x) { result[field.name] = x; });
  return result;
}

/// [(name, unit, doc), ...] of the same.
template <class Reporter>
nb::list entry_table(const Reporter& reporter) {
  nb::list table;
  reporter.report([&](const Field& field, double) {
    table.append(nb::make_tuple(field.name, field.unit, field.doc));
  });
  return table;
}

}  // namespace multilift::bindings
