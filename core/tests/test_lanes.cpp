// A world in a lane of a SIMD register is computed to the last bit as it is alone.
#include "check.hpp"
#include "random_planar.hpp"

using namespace multilift;
using namespace multilift::planar;

namespace {

constexpr int width = 4;
using Lane = Lanes<width>;

/// Four worlds side by side.
template <std::size_t N>
std::array<Lane, N> side_by_side(const std::array<Numbers<N>, width>& x) {
  std::array<Lane, N> lanes;
  for (std::size_t k = 0; k < N; ++k)
    for (int w = 0; w < width; ++w) lanes[k].set(w, x[static_cast<std::size_t>(w)][k]);
  return lanes;
}

template <std::size_t N>
void check_lane(const std::array<Lane, N>& lanes, int w, const Numbers<N>& expected) {
  for (std::size_t k = 0; k < N; ++k) CHECK(same_bits(lanes[k][w], expected[k]));
}

/// The state one Runge-Kutta step later under constant loads.
template <Real R>
std::array<R, 10> stepped(const std::array<R, 16>& plant, const std::array<R, 10>& state,
                          const std::array<R, 11>& loads) {
  const Plant<R> p = plant_of(plant);
  const auto rate_at = [&](Stage, const State<R>& s) {
    return motion(p, s, pose_of(p, s), loads_of(loads)).rate(s);
  };
  const State<R> s = state_of(state);
  return flat(rk4_step(s, rate_at(Stage::start, s), 0.01, rate_at));
}

/// Commands of a law that steps three times, saturated at times, on what follows from a state.
template <Real R>
std::array<R, 12> commands(const std::array<R, 16>& plant, const std::array<R, 10>& state,
                           const std::array<R, 25>& gains, const mask_t<R>& saturated) {
  using Law = EnergyCoupled<R>;
  const Plant<R> p = plant_of(plant);
  const State<R> s = state_of(state);
  Law law(unpack<typename Law::Gains>(gains.data()), p, {}, 0.01);
  Measurement<R> measured = truth(s, pose_of(p, s));
  measured.saturated = {saturated, !saturated};
  std::array<R, 12> result;
  for (std::size_t step = 0; step < 3; ++step) {
    const Command<R> u = law.step(measured);
    for (std::size_t i = 0; i < 2; ++i) {
      result[4 * step + 2 * i] = u[i].y;
      result[4 * step + 2 * i + 1] = u[i].z;
    }
  }
  return result;
}

void lanes_compute_a_doubles_bits(Random& random) {
  std::array<Numbers<16>, width> plants;
  std::array<Numbers<10>, width> states;
  std::array<Numbers<11>, width> loads;
  std::array<Numbers<25>, width> gains;
  for (std::size_t w = 0; w < width; ++w) {
    World world = random_world(random);
    for (std::size_t k = 2; k < 5; ++k) world.state[k] *= 5.0;  // angles of all quadrants
    plants[w] = world.plant, states[w] = world.state, loads[w] = world.loads;
    gains[w] = random.several<25>(0.01, 5.0);
  }
  const auto plant = side_by_side(plants);
  const auto state = side_by_side(states);
  const auto load = side_by_side(loads);
  const auto motion = flat(motion_of(plant, state, load));
  const auto next = stepped(plant, state, load);
  const auto saturated = state[0] < Lane(0.0);
  const auto u = commands(plant, state, side_by_side(gains), saturated);
  for (std::size_t w = 0; w < width; ++w) {
    const int lane = static_cast<int>(w);
    check_lane(motion, lane, flat(motion_of(plants[w], states[w], loads[w])));
    check_lane(next, lane, stepped(plants[w], states[w], loads[w]));
    check_lane(u, lane, commands(plants[w], states[w], gains[w], saturated[lane]));
  }
}

/// Draws and the functions of sensors and actuators.
void lanes_draw_a_doubles_bits(Random& random) {
  words_t<Lane> seeds{}, draws{};
  std::array<Numbers<2>, width> xs;
  for (std::size_t w = 0; w < width; ++w) {
    seeds[w] = static_cast<std::uint64_t>(random.several<1>(0.0, 0x1p63)[0]);
    draws[w] = static_cast<std::uint64_t>(random.several<1>(0.0, 0x1p40)[0]);
    xs[w] = random.several<2>(-40.0, 40.0);
  }
  const auto x = side_by_side(xs);
  const auto pair = normal_pair<Lane>(seeds, 5, draws);
  const auto angle = multilift::atan2(x[0], x[1]), power = multilift::exp(x[0]);
  const auto logarithm = multilift::log(abs(x[1]));
  for (std::size_t w = 0; w < width; ++w) {
    const int lane = static_cast<int>(w);
    const auto expected = normal_pair<double>(seeds[w], 5, draws[w]);
    CHECK(same_bits(pair[0][lane], expected[0]) && same_bits(pair[1][lane], expected[1]));
    CHECK(same_bits(angle[lane], multilift::atan2(xs[w][0], xs[w][1])));
    CHECK(same_bits(power[lane], multilift::exp(xs[w][0])));
    CHECK(same_bits(logarithm[lane], multilift::log(std::fabs(xs[w][1]))));
  }
}

}  // namespace

int main() {
  Random random(1);
  for (int n = 0; n < 500; ++n) lanes_compute_a_doubles_bits(random);
  for (int n = 0; n < 500; ++n) lanes_draw_a_doubles_bits(random);
  return verdict();
}
