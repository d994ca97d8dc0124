// Values that arrive a fixed number of integration steps after they were sent, in order.
#pragma once

#include <array>
#include <cstddef>

namespace multilift {

template <class T, std::size_t Capacity = 256>
class DelayLine {
 public:
  /// `initial` is what arrives until the first value sent has travelled.
  DelayLine(long delay_steps, const T& initial) : delay_(delay_steps), current_(initial) {}

  static constexpr std::size_t capacity() { return Capacity; }

  /// At most Capacity values may be under way at once; scenarios are checked for that.
  void send(long step, const T& value) {
    queue_[(head_ + count_) % Capacity] = {step + delay_, value};
    ++count_;
  }

  /// The newest value that has arrived by `step`.
  const T& receive(long step) {
    while (count_ > 0 && queue_[head_].due <= step) {
      current_ = queue_[head_].value;
      head_ = (head_ + 1) % Capacity;
      --count_;
    }
    return current_;
  }

 private:
  struct Entry {
    long due;
    T value;
  };
  long delay_;
  T current_;
  std::array<Entry, Capacity> queue_{};
  std::size_t head_{0};
  std::size_t count_{0};
};

}  // namespace multilift
