// Two thousand random flights with everything there is at once: both kinds of vehicles and of
// cables, slack phases and impacts, the floor, wind, noise, loss, pushes, breaks, collisions.
#include "check.hpp"
#include "multilift/model/spatial/quadrotor.hpp"
#include "random_outings.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

/// What the flights went through, all together.
struct Tally {
  double flights{0.0}, impacts{0.0}, slack_time{0.0}, stretched{0.0};
  double contacts{0.0},
      landings{0.0};  // samples in which a vehicle, the payload, touched the floor
  double collisions{0.0}, cuts{0.0};
};

void set_up(Random&, const Outing& w, IdealVehicles<double>::Parameters&,
            State<double, PointMass<double>>& start, bool) {
  start = w.start;
}

/// Rotors that lift twice the weight with the share of the load, running or not.
void set_up(Random& random, const Outing& w, Quadrotors<double>::Parameters& craft,
            State<double, Craft<double>>& start, bool running) {
  start.payload = w.start.payload;
  for (std::size_t i = 0; i < w.p.size(); ++i) {
    const double mass = w.p.vehicle_mass[i];
    craft.inertia[i] = {0.01 * mass, random(0.008, 0.013) * mass, 0.0175 * mass};
    craft.arm_length[i] = random(0.15, 0.3);
    craft.frame_angle[i] = random(0.0, 1.0) < 0.5 ? 0.0 : 0.25 * std::numbers::pi;
    craft.torque_ratio[i] = 0.016;
    craft.rotor_speed_max[i] = 1000.0;
    craft.rotor_time_constant[i] = random(0.015, 0.04);
    craft.rotor_drag[i] = random(0.0, 1e-4);
    const double weight = mass * w.p.gravity + w.formation.cable_force[i].z;
    craft.thrust_coefficient[i] = 2.0 * weight / 4.0 / square(craft.rotor_speed_max[i]);
    Craft<double>& v = start.vehicle[i];
    v.position = w.start.vehicle[i].position;
    v.attitude = random_attitude(random, 0.1);
    v.rotor_speed.fill(running ? std::sqrt(0.5) * craft.rotor_speed_max[i] : 0.0);
  }
}

template <class Kind>
auto actuation_of(const Outing& w, const typename Kind::Parameters& craft, double step) {
  if constexpr (std::is_same_v<Kind, Quadrotors<double>>) {
    std::vector<double> hover;
    for (std::size_t i = 0; i < w.p.size(); ++i)
      hover.push_back(w.p.vehicle_mass[i] * w.p.gravity + w.formation.cable_force[i].z);
    return Autopilots<double>(AutopilotParameters<double>(w.p.size()), craft, hover, 2, step);
  } else {
    return DirectForce<double>();
  }
}

