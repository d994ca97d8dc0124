// Values sent over a link that delays each by some time of its own and loses some; each world of a
// batch has its own delays. Who arrives after a newer one is ignored. delay_line.hpp is for values
// that keep their order.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "multilift/sim/steps.hpp"

namespace multilift {

/// T holds scalars R and offers `visit_scalars(other, f)`, which calls f(mine, its) for each pair.
template <class R, class T>
class LossyLine {
 public:
  static constexpr long lost = std::numeric_limits<long>::max();

  /// `initial` is what arrives until the first value sent has travelled. At most `capacity` values
  /// may be under way at once: all is allocated here.
  LossyLine(const StepsOf<R>& delay_steps, const T& initial, std::size_t capacity)
      : delay_(delay_steps), current_(initial), queue_(capacity, Entry{{}, initial}) {}

  /// `late` adds to the delay, or says that the value is lost.
  void send(long step, const T& value, const StepsOf<R>& late = {}) {
    Entry& entry = queue_[sent_ % queue_.size()];
    for (std::size_t i = 0; i < late.size(); ++i)
      entry.arrival[i] = late[i] == lost ? lost : step + delay_[i] + late[i];
    entry.value = value;
    ++sent_;
  }

  /// The newest value that has arrived by `step`, world by world.
  const T& receive(long step) {
    const auto before = received_;
    for (std::size_t j = oldest_still_wanted(); j < sent_; ++j) {
      const Entry& entry = queue_[j % queue_.size()];
      for (std::size_t i = 0; i < received_.size(); ++i)
        if (received_[i] <= j && entry.arrival[i] <= step) received_[i] = j + 1;
    }
    // Worlds that get the same value, as all do without jitter and loss, get it at once.
    const bool alike = std::ranges::all_of(received_, [&](auto r) { return r == received_[0]; });
    for (int k = 0; k < lanes_of<R>; ++k) {
      const auto i = static_cast<std::size_t>(k);
      if (received_[i] == before[i]) continue;
      const T& newest = queue_[(received_[i] - 1) % queue_.size()].value;
      if (alike) {
        current_.visit_scalars(newest, [](auto& mine, const auto& its) { mine = its; });
        break;
      }
      current_.visit_scalars(newest,
                             [k](auto& mine, const auto& its) { set_lane(mine, k, lane(its, k)); });
    }
    return current_;
  }

 private:
  /// The first value sent that some world has not seen overtaken and that is still kept.
  std::size_t oldest_still_wanted() const {
    const std::size_t kept = sent_ < queue_.size() ? 0 : sent_ - queue_.size();
    return std::max(std::ranges::min(received_), kept);
  }

  struct Entry {
    StepsOf<R> arrival;  // as steps
    T value;
  };
  StepsOf<R> delay_;
  T current_;
  std::vector<Entry> queue_;
  std::size_t sent_{0};
  std::array<std::size_t, static_cast<std::size_t>(lanes_of<R>)> received_{};
};

/// Room for what is under way on a link: values sent every `between` steps, each on its way for at
/// most `longest`.
inline std::size_t room_under_way(long longest, long between) {
  return static_cast<std::size_t>(longest / std::max(between, 1L) + 3);
}

/// The longest of the worlds' times, in steps.
template <std::size_t N>
long longest_of(const std::array<long, N>& steps) {
  return *std::max_element(steps.begin(), steps.end());
}

}  // namespace multilift
