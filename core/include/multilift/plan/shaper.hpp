// Input shapers: a move is split into copies that come one after the other, timed and weighed so
// that the swings that they leave cancel (Smith; Singer and Seering; Singhose, Seering and Singer).
//
// With K = exp(-zeta pi / sqrt(1 - zeta^2)), what a mode's damping leaves of it in half a period,
//
//     ZV   1, K            over 1 + K
//     ZVD  1, 2K, K^2      over (1 + K)^2
//     EI   (1+V)/4, K (1-V)/2, K^2 (1+V)/4   over their sum
//
// half a damped period apart. ZV leaves nothing where frequency and damping are right; ZVD nothing
// to first order in the frequency's error; EI, of an undamped mode, the part V where they are
// right, nothing at two frequencies beside, and no more than V between and a little beyond.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "multilift/plan/hermite.hpp"

namespace multilift::plan {

enum class ShaperKind { zv, zvd, ei };

/// A mode of swing.
struct Mode {
  double frequency;     // without damping, rad/s
  double damping{0.0};  // as a part of the critical one, below 1

  double half_period() const {
    return std::numbers::pi / (frequency * std::sqrt(1.0 - damping * damping));
  }
};

struct Impulse {
  double time;    // s
  double weight;  // all together 1
};

inline std::vector<Impulse> shaper(ShaperKind kind, const Mode& mode, double tolerance) {
  const double k =
      std::exp(-mode.damping * std::numbers::pi / std::sqrt(1.0 - mode.damping * mode.damping));
  const double outer = 0.25 * (1.0 + tolerance), inner = 0.5 * (1.0 - tolerance);
  std::vector<double> weight;
  switch (kind) {
    case ShaperKind::zv:
      weight = {1.0, k};
      break;
    case ShaperKind::zvd:
      weight = {1.0, 2.0 * k, k * k};
      break;
    case ShaperKind::ei:
      weight = {outer, k * inner, k * k * outer};
      break;
  }
  double sum = 0.0;
  for (double w : weight) sum += w;
  std::vector<Impulse> impulses;
  for (double w : weight)
    impulses.push_back({static_cast<double>(impulses.size()) * mode.half_period(), w / sum});
  return impulses;
}

/// What a shaper leaves of a mode's swing, as a part of what an impulse at once would leave, at the
/// time of the last impulse.
inline double residual(const std::vector<Impulse>& impulses, const Mode& mode) {
  const double decay = mode.damping * mode.frequency;
  const double turning = std::numbers::pi / mode.half_period();
  double cosine = 0.0, sine = 0.0;
  for (const Impulse& impulse : impulses) {
    const double left = impulse.weight * std::exp(decay * (impulse.time - impulses.back().time));
    cosine += left * std::cos(turning * impulse.time);
    sine += left * std::sin(turning * impulse.time);
  }
  return std::hypot(cosine, sine);
}

/// The sum of a way's copies at a time; the way begins at rest.
template <std::size_t D>
Motion<D> shaped(const std::vector<Impulse>& impulses, const Path<D>& way, double time) {
  Motion<D> sum{};
  for (const Impulse& impulse : impulses) {
    const Motion<D> copy = way.at(time - impulse.time);
    for (std::size_t c = 0; c < D; ++c)
      for (std::size_t k = 0; k < sum[c].size(); ++k) sum[c][k] += impulse.weight * copy[c][k];
  }
  return sum;
}

}  // namespace multilift::plan
