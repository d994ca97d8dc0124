// Wind: a steady part, and gusts after Dryden's low-altitude model (MIL-F-8785C).
//
// The gusts' filters are driven at the wind's mean speed past the bodies, since these stand in it
// rather than fly through it; along the wind a filter of first order, across and up of second. All
// bodies meet the same gust.
#pragma once

#include "multilift/fields.hpp"
#include "multilift/math/normal.hpp"
#include "multilift/math/vec3.hpp"

namespace multilift::spatial {

template <Real R>
struct WindParameters {
  Vec3<R> mean{};
  R gust_speed{0.0};
  R altitude{6.0};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"mean", "m/s", Range::any, "steady wind: the air's velocity, x east, y north, z up"},
      self.mean);
    v(Field{"gust_speed", "m/s", Range::non_negative,
            "wind speed at 6 m that the gusts belong to (W20 of MIL-F-8785C); 0: no gusts"},
      self.gust_speed);
    v(Field{"altitude", "m", Range::positive, "height above ground that sets the gusts' scales"},
      self.altitude);
  }
};

template <Real R>
class Wind {
 public:
  using Seeds = std::array<std::uint64_t, static_cast<std::size_t>(lanes_of<R>)>;

  Wind(const WindParameters<R>& p, double step, const Seeds& seeds) : p_(p), seeds_(seeds) {
    for (int k = 0; k < lanes_of<R>; ++k) set_up(k, step);
  }

  /// The air's velocity during integration step `step`, which must count up from 0; W, m/s.
  Vec3<R> at(long step) {
    if (!any(R(0.0) < p_.gust_speed)) return p_.mean;
    for (int k = 0; k < lanes_of<R>; ++k)
      if (value(lane(p_.gust_speed, k)) > 0.0) advance(k, static_cast<std::uint64_t>(step));
    return p_.mean + gust_;
  }

 private:
  static constexpr std::uint64_t stream = (std::uint64_t{1} << 32) + 2;

  struct Filter {
    double keep{0.0};   // of the state after a step
    double sigma{0.0};  // of the output, m/s
    double x{0.0}, y{0.0};
  };
  struct Gust {
    double along_x{1.0}, along_y{0.0};  // horizontal direction of the mean wind
    std::array<Filter, 3> axis;         // along, across, up
  };

  void set_up(int k, double step) {
    constexpr double foot = 0.3048;
    constexpr double least_speed = 0.5;  // m/s, at which gusts drift by in calm air
    Gust& gust = gusts_[static_cast<std::size_t>(k)];
    const Vec3<double> mean{value(lane(p_.mean.x, k)), value(lane(p_.mean.y, k)),
                            value(lane(p_.mean.z, k))};
    const double level = std::hypot(mean.x, mean.y);
    if (level > 0.0) gust.along_x = mean.x / level, gust.along_y = mean.y / level;
    const double speed = std::fmax(std::hypot(level, mean.z), least_speed);
    const double height = value(lane(p_.altitude, k)) / foot;
    const double shape = 0.177 + 0.000823 * height;
    const double up = 0.1 * value(lane(p_.gust_speed, k));
    const double side = up / std::pow(shape, 0.4);
    const double long_scale = height / std::pow(shape, 1.2) * foot;
    const std::array<double, 3> scale{long_scale, long_scale, height * foot};
    const std::array<double, 3> sigma{side, side, up};
    for (std::size_t a = 0; a < 3; ++a) {
      // The wind blew before the run began: x and y start as they are at any other time, their
      // variances 1/2 and 1/4 and their covariance 1/4 (x's is 1 along the wind, which lacks y).
      const auto [n0, n1] = normal_pair<double>(seeds_[static_cast<std::size_t>(k)], stream + 2, a);
      const double x = (a == 0 ? 1.0 : std::numbers::sqrt2 / 2.0) * n0;
      const double y = 0.5 * x + std::numbers::sqrt2 / 4.0 * n1;
      gust.axis[a] = {std::exp(-step * speed / scale[a]), sigma[a], x, y};
    }
  }

  void advance(int k, std::uint64_t draw) {
    const auto i = static_cast<std::size_t>(k);
    Gust& gust = gusts_[i];
    const auto [n0, n1] = normal_pair<double>(seeds_[i], stream, draw);
    const auto [n2, unused] = normal_pair<double>(seeds_[i], stream + 1, draw);
    static_cast<void>(unused);
    const std::array<double, 3> noise{n0, n1, n2};
    std::array<double, 3> out{};
    for (std::size_t a = 0; a < 3; ++a) {
      Filter& f = gust.axis[a];
      const double fresh = std::sqrt(1.0 - f.keep * f.keep);
      // White noise through 1/(1 + T s), of variance 1/2 for the second-order axes, 1 for the
      // first.
      f.y = f.keep * f.y + (1.0 - f.keep) * f.x;
      f.x = f.keep * f.x + (a == 0 ? 1.0 : std::numbers::sqrt2 / 2.0) * fresh * noise[a];
      constexpr double root3 = std::numbers::sqrt3;
      out[a] = f.sigma * (a == 0 ? f.x : root3 * f.x + (1.0 - root3) * f.y);
    }
    set_lane(gust_.x, k, lane_scalar_t<R>(gust.along_x * out[0] - gust.along_y * out[1]));
    set_lane(gust_.y, k, lane_scalar_t<R>(gust.along_y * out[0] + gust.along_x * out[1]));
    set_lane(gust_.z, k, lane_scalar_t<R>(out[2]));
  }

  WindParameters<R> p_;
  Seeds seeds_;
  std::array<Gust, static_cast<std::size_t>(lanes_of<R>)> gusts_{};
  Vec3<R> gust_;
};

}  // namespace multilift::spatial
