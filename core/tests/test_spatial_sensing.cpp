// Motion capture and link: statistics of noise and loss, and what arrives when.
#include "check.hpp"
#include "multilift/sim/spatial/actuation.hpp"
#include "multilift/sim/spatial/motion_capture.hpp"
#include "random_spatial.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

using Vector = Vec3<double>;
using X = State<double, PointMass<double>>;
constexpr double h = 1e-3;

/// A state that tells the step it belongs to in each of its positions.
X state_at(long step, std::size_t n) {
  X x(n);
  const double t = static_cast<double>(step);
  x.payload.position = {t, t, t};
  for (std::size_t i = 0; i < n; ++i)
    x.vehicle[i] = {{t, static_cast<double>(i), t}, {static_cast<double>(i), t, t}};
  return x;
}

MotionCapture<double> capture_of(const MotionCaptureParameters<double>& p, long control_steps,
                                 std::size_t n) {
  Measurement<double> start(n);
  tell_truth(state_at(-1, n), start);
  return {p, control_steps, h, {9}, start};
}

/// Samples at their own period, each as late as said; before the first, the start.
void samples_arrive_late() {
  MotionCaptureParameters<double> p;
  p.period = 0.01, p.delay = 0.025;
  auto capture = capture_of(p, 1, 2);
  for (long k = 0; k < 200; ++k) {
    capture.observe(k, state_at(k, 2));
    const double seen = capture.read(k).payload.position.x;
    CHECK(seen == (k < 25 ? -1.0 : static_cast<double>((k - 25) / 10 * 10)));
  }
}

/// A stream that freezes repeats its last sample and goes on afterwards; swapped vehicles are
/// swapped for as long as said.
void streams_freeze_and_swap_for_their_time() {
  MotionCaptureParameters<double> p;
  p.freeze_start = 0.05, p.freeze_duration = 0.03;
  p.swap_start = 0.1, p.swap_duration = 0.02;
  auto capture = capture_of(p, 10, 3);
  for (long k = 0; k < 200; k += 10) {
    capture.observe(k, state_at(k, 3));
    const auto& m = capture.read(k);
    const bool frozen = 50 <= k && k < 80, swapped = 100 <= k && k < 120;
    CHECK(m.payload.position.x == static_cast<double>(frozen ? 40 : k));
    CHECK(m.vehicle[0].y == (swapped ? 1.0 : 0.0) && m.vehicle[1].y == (swapped ? 0.0 : 1.0));
    CHECK(m.vehicle_velocity[0].x == (swapped ? 1.0 : 0.0));
    CHECK(m.vehicle[2].y == 2.0);
  }
}

/// Standard deviations, means, independence; a lost sample leaves the one before.
void noise_and_loss_have_their_statistics() {
  MotionCaptureParameters<double> p;
  p.position_noise = 0.01, p.velocity_noise = 0.02, p.attitude_noise = 0.03, p.rate_noise = 0.04;
  auto capture = capture_of(p, 1, 2);
  X x(2);
  x.payload.attitude = normalised(Quaternion<double>{0.8, 0.2, -0.3, 0.4});
  constexpr long draws = 20000;
  // Sums of squares: positions, velocities, attitude, rate; and of products of unlike ones.
  std::array<double, 4> square_sum{};
  double mean = 0.0, across = 0.0, vehicles = 0.0;
  for (long k = 0; k < draws; ++k) {
    capture.observe(k, x);
    const auto& m = capture.read(k);
    const auto error = conjugate(x.payload.attitude) * m.payload.attitude;
    square_sum[0] += dot(m.vehicle[0], m.vehicle[0]) / 3.0;
    square_sum[1] += dot(m.payload.velocity, m.payload.velocity) / 3.0;
    square_sum[2] += 4.0 * (square(error.x) + square(error.y) + square(error.z)) / 3.0;
    square_sum[3] += dot(m.payload.rate, m.payload.rate) / 3.0;
    mean += m.payload.position.x;
    across += m.vehicle[0].x * m.vehicle[0].y;
    vehicles += m.vehicle[0].x * m.vehicle[1].x;
    CHECK_CLOSE(square(m.payload.attitude.w) + square(m.payload.attitude.x) +
                    square(m.payload.attitude.y) + square(m.payload.attitude.z),
                1.0, 1e-15 * 4.0);
  }
  const double count = draws, root = std::sqrt(count);
  for (std::size_t k = 0; k < 4; ++k) {
    const double sigma = 0.01 * static_cast<double>(k + 1);
    // Of 60000 numbers: sqrt(2/60000) = 0.6 %, five of them. Attitudes are normalised, which takes
    // off 0.03^2 at most.
    CHECK_CLOSE(square_sum[k] / count / square(sigma), 1.0, 0.03);
  }
  CHECK_CLOSE(mean / count, 0.0, 5.0 * 0.01 / root);
  CHECK_CLOSE(across / count, 0.0, 5.0 * 1e-4 / root);
  CHECK_CLOSE(vehicles / count, 0.0, 5.0 * 1e-4 / root);

  p = {};
  p.dropout = 0.2;
  auto lossy = capture_of(p, 1, 2);
  double lost = 0.0, last = -1.0;
  for (long k = 0; k < draws; ++k) {
    lossy.observe(k, state_at(k, 2));
    const double seen = lossy.read(k).payload.position.x;
    CHECK(seen == static_cast<double>(k) || seen == last);
    lost += seen == static_cast<double>(k) ? 0.0 : 1.0;
    last = seen;
  }
  CHECK_CLOSE(lost / count, 0.2, 5.0 * std::sqrt(0.2 * 0.8 / count));
}

