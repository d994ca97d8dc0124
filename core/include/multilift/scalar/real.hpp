// What an equation may ask of its scalar type.
//
// Every equation in multilift is written once over a type `R` that models `Real`: double, SIMD
// lanes (lanes.hpp) or dual numbers (dual.hpp). A comparison yields `mask_t<R>`, which is bool for
// double and one truth value per lane for lanes; branches are written as `select(mask, a, b)`.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <vector>

// For the functions of the hot loop: GCC's own estimate leaves them as calls, at a third of the
// speed for lanes. What they work with locally is not declared const: GCC 12 then keeps it in
// memory instead of registers.
#if defined(__GNUC__) || defined(__clang__)
#define MULTILIFT_INLINE inline __attribute__((always_inline))
#define MULTILIFT_NOINLINE __attribute__((noinline))
#define MULTILIFT_INLINE_LAMBDA __attribute__((always_inline))
#else
#define MULTILIFT_INLINE inline
#define MULTILIFT_NOINLINE
#define MULTILIFT_INLINE_LAMBDA
#endif

namespace multilift {

inline double sqrt(double x) { return std::sqrt(x); }
inline double abs(double x) { return std::fabs(x); }
inline double select(bool mask, double a, double b) { return mask ? a : b; }
inline bool any(bool mask) { return mask; }
inline bool all(bool mask) { return mask; }

/// The plain double behind a scalar of one world; for dual numbers it drops the derivatives.
inline double value(double x) { return x; }

/// Whether a scalar carries derivatives along.
template <class R>
inline constexpr bool differentiates = false;

/// How many worlds a scalar carries side by side, and what each of them sees as its scalar.
template <class R>
inline constexpr int lanes_of = 1;
template <class R>
struct LaneScalar {
  using type = R;
};
template <class R>
using lane_scalar_t = typename LaneScalar<R>::type;

/// World i's share of a scalar or of a mask.
template <class R>
const R& lane(const R& x, int) {
  return x;
}
template <class R>
void set_lane(R& x, int, const R& share) {
  x = share;
}

/// Unsigned integers of 64 bits, as many as a scalar carries worlds: std::uint64_t for one.
template <class R>
struct WordsOf {
  using type = std::uint64_t;
};
template <class R>
using words_t = typename WordsOf<R>::type;

/// A double's bits, and the double that has them, for functions that take numbers apart.
inline std::uint64_t bits_of(double x) { return std::bit_cast<std::uint64_t>(x); }
template <class R>
MULTILIFT_INLINE R from_bits(const words_t<R>& bits) {
  if constexpr (sizeof(R) == sizeof(bits))
    return std::bit_cast<R>(bits);
  else
    return R(std::bit_cast<double>(bits));  // more than a number: it has no derivatives
}

template <class R>
using mask_t = decltype(std::declval<R>() < std::declval<R>());

/// One mask for each of several things; a struct, since a std::vector of bool packs bits.
template <class R>
struct Mask {
  mask_t<R> is;
};
template <class R>
using Masks = std::vector<Mask<R>>;

template <class R>
concept Real = std::constructible_from<R, double> && requires(R a, R b) {
  { a + b } -> std::convertible_to<R>;
  { a - b } -> std::convertible_to<R>;
  { a * b } -> std::convertible_to<R>;
  { a / b } -> std::convertible_to<R>;
  { -a } -> std::convertible_to<R>;
  { sqrt(a) } -> std::convertible_to<R>;
  { abs(a) } -> std::convertible_to<R>;
  { select(a < b, a, b) } -> std::convertible_to<R>;
  { any(a < b) } -> std::same_as<bool>;
};

template <Real R>
R min(const R& a, const R& b) {
  return select(b < a, b, a);
}

template <Real R>
R max(const R& a, const R& b) {
  return select(a < b, b, a);
}

template <Real R>
R clamp(const R& x, const R& lo, const R& hi) {
  return min(max(x, lo), hi);
}

template <Real R>
R square(const R& x) {
  return x * x;
}

/// True where x is neither infinite nor NaN.
template <Real R>
mask_t<R> is_finite(const R& x) {
  return abs(x) <= R(std::numeric_limits<double>::max());
}

}  // namespace multilift
