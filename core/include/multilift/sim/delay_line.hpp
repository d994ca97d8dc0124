// Values that arrive a fixed number of integration steps after they were sent, in order; each
// world of a batch has its own delay.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <vector>

#include "multilift/fields.hpp"

namespace multilift {

/// T holds scalars R and offers `visit_scalars(other, f)`, which calls f(mine, its) for each pair.
template <class R, class T, std::size_t Capacity = 256>
class DelayLine {
 public:
  static constexpr int width = lanes_of<R>;
  using Delays = std::array<long, static_cast<std::size_t>(width)>;

  /// `initial` is what arrives until the first value sent has travelled. Values are sent at least
  /// `between_sends` steps apart and received at least every `between_receipts`, so that there is
  /// room for as many as are under way: all is allocated here.
  DelayLine(const Delays& delay_steps, const T& initial, long between_sends = 1,
            long between_receipts = 1)
      : delay_(delay_steps), current_(initial) {
    const long longest = *std::max_element(delay_.begin(), delay_.end());
    const auto under_way =
        static_cast<std::size_t>((longest + between_receipts) / between_sends + 1);
    // A power of two, for the remainders below.
    queue_.resize(std::bit_ceil(std::min(under_way, Capacity)));
  }

  static constexpr std::size_t capacity() { return Capacity; }

  /// At most Capacity values may be under way at once; scenarios are checked for that. Of two
  /// values sent at one step the second takes the place of the first.
  void send(long step, const T& value) {
    if (!sent_at(step)) ++sent_;
    at(sent_ - 1) = {step, value};
  }

  /// The newest value that has arrived by `step`, world by world.
  const T& receive(long step) {
    for (int k = 0; k < width; ++k) {
      const auto i = static_cast<std::size_t>(k);
      while (received_[i] < sent_ && at(received_[i]).step + delay_[i] <= step) {
        const T& arrived = at(received_[i]).value;
        current_.visit_scalars(
            arrived, [k](auto& mine, const auto& its) { set_lane(mine, k, lane(its, k)); });
        ++received_[i];
      }
    }
    return current_;
  }

  /// Takes over from another line, of equal delays there, the worlds of `mask` with what is under
  /// way to them at `step`. For the other worlds nothing is but what is sent then or later.
  void keep(const DelayLine& other, const mask_t<R>& mask, long step) {
    current_.visit_scalars(other.current_,
                           [&](R& mine, const R& its) { mine = select(mask, its, mine); });
    sent_ = other.sent_;
    const std::size_t next = other.sent_at(step) ? sent_ - 1 : sent_;
    std::size_t oldest = next;
    for (int k = 0; k < width; ++k) {
      const auto i = static_cast<std::size_t>(k);
      received_[i] = lane(mask, k) ? other.received_[i] : next;
      oldest = std::min(oldest, received_[i]);
    }
    for (std::size_t n = oldest; n < sent_; ++n) at(n) = other.at(n);
  }

 private:
  struct Entry {
    long step;
    T value;
  };
  bool sent_at(long step) const { return sent_ > 0 && at(sent_ - 1).step == step; }
  Entry& at(std::size_t number) { return queue_[number & (queue_.size() - 1)]; }
  const Entry& at(std::size_t number) const { return queue_[number & (queue_.size() - 1)]; }

  Delays delay_;
  T current_;
  std::vector<Entry> queue_;
  std::size_t sent_{0};
  std::array<std::size_t, static_cast<std::size_t>(width)> received_{};
};

}  // namespace multilift