ForceCommand<double> command_of(double z) {
  ForceCommand<double> command(1);
  command.force[0] = {0.0, 0.0, z};
  return command;
}

/// Commands come late by the delay and up to the jitter, uniformly in whole steps; some never; an
/// older one that comes after a newer one is ignored.
void commands_are_late_or_lost() {
  LinkParameters<double> link{0.005, 0.003, 0.1};
  constexpr long every = 10, draws = 20000;  // far enough apart not to overtake
  Masks<double> saturated(1);
  Transmission<double> line(link, LimitParameters<double>(1), h, every, {3}, command_of(0.0));
  std::array<double, 4> late{};
  double lost = 0.0;
  for (long k = 0; k < draws; ++k) {
    auto command = command_of(static_cast<double>(k + 1));
    line.send(k * every, command, saturated);
    long arrival = -1;
    for (long j = 0; j < every && arrival < 0; ++j)
      if (line.receive(k * every + j).force[0].z == static_cast<double>(k + 1)) arrival = j;
    const bool in_time = 5 <= arrival && arrival <= 8;
    CHECK(in_time || arrival < 0);
    if (in_time)
      late[static_cast<std::size_t>(arrival - 5)] += 1.0;
    else
      lost += 1.0;
  }
  const double count = draws;
  CHECK_CLOSE(lost / count, 0.1, 5.0 * std::sqrt(0.1 * 0.9 / count));
  for (const double part : late)
    CHECK_CLOSE(part / (count - lost), 0.25, 5.0 * std::sqrt(0.25 * 0.75 / count));

  link.loss = 0.0;
  Transmission<double> dense(link, LimitParameters<double>(1), h, 1, {3}, command_of(0.0));
  double newest = 0.0;
  for (long k = 0; k < 1000; ++k) {
    auto command = command_of(static_cast<double>(k + 1));
    dense.send(k, command, saturated);
    const double seen = dense.receive(k).force[0].z;
    CHECK(seen >= newest);
    CHECK(k < 8 || static_cast<double>(k + 1) - seen <= 8.0);
    newest = seen;
  }
}

/// Limits: no pull downwards, the tilt cut at the same uprightness, the size within its range.
void commands_keep_their_limits(Random& random) {
  LimitParameters<double> limits(1);
  limits.thrust_min[0] = 2.0, limits.thrust_max[0] = 15.0, limits.tilt_max[0] = 0.6;
  Transmission<double> line({}, limits, h, 1, {3}, command_of(5.0));
  Masks<double> saturated(1);
  for (long k = 0; k < 1000; ++k) {
    ForceCommand<double> command(1);
    const Vector asked = command.force[0] = random_vector(random, 12.0);
    line.send(k, command, saturated);
    const Vector f = line.receive(k).force[0];
    const double level = std::hypot(f.x, f.y), size = norm(f);
    CHECK(f.z >= 0.0 && level <= std::tan(0.6) * f.z * (1.0 + 1e-12));
    CHECK(2.0 - 1e-12 <= size && size <= 15.0 + 1e-12);
    CHECK_CLOSE(f.x * asked.y - f.y * asked.x, 0.0, 1e-12 * (1.0 + norm(asked) * size));
    CHECK(saturated[0].is == (norm(f - asked) > 1e-12));
  }
}

}  // namespace

int main() {
  Random random(53);
  samples_arrive_late();
  streams_freeze_and_swap_for_their_time();
  noise_and_loss_have_their_statistics();
  commands_are_late_or_lost();
  commands_keep_their_limits(random);
  return verdict();
}
