// A delay line hands over the newest value among those sent long enough ago.
#include <algorithm>
#include <vector>

#include "check.hpp"
#include "random_planar.hpp"

using namespace multilift;

namespace {

struct Sent {
  long step;
  int value;
};

/// What the line carries: one number a world.
template <class R>
struct Number {
  R value;

  template <class F>
  void visit_scalars(const Number& other, F&& f) {
    f(value, other.value);
  }
};

/// By definition: the last of the values sent at or before step - delay, else the initial one.
int expected_at(long step, long delay, const std::vector<Sent>& sent, int initial) {
  int newest = initial;
  for (const Sent& one : sent)
    if (one.step + delay <= step) newest = one.value;
  return newest;
}

/// Random instants of sending and receiving, as many under way as fit.
template <std::size_t capacity>
void receives_what_the_definition_says(planar::Random& random, long delay) {
  constexpr int initial = -1;
  // Three worlds with delays of their own beside one, and one alone.
  using R = Lanes<4>;
  const std::array<long, 4> delays{delay, 0, 3, 2 * delay};
  // Receipts are as rare as they like: there is room for all of the capacity.
  DelayLine<R, Number<R>, capacity> many(delays, {R(initial)}, 1, 400);
  DelayLine<double, Number<double>, capacity> line({delay}, {initial}, 1, 400);
  std::vector<Sent> sent;
  std::size_t received = 0;  // how many of them have been taken out
  for (long step = 0; step < 400; ++step) {
    if (sent.size() - received < capacity && random(0.0, 1.0) < 0.7) {
      const int value = static_cast<int>(sent.size());
      line.send(step, {static_cast<double>(value)});
      many.send(step, {R(value)});
      sent.push_back({step, value});
    }
    if (random(0.0, 1.0) < 0.7) {
      const int expected = expected_at(step, delay, sent, initial);
      CHECK(line.receive(step).value == expected);
      CHECK(line.receive(step).value == expected);
      for (int k = 0; k < 4; ++k)
        CHECK(many.receive(step).value[k] ==
              expected_at(step, delays[static_cast<std::size_t>(k)], sent, initial));
      // The slowest world decides what is still under way.
      received =
          static_cast<std::size_t>(expected_at(step, std::max(2 * delay, 3L), sent, initial) + 1);
    }
  }
}

}  // namespace

int main() {
  planar::Random random(2);
  static_assert(DelayLine<double, Number<double>>::capacity() == 256);
  for (long delay = 0; delay < 30; ++delay) {
    receives_what_the_definition_says<1>(random, delay);
    receives_what_the_definition_says<7>(random, delay);
    receives_what_the_definition_says<256>(random, delay);
  }
  return verdict();
}
