// Standard normal numbers from counter-based random bits, the same to the last bit for a double and
// a lane.
#pragma once

#include <numbers>

#include "multilift/math/log.hpp"
#include "multilift/math/philox.hpp"
#include "multilift/math/sincos.hpp"

namespace multilift {

/// Two independent numbers of each world, uniform on (0, 1), for its draw `index` of `stream`. R is
/// double or lanes. Midpoints of 2^32 cells, so that no logarithm sees 0.
template <class R>
MULTILIFT_INLINE std::array<R, 2> uniform_pair(const words_t<R>& seed, std::uint64_t stream,
                                               const words_t<R>& index) {
  const PhiloxBlock<R> bits = philox<R>(seed, stream, index);
  // A word below 2^52 is the fraction of a double between 2^52 and 2^53.
  const auto in_unit = [](const words_t<R>& word) MULTILIFT_INLINE_LAMBDA {
    const R whole = from_bits<R>(word | bits_of(0x1p52)) - R(0x1p52);
    return (whole + R(0.5)) * R(0x1p-32);
  };
  return {in_unit(bits.w0), in_unit(bits.w1)};
}

/// Two independent standard normal numbers (Box and Muller) likewise. Of 2^32 sizes and as many
/// angles; none is greater than 6.8.
template <class R>
MULTILIFT_INLINE std::array<R, 2> normal_pair(const words_t<R>& seed, std::uint64_t stream,
                                              const words_t<R>& index) {
  const auto [u, v] = uniform_pair<R>(seed, stream, index);
  const R radius = sqrt(R(-2.0) * log(u));
  const auto [sine, cosine] = sincos(R(2.0 * std::numbers::pi) * v);
  return {radius * cosine, radius * sine};
}

/// One seed for each world, as the draws take them.
template <class R>
words_t<R> seed_words(
    const std::array<std::uint64_t, static_cast<std::size_t>(lanes_of<R>)>& seeds) {
  words_t<R> words{};
  if constexpr (lanes_of<R> == 1)
    words = seeds[0];
  else
    for (std::size_t k = 0; k < seeds.size(); ++k) words[k] = seeds[k];
  return words;
}

}  // namespace multilift
