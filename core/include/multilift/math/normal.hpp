// Standard normal numbers from counter-based random bits, the same to the last bit for a double and
// a lane.
#pragma once

#include <numbers>

#include "multilift/math/log.hpp"
#include "multilift/math/philox.hpp"
#include "multilift/math/sincos.hpp"

namespace multilift {

/// Two independent standard normal numbers (Box and Muller) of each world, for its draw `index` of
/// `stream`. R is double or lanes. Of 2^32 sizes and as many angles; none is greater than 6.8.
template <class R>
MULTILIFT_INLINE std::array<R, 2> normal_pair(const words_t<R>& seed, std::uint64_t stream,
                                              const words_t<R>& index) {
  const PhiloxBlock<R> bits = philox<R>(seed, stream, index);
  // Midpoints of 2^32 cells, so that the logarithm never sees 0. A word below 2^52 is the fraction
  // of a double between 2^52 and 2^53.
  const auto in_unit = [](const words_t<R>& word) MULTILIFT_INLINE_LAMBDA {
    const R whole = from_bits<R>(word | bits_of(0x1p52)) - R(0x1p52);
    return (whole + R(0.5)) * R(0x1p-32);
  };
  const R radius = sqrt(R(-2.0) * log(in_unit(bits.w0)));
  const auto [sine, cosine] = sincos(R(2.0 * std::numbers::pi) * in_unit(bits.w1));
  return {radius * cosine, radius * sine};
}

}  // namespace multilift
