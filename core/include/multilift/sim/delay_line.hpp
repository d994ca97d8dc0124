// Values that arrive some integration steps after they were sent; each world of a batch has its own
// delay. A value may be late by more than that, or lost; who comes after a newer one is ignored.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "multilift/fields.hpp"

namespace multilift {

/// T holds scalars R and offers `visit_scalars(other, f)`, which calls f(mine, its) for each pair.
template <class R, class T, std::size_t Capacity = 256>
class DelayLine {
 public:
  static constexpr int width = lanes_of<R>;
  using Delays = std::array<long, static_cast<std::size_t>(width)>;

  /// `initial` is what arrives until the first value sent has travelled.
  DelayLine(const Delays& delay_steps, const T& initial)
      : delay_(delay_steps), current_(initial), queue_(Capacity, Entry{0, {}, initial}) {}

  static constexpr std::size_t capacity() { return Capacity; }

  /// At most Capacity values may be under way at once; scenarios are checked for that. `late` adds
  /// to the delay; `lost` never arrives.
  void send(long step, const T& value, const Delays& late = {}) {
    Entry& entry = queue_[sent_ % Capacity];
    for (std::size_t i = 0; i < late.size(); ++i)
      entry.arrival[i] = late[i] == lost ? lost : step + delay_[i] + late[i];
    entry.step = step;
    entry.value = value;
    ++sent_;
  }

  /// The newest value that has arrived by `step`, world by world.
  const T& receive(long step) {
    for (int k = 0; k < width; ++k) {
      const auto i = static_cast<std::size_t>(k);
      std::size_t newest = received_[i];
      const std::size_t first = sent_ < Capacity ? newest : std::max(newest, sent_ - Capacity);
      for (std::size_t j = first; j < sent_; ++j)
        if (queue_[j % Capacity].arrival[i] <= step) newest = j + 1;
      if (newest == received_[i]) continue;
      received_[i] = newest;
      const Entry& entry = queue_[(newest - 1) % Capacity];
      current_.visit_scalars(entry.value,
                             [k](auto& mine, const auto& its) { set_lane(mine, k, lane(its, k)); });
      sent_at_[i] = entry.step;
    }
    return current_;
  }

  /// When what world k received last was sent, as a step.
  long sent_at(int k) const { return sent_at_[static_cast<std::size_t>(k)]; }

  static constexpr long lost = std::numeric_limits<long>::max();

 private:
  struct Entry {
    long step;
    Delays arrival;  // as steps
    T value;
  };
  Delays delay_;
  T current_;
  std::vector<Entry> queue_;
  std::size_t sent_{0};
  std::array<std::size_t, static_cast<std::size_t>(width)> received_{};
  Delays sent_at_{};
};

}  // namespace multilift
