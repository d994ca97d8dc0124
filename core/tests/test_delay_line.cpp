// A delay line hands over the newest value among those sent long enough ago.
#include <vector>

#include "check.hpp"
#include "random_planar.hpp"

using namespace multilift;

namespace {

struct Sent {
  long step;
  int value;
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
  DelayLine<int, capacity> line(delay, initial);
  std::vector<Sent> sent;
  std::size_t received = 0;  // how many of them have been taken out
  for (long step = 0; step < 400; ++step) {
    if (sent.size() - received < capacity && random(0.0, 1.0) < 0.7) {
      const int value = static_cast<int>(sent.size());
      line.send(step, value);
      sent.push_back({step, value});
    }
    if (random(0.0, 1.0) < 0.7) {
      const int expected = expected_at(step, delay, sent, initial);
      CHECK(line.receive(step) == expected);
      CHECK(line.receive(step) == expected);
      received = static_cast<std::size_t>(expected + 1);
    }
  }
}

}  // namespace

int main() {
  planar::Random random(2);
  static_assert(DelayLine<int>::capacity() == 256);
  for (long delay = 0; delay < 30; ++delay) {
    receives_what_the_definition_says<1>(random, delay);
    receives_what_the_definition_says<7>(random, delay);
    receives_what_the_definition_says<256>(random, delay);
  }
  return verdict();
}
