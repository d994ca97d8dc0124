// Random spatial flights under the energy-coupled law, alone or side by side.
#pragma once

#include <map>
#include <string>

#include "multilift/sim/spatial/rollout.hpp"
#include "random_spatial.hpp"

namespace multilift::spatial {

using Vector = Vec3<double>;

/// A world as flat numbers: a platform on n cables that lean outwards, of unlike vehicles, its law,
/// and what disturbs it.
struct Outing {
  Parameters<double> p;
  Formation<double> formation;
  State<double, PointMass<double>> start;
  WindParameters<double> wind;
  MotionCaptureParameters<double> capture;
  LinkParameters<double> link;
  double k_lambda, push, vehicle_distance;
  std::uint64_t seed;
};

inline Outing random_outing(Random& random, std::size_t n) {
  Outing w{random_parameters(random, n),
           Formation<double>(n),
           State<double, PointMass<double>>(n),
           {},
           {},
           {},
           random(0.05, 0.3),
           random(-5.0, 5.0),
           0.0,
           7};
  add_drag(random, w.p);
  w.p.payload_mass = random(1.0, 3.0);
  const double share = 1.0 / static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * share * static_cast<double>(i);
    const Vector out{std::cos(angle), std::sin(angle), 0.0};
    w.p.attachment[i] = 0.5 * out + Vector{0.0, 0.0, 0.1};
    w.p.cable_stiffness[i] = 2000.0;
    const Vector up{0.0, 0.0, share * w.p.payload_mass * w.p.gravity};
    w.formation.cable_force[i] = up + (n > 1 ? 0.3 * up.z : 0.0) * out;
    const double size = norm(w.formation.cable_force[i]);
    w.formation.offset[i] =
        w.p.attachment[i] + (w.p.cable_length[i] / size) * w.formation.cable_force[i];
  }
  w.formation.complete();
  w.start.payload.position = random_vector(random, 0.3);
  w.start.payload.position.z += random(0.0, 0.2);
  for (std::size_t i = 0; i < n; ++i) {
    w.start.vehicle[i].position = w.start.payload.position + w.formation.offset[i];
    // Some cables start slack.
    if (random(0.0, 1.0) < 0.3) w.start.vehicle[i].position.z -= random(0.02, 0.2);
  }
  w.wind.mean = random_vector(random, 2.0);
  w.wind.gust_speed = random(1.0, 5.0);
  w.capture.position_noise = w.capture.velocity_noise = 1e-3;
  w.capture.delay = 0.01;
  w.capture.dropout = 0.1;
  w.link.delay = 0.01;
  w.link.jitter = 0.01;
  w.link.loss = 0.1;
  return w;
}

struct Extras {
  bool capture{false}, moving{false}, ground{false};
};

/// The end of one world's run.
struct End {
  Status status{};
  double time{0.0};
  std::vector<double> state, metrics;
  std::map<std::string, double> audit;
};

inline Path winding_path() {
  Path path;
  path.pieces.push_back({0.0, {}});
  // A turn of a quarter while it goes by, to t^4.
  path.pieces[0].coordinate = {{{0.0, 0.0, 0.3, -0.1, 0.01},
                                {0.0, 0.0, -0.2, 0.05},
                                {0.0, 0.0, 0.1, -0.03},
                                {0.0, 0.0, 0.4, -0.1}}};
  path.end = 100.0;
  return path;
}

