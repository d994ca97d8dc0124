// A spatial world in a lane of a SIMD register is computed to the last bit as it is alone, whatever
// its neighbours go through: events of their own, other numbers of them, or no finite numbers at
// all.
#include "check.hpp"
#include "random_outings.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

using Point = State<double, PointMass<double>>;

struct World {
  Parameters<double> p;
  Point start;
  std::vector<Vec3<double>> force;
};

World random_world(Random& random, std::size_t n, bool broken) {
  World world{random_parameters(random, n), Point(n), std::vector<Vec3<double>>(n)};
  add_drag(random, world.p);
  world.p.cable_restitution = random(0.0, 1.0);
  const bool slack = random(0.0, 1.0) < 0.5;
  world.start = random_state(random, world.p, 1.5, slack ? random(0.5, 0.9) : 1.0);
  for (std::size_t i = 0; i < n; ++i) {
    world.force[i] = random_vector(random, 5.0);
    world.force[i].z += 9.8 * (world.p.vehicle_mass[i] + 1.0);
  }
  if (broken) world.force[0].x = random(0.0, 1.0) < 0.5 ? required : unlimited;
  return world;
}

/// A flight as one line of numbers, an entry a number of the state and of each record.
template <class R, class C>
std::vector<R> fly(const Parameters<R>& p, const State<R, PointMass<R>>& start,
                   const std::vector<Vec3<R>>& force) {
  Ground<R> ground;
  ground.height = R(-3.0);
  Flight<R, C> flight(p, start, force, ground);
  std::vector<R> all;
  for (int record = 0; record < 20; ++record) {
    flight.advance(1e-3, 25);
    for (const R& tension : flight.observe().motion.tension) all.push_back(tension);
    zip([&](const R& number) { all.push_back(number); }, flight.x);
  }
  const auto& events = flight.stepper.events();
  all.insert(all.end(), {events.impacts, events.energy_lost, events.hardest_impulse});
  return all;
}

template <template <class> class C, int W>
double lanes_are_worlds(Random& random, std::size_t n, bool with_broken) {
  using L = Lanes<W>;
  std::vector<World> worlds;
  std::vector<Parameters<double>> plants;
  std::vector<Point> starts;
  std::vector<Vec3<L>> force(n);
  for (int k = 0; k < W; ++k) {
    worlds.push_back(random_world(random, n, with_broken && k % 4 == 1));
    const World& world = worlds.back();
    plants.push_back(world.p);
    starts.push_back(world.start);
    for (std::size_t i = 0; i < n; ++i)
      for (auto [all, one] : {std::pair{&force[i].x, world.force[i].x},
                              {&force[i].y, world.force[i].y},
                              {&force[i].z, world.force[i].z}})
        all->set(k, one);
  }
  const auto together =
      fly<L, C<L>>(side_by_side<L>(plants), side_by_side<L, PointMass>(starts), force);
  double impacts = 0.0;
  for (int k = 0; k < W; ++k) {
    if (with_broken && k % 4 == 1) continue;
    const World& world = worlds[static_cast<std::size_t>(k)];
    const auto alone = fly<double, C<double>>(world.p, world.start, world.force);
    std::size_t unlike = 0;
    for (std::size_t j = 0; j < alone.size(); ++j) unlike += together[j][k] != alone[j];
    CHECK(unlike == 0);
    impacts += alone[alone.size() - 3];
  }
  return impacts;
}

/// Neighbours differ, one collides, one diverges; every world has the bits that it has alone.
template <class Cables, template <class> class Kind, int W>
void rollouts_are_worlds(Random& random, std::size_t n) {
  std::vector<Outing> worlds;
  for (int k = 0; k < W; ++k) {
    Outing w = random_outing(random, n);
    w.seed = static_cast<std::uint64_t>(k);
    if (k % 4 == 1)
      w.vehicle_distance = 0.95 * norm(w.start.vehicle[0].position - w.start.vehicle[1].position);
    if (k % 4 == 2) w.k_lambda = 1e3;  // the loop blows up
    worlds.push_back(w);
  }
  const Timing timing{1e-3, 1000, 10, 1000000};
  const auto together = run_outings<Lanes<W>, Kind<Lanes<W>>>(worlds, {true, true, true}, timing);
  for (std::size_t k = 0; k < worlds.size(); ++k) {
    const auto alone = run_outings<double, Cables>({worlds[k]}, {true, true, true}, timing)[0];
    CHECK(together[k].status == alone.status && together[k].time == alone.time);
    CHECK(k % 4 != 2 || alone.status == Status::diverged);
    if (alone.status == Status::diverged) continue;
    CHECK(together[k].state == alone.state);
    for (std::size_t m = 0; m < alone.metrics.size(); ++m)
      CHECK(same_bits(together[k].metrics[m], alone.metrics[m]));
    for (const auto& [name, x] : alone.audit) CHECK(together[k].audit.at(name) == x);
  }
}

}  // namespace

int main() {
  Random random(29);
  double impacts = 0.0;
  for (std::size_t k = 0; k < 24; ++k) {
    const bool broken = k % 3 == 2;
    impacts += lanes_are_worlds<RigidCables, 4>(random, 1 + k % 6, broken);
    impacts += lanes_are_worlds<RigidCables, 8>(random, 1 + k % 6, broken);
    lanes_are_worlds<ElasticCables, 4>(random, 1 + k % 6, broken);
  }
  CHECK(impacts > 100.0);
  for (std::size_t n = 2; n <= 5; ++n) {
    rollouts_are_worlds<RigidCables<double>, RigidCables, 4>(random, n);
    rollouts_are_worlds<ElasticCables<double>, ElasticCables, 4>(random, n);
  }
  rollouts_are_worlds<RigidCables<double>, RigidCables, 8>(random, 3);
  return verdict();
}
