// Values that arrive a fixed number of integration steps after they were sent, in order; each
// world of a batch has its own delay.
#pragma once

#include <array>
#include <cstddef>

#include "multilift/fields.hpp"

namespace multilift {

/// T holds scalars R and offers `visit_scalars(other, f)`, which calls f(mine, its) for each pair.
template <class R, class T, std::size_t Capacity = 256>
class DelayLine {
 public:
  static constexpr int width = lanes_of<R>;
  using Delays = std::array<long, static_cast<std::size_t>(width)>;

  /// `initial` is what arrives until the first value sent has travelled.
  DelayLine(const Delays& delay_steps, const T& initial) : delay_(delay_steps), current_(initial) {}

  static constexpr std::size_t capacity() { return Capacity; }

  /// At most Capacity values may be under way at once; scenarios are checked for that.
  void send(long step, const T& value) {
    queue_[sent_ % Capacity] = {step, value};
    ++sent_;
  }

  /// The newest value that has arrived by `step`, world by world.
  const T& receive(long step) {
    for (int k = 0; k < width; ++k) {
      const auto i = static_cast<std::size_t>(k);
      while (received_[i] < sent_ && queue_[received_[i] % Capacity].step + delay_[i] <= step) {
        const T& arrived = queue_[received_[i] % Capacity].value;
        current_.visit_scalars(
            arrived, [k](auto& mine, const auto& its) { set_lane(mine, k, lane(its, k)); });
        ++received_[i];
      }
    }
    return current_;
  }

 private:
  struct Entry {
    long step;
    T value;
  };
  Delays delay_;
  T current_;
  std::array<Entry, Capacity> queue_{};
  std::size_t sent_{0};
  std::array<std::size_t, static_cast<std::size_t>(width)> received_{};
};

}  // namespace multilift
