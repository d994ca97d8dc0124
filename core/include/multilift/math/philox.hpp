// Counter-based random numbers: draw n of stream s under seed k is a pure function of (k, s, n).
//
// Philox 4x32-10 of Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3"
// (SC 2011). No state to carry, so a world draws the same whatever the batch, thread or machine.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace multilift {

using PhiloxBlock = std::array<std::uint32_t, 4>;

inline PhiloxBlock philox(PhiloxBlock counter, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53} * counter[0];
    const std::uint64_t b = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {
        static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
        static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key = {key[0] + 0x9E3779B9U, key[1] + 0xBB67AE85U};
  }
  return counter;
}

/// Two independent numbers, uniform on (0, 1), for draw `index` of `stream`.
inline std::array<double, 2> uniform_pair(std::uint64_t seed, std::uint64_t stream,
                                          std::uint64_t index) {
  const PhiloxBlock bits =
      philox({static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32),
              static_cast<std::uint32_t>(stream), static_cast<std::uint32_t>(stream >> 32)},
             {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
  // Midpoints of 2^32 cells, so that no logarithm sees 0.
  return {(bits[0] + 0.5) * 0x1p-32, (bits[1] + 0.5) * 0x1p-32};
}

/// Two independent standard normal numbers (Box and Muller) for draw `index` of `stream`.
inline std::array<double, 2> normal_pair(std::uint64_t seed, std::uint64_t stream,
                                         std::uint64_t index) {
  const auto [u, v] = uniform_pair(seed, stream, index);
  const double angle = 2.0 * std::numbers::pi * v;
  const double radius = std::sqrt(-2.0 * std::log(u));
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace multilift
