// The two formulations of the planar plant, against each other on random worlds.
#include "check.hpp"
#include "random_planar.hpp"

using namespace multilift;
using namespace multilift::planar;

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

void both_formulations_agree(Random& random) {
  const World world = random_world(random);
  const auto p = plant_of(world.plant);
  const auto s = state_of(world.state);
  const auto pose = pose_of(p, s);
  const auto loads = loads_of(world.loads);
  const auto fast = motion(p, s, pose, loads);
  const auto reference = redundant_motion(p, join_seven(pose.vehicle, s.theta),
                                          join_seven(pose.vehicle_velocity, s.theta_dot), loads);
  CHECK(reference.regular);
  double fastest = 1.0;
  for (const double x : reference.q_ddot) fastest = std::fmax(fastest, std::fabs(x));
  const double mass = p.vehicle_mass[0] + p.vehicle_mass[1] + p.bar_mass;
  // Roundings times the condition number, below 150 for such worlds.
  const double round_off = 3.0 * 150.0 * eps;
  for (std::size_t k = 0; k < 3; ++k)
    CHECK_CLOSE(fast.theta_ddot[k], reference.q_ddot[4 + k], round_off * fastest);
  for (std::size_t i = 0; i < 2; ++i)
    CHECK_CLOSE(fast.tension[i], reference.tension[i], round_off * mass * (p.gravity + fastest));
  const Vec2<double> difference = fast.cable_force[0] - fast.cable_force[1];
  CHECK_CLOSE(difference.y, 2.0 * reference.mu.y, round_off * mass * (p.gravity + fastest));
  CHECK_CLOSE(difference.z, 2.0 * reference.mu.z, round_off * mass * (p.gravity + fastest));
}

}  // namespace

int main() {
  Random random(4);
  for (int n = 0; n < 5000; ++n) both_formulations_agree(random);
  return verdict();
}
