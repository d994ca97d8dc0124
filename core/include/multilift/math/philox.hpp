// Counter-based random numbers: draw n of stream s under seed k is a pure function of (k, s, n).
//
// Philox 4x32-10 of Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3"
// (SC 2011). No state to carry, so a world draws the same whatever the batch, lane, thread or
// machine.
#pragma once

#include <array>
#include <cstdint>

#include "multilift/scalar/lanes.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace multilift {

/// a b, of which only the lower halves of 32 bits are not zero. x86 has an instruction for that,
/// which compilers do not find by themselves: they multiply halves crosswise, at three times the
/// cost.
template <class R>
MULTILIFT_INLINE words_t<R> product_of_halves(const words_t<R>& a, std::uint64_t b) {
#if defined(__SSE2__)
  if constexpr (lanes_of<R> == 2)
    return std::bit_cast<words_t<R>>(
        _mm_mul_epu32(std::bit_cast<__m128i>(a), std::bit_cast<__m128i>(words_t<R>{} + b)));
#endif
#if defined(__AVX2__)
  if constexpr (lanes_of<R> == 4)
    return std::bit_cast<words_t<R>>(
        _mm256_mul_epu32(std::bit_cast<__m256i>(a), std::bit_cast<__m256i>(words_t<R>{} + b)));
#endif
  return a * b;
}

/// A block of the worlds that an R carries, each word of 32 bits in the lower half of one of 64.
template <class R>
struct PhiloxBlock {
  words_t<R> w0, w1, w2, w3;
};

/// The block that a counter and a key give.
template <class R>
MULTILIFT_INLINE PhiloxBlock<R> philox(PhiloxBlock<R> c, words_t<R> k0, words_t<R> k1) {
  constexpr std::uint64_t low = 0xffffffff;
  for (int round = 0; round < 10; ++round) {
    const words_t<R> a = product_of_halves<R>(c.w0, 0xD2511F53);
    const words_t<R> b = product_of_halves<R>(c.w2, 0xCD9E8D57);
    c = {(b >> 32) ^ c.w1 ^ k0, b & low, (a >> 32) ^ c.w3 ^ k1, a & low};
    k0 = (k0 + std::uint64_t{0x9E3779B9}) & low;
    k1 = (k1 + std::uint64_t{0xBB67AE85}) & low;
  }
  return c;
}

/// Block `index` of `stream` under `seed`, index and seed each world's own.
template <class R>
MULTILIFT_INLINE PhiloxBlock<R> philox(const words_t<R>& seed, std::uint64_t stream,
                                       const words_t<R>& index) {
  constexpr std::uint64_t low = 0xffffffff;
  const words_t<R> none{};
  return philox<R>({index & low, index >> 32, none + (stream & low), none + (stream >> 32)},
                   seed & low, seed >> 32);
}

}  // namespace multilift