template <class R, class Cables>
std::vector<End> run_outings(const std::vector<Outing>& worlds, const Extras& extras,
                             const Timing& timing) {
  const std::size_t n = worlds[0].p.size();
  const auto number = [&](auto&& of) {
    R x(0.0);
    for (int k = 0; k < lanes_of<R>; ++k)
      set_lane(x, k, lane_scalar_t<R>(of(worlds[static_cast<std::size_t>(k)])));
    return x;
  };
  const auto vector = [&](auto&& of) {
    return Vec3<R>{number([&](const Outing& w) { return of(w).x; }),
                   number([&](const Outing& w) { return of(w).y; }),
                   number([&](const Outing& w) { return of(w).z; })};
  };
  std::vector<Parameters<double>> plants;
  std::vector<State<double, PointMass<double>>> starts;
  for (const Outing& w : worlds) plants.push_back(w.p), starts.push_back(w.start);
  const auto p = side_by_side<R>(plants);
  Formation<R> formation(n);
  for (std::size_t i = 0; i < n; ++i) {
    formation.offset[i] = vector([i](const Outing& w) { return w.formation.offset[i]; });
    formation.cable_force[i] = vector([i](const Outing& w) { return w.formation.cable_force[i]; });
  }
  formation.complete();
  WindParameters<R> wind;
  wind.mean = vector([](const Outing& w) { return w.wind.mean; });
  wind.gust_speed = number([](const Outing& w) { return w.wind.gust_speed; });
  std::optional<MotionCaptureParameters<R>> capture;
  LinkParameters<R> link;
  if (extras.capture) {
    const auto& c = worlds[0].capture;
    capture.emplace();
    capture->position_noise = R(c.position_noise), capture->velocity_noise = R(c.velocity_noise);
    capture->delay = R(c.delay), capture->dropout = R(c.dropout);
    link = {R(worlds[0].link.delay), R(worlds[0].link.jitter), R(worlds[0].link.loss)};
  }
  std::optional<Ground<R>> ground;
  if (extras.ground) ground.emplace().height = R(-0.2);
  SafetyParameters<R> safety;
  safety.vehicle_distance = number([](const Outing& w) { return w.vehicle_distance; });
  // Pushes on all bodies with edges on the grid.
  std::vector<Push<R>> pushes;
  const R push = number([](const Outing& w) { return w.push; });
  for (int body = -1; body < static_cast<int>(n); ++body)
    pushes.push_back({body,
                      {push, R(0.5) * push, -push},
                      {R(0.1) * push, R(0.2) * push, push},
                      {PushShape::half_sine, R(0.1), R(0.4), R(0.0), {}, {}}});
  typename EnergyCoupled<R>::Gains gains(n);
  gains.k_lambda = number([](const Outing& w) { return w.k_lambda; });
  for (std::size_t i = 0; i < n; ++i) {
    gains.feedback.k_p[i] = {R(8.0), R(9.0), R(12.0)};
    gains.feedback.k_d[i] = {R(6.0), R(7.0), R(9.0)};
    gains.feedback.gamma[i] = {R(1.0), R(1.5), R(2.0)};
    gains.feedback.k_i[i] = {R(0.5), R(0.5), R(0.5)};
  }
  EnergyCoupled<R> law(gains, p, timing.control_period());
  std::array<std::uint64_t, static_cast<std::size_t>(lanes_of<R>)> seeds{};
  for (std::size_t k = 0; k < seeds.size(); ++k) seeds[k] = worlds[k].seed;
  using Kind = IdealVehicles<R>;
  const Setup<R, Kind, Cables> setup{
      Plant<R>(p),
      p,
      Kind(typename Kind::Parameters(n)),
      ground,
      side_by_side<R, PointMass>(starts),
      formation,
      Reference<R>({}, R(0.3), extras.moving ? winding_path() : Path{}, formation),
      link,
      LimitParameters<R>(n),
      capture,
      wind,
      safety,
      pushes,
      {},
      timing,
      seeds};
  Rollout<R, Kind, Cables, DirectForce<R>> rollout(setup, law, DirectForce<R>{});
  std::vector<End> ends(worlds.size());
  const auto finish = [&](int k, Status status, const auto&... rest) {
    End& end = ends[static_cast<std::size_t>(k)];
    end.status = status;
    const auto take = [&](double time, const auto& x, const auto& metrics, const auto& audit) {
      end.time = time;
      end.state = numbers_of(x, k);
      metrics.report(k, [&](const Field&, double m) { end.metrics.push_back(m); });
      audit.visit([&](const Field& f, const R& m) { end.audit[f.name] = value(lane(m, k)); });
    };
    take(rest...);
  };
  rollout.run([](const auto&...) {}, finish);
  return ends;
}

}  // namespace multilift::spatial