/// One flight, and what must hold in all of them.
template <class Kind, class Cables>
void a_flight_keeps_its_laws(Random& random, std::size_t n, Tally& tally) {
  using V = typename Kind::State;
  const auto maybe = [&](double part) { return random(0.0, 1.0) < part; };
  Outing w = random_outing(random, n);
  w.p.cable_restitution = maybe(0.5) ? 0.0 : random(0.0, 1.0);
  const bool on_floor = maybe(0.4);
  typename Kind::Parameters craft(n);
  State<double, V> start(n);
  set_up(random, w, craft, start, !on_floor || maybe(0.5));
  std::optional<Ground<double>> ground;
  if (on_floor) {
    // Its feet a little above the floor, the vehicles above it or standing around it.
    ground.emplace();
    ground->height = start.payload.position.z - random(-0.05, 0.2);
    if (maybe(0.5)) {
      for (std::size_t i = 0; i < n; ++i) {
        const double stretch = 1.0 + 1.6 * w.p.cable_length[i];
        Vector& place = start.vehicle[i].position;
        place = start.payload.position + stretch * w.p.attachment[i];
        place.z = ground->height + ground->vehicle_clearance;
      }
    }
  }
  std::optional<MotionCaptureParameters<double>> capture;
  if (maybe(0.5)) {
    capture = w.capture;
    capture->freeze_start = 0.05, capture->freeze_duration = maybe(0.5) ? 0.03 : 0.0;
    capture->swap_start = 0.1, capture->swap_duration = maybe(0.3) ? 0.02 : 0.0;
  }
  if (!maybe(0.5)) w.wind.gust_speed = 0.0;
  const double step = 1e-3;
  const Timing timing{step, 200, 10, 1};
  std::vector<Push<double>> pushes;
  for (int body = -1; body < static_cast<int>(n); ++body)
    if (maybe(0.5))
      pushes.push_back({body,
                        random_vector(random, 20.0),
                        random_vector(random, 1.0),
                        {PushShape::pulse, 0.02, 0.1, 0.0, {}, {}}});
  std::vector<Happening> happenings;
  long cut_at = timing.steps + 1;
  std::size_t cut = n;
  if (maybe(0.3)) {
    cut = static_cast<std::size_t>(random(0.0, static_cast<double>(n)));
    cut_at = std::lround(random(0.0, 150.0));
    happenings.push_back({Failure::cable_cut, cut, 0, cut_at});
  }
  const auto someone = static_cast<std::size_t>(random(0.0, static_cast<double>(n)));
  if (maybe(0.3)) happenings.push_back({Failure::vehicle_lost, someone, 0, 50});
  if (maybe(0.3)) happenings.push_back({Failure::rotor_stopped, someone, 2, 30});
  SafetyParameters<double> safety;
  if (maybe(0.3)) safety.vehicle_distance = safety.cable_distance = 0.6;

  typename EnergyCoupled<double>::Gains gains(n);
  gains.k_lambda = w.k_lambda;
  for (std::size_t i = 0; i < n; ++i) {
    gains.feedback.k_p[i] = {8.0, 9.0, 12.0};
    gains.feedback.k_d[i] = {6.0, 7.0, 9.0};
    gains.feedback.gamma[i] = {1.0, 1.5, 2.0};
  }
  EnergyCoupled<double> law(gains, w.p, timing.control_period());
  const Setup<double, Kind, Cables> setup{
      Plant<double>(w.p),
      w.p,
      Kind(craft),
      ground,
      start,
      w.formation,
      Reference<double>({}, 0.3, maybe(0.5) ? winding_path() : Path{}, w.formation),
      maybe(0.5) ? w.link : LinkParameters<double>{},
      LimitParameters<double>(n),
      capture,
      w.wind,
      safety,
      pushes,
      happenings,
      timing,
      {w.seed}};
  using Actuation = decltype(actuation_of<Kind>(w, craft, step));
  Rollout<double, Kind, Cables, Actuation> rollout(setup, law, actuation_of<Kind>(w, craft, step));

  const auto record = [&](const Sample<double, V>& s, const auto&) {
    const auto& q = s.x.payload.attitude;
    CHECK_CLOSE(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1.0, 1e-14);
    if (ground) tally.landings += s.now.payload_contact.z > 0.0 ? 1.0 : 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double tension = s.now.motion.tension[i];
      CHECK(tension >= 0.0);
      const bool is_cut = i == cut && s.time > step * (static_cast<double>(cut_at) - 0.5);
      if (is_cut) CHECK(tension == 0.0);
      const double over = s.now.cable[i].length - w.p.cable_length[i];
      tally.stretched += over > 0.0 && tension > 0.0 ? 1.0 : 0.0;
      // A rigid cable is as long as it is, but for what waits for the next step where more than
      // most_events come in one, and what integration drifts before it is drawn back.
      if (Cables::rigid && !is_cut) CHECK(over < 1e-4);
      if (ground) tally.contacts += s.now.contact[i].z > 0.0 ? 1.0 : 0.0;
    }
  };
  const auto finish = [&](int, Status status, double time, const auto& x, const auto& metrics,
                          const auto& audit) {
    CHECK(status == Status::finished || status == Status::collision);
    CHECK(status != Status::finished || time == step * static_cast<double>(timing.steps));
    CHECK(status != Status::collision || safety.vehicle_distance > 0.0);
    for (const double number : numbers_of(x)) CHECK(std::isfinite(number));
    tally.flights += 1.0, tally.collisions += status == Status::collision ? 1.0 : 0.0;
    tally.cuts += time > step * static_cast<double>(cut_at) ? 1.0 : 0.0;
    metrics.report(0, [&](const Field& f, double m) {
      const std::string name = f.name;
      if (name == "impacts") tally.impacts += m;
      if (name == "slack_time") tally.slack_time += m;
    });
    double left = 0.0, stored = 0.0;
    audit.visit([&](const Field& f, const double& m) {
      const std::string name = f.name;
      if (name == "largest_integration_error") left = m;
      if (name == "storage_start") stored = m;
    });
    // A kink of the forces within a step costs that step its order: where elastic cables begin to
    // pull and rigid ones are caught 1e-7 m late, some 100 N each weighed by up to 30; a thousand
    // times as much where a body lands on the floor, whose spring is ten weights a centimetre.
    CHECK_CLOSE(left / (1.0 + std::fabs(stored)), 0.0, ground ? 0.05 : 1e-4);
  };
  rollout.run(record, finish);
}

}  // namespace

int main() {
  Random random(71);
  Tally tally;
  for (std::size_t k = 0; k < 500; ++k) {
    const std::size_t n = 1 + k % 8;
    a_flight_keeps_its_laws<IdealVehicles<double>, RigidCables<double>>(random, n, tally);
    a_flight_keeps_its_laws<IdealVehicles<double>, ElasticCables<double>>(random, n, tally);
    a_flight_keeps_its_laws<Quadrotors<double>, RigidCables<double>>(random, n, tally);
    a_flight_keeps_its_laws<Quadrotors<double>, ElasticCables<double>>(random, n, tally);
  }
  // They went through what they are there for.
  CHECK(tally.flights == 2000.0);
  CHECK(tally.impacts > 300.0);
  CHECK(tally.slack_time > 20.0);
  CHECK(tally.contacts > 1000.0 && tally.landings > 1000.0);
  CHECK(tally.stretched > 10000.0);
  CHECK(tally.collisions > 5.0);
  CHECK(tally.cuts > 100.0);
  return verdict();
}
