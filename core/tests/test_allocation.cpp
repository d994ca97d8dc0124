// Cable forces from a wanted wrench: exact, of least sum of squares, without what no cable can do.
#include "multilift/control/spatial/allocation.hpp"

#include <random>

#include "check.hpp"
#include "multilift/scalar/lanes.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

using V = Vec3<double>;

std::mt19937 engine(1);

double draw() { return std::uniform_real_distribution<double>(-1.0, 1.0)(engine); }

V vector() { return {draw(), draw(), draw()}; }

std::vector<V> shared_out(const Allocation<double>& allocation, const Wrench<double>& wanted,
                          std::size_t n) {
  const auto parts = allocation.parts(wanted);
  std::vector<V> force(n);
  for (std::size_t i = 0; i < n; ++i) force[i] = allocation.force(parts, i);
  return force;
}

/// The forces make the wrench, but for its moment along `undriven` about the attachments' line, and
/// are orthogonal to all forces that make none.
void check(const std::vector<V>& attachment, const V& undriven, bool point) {
  const std::size_t n = attachment.size();
  const Allocation<double> allocation(attachment);
  const Wrench<double> wanted{vector(), vector()};
  const std::vector<V> force = shared_out(allocation, wanted, n);
  const Wrench<double> made = allocation.wrench(force);
  const double rounding = 1e-13;
  CHECK_CLOSE(norm(made.force - wanted.force), 0.0, rounding);
  V missing = made.moment - wanted.moment;
  if (point) {
    // All moment is that of the force at the one place.
    missing = made.moment - cross(attachment[0], wanted.force);
  } else {
    missing -= dot(missing, undriven) * undriven;
  }
  CHECK_CLOSE(norm(missing), 0.0, 20 * rounding);

  std::vector<V> other(n);
  for (V& f : other) f = vector();
  const std::vector<V> same = shared_out(allocation, allocation.wrench(other), n);
  double product = 0.0;
  for (std::size_t i = 0; i < n; ++i) product += dot(other[i] - same[i], force[i]);
  CHECK_CLOSE(product, 0.0, 20 * rounding);
}

void platforms_are_met_exactly() {
  for (std::size_t n = 3; n < 9; ++n)
    for (int draws = 0; draws < 50; ++draws) {
      std::vector<V> attachment(n);
      for (std::size_t i = 0; i < n; ++i) {
        const double angle = 6.28 * static_cast<double>(i) / static_cast<double>(n);
        attachment[i] = V{std::cos(angle), std::sin(angle), 0.0} + 0.3 * vector();
      }
      check(attachment, {}, false);
    }
}

void bars_are_met_but_for_the_moment_about_their_line() {
  for (std::size_t n = 2; n < 5; ++n)
    for (int draws = 0; draws < 50; ++draws) {
      const V direction = vector(), along = (1.0 / norm(direction)) * direction;
      const V middle = 0.1 * vector();
      std::vector<V> attachment(n);
      for (std::size_t i = 0; i < n; ++i)
        attachment[i] = middle + (static_cast<double>(i) + 0.2 * draw()) * along;
      check(attachment, along, false);
    }
}

void points_take_a_force_alone() {
  for (std::size_t n = 1; n < 5; ++n) {
    check(std::vector<V>(n), {}, true);
    check(std::vector<V>(n, V{0.0, 0.0, 0.1}), {}, true);
  }
}

void lanes_agree_with_worlds_of_their_own() {
  using L = Lanes<2>;
  std::vector<Vec3<L>> both(3);
  std::vector<V> platform(3), bar(3);
  for (std::size_t i = 0; i < 3; ++i) {
    platform[i] = vector();
    bar[i] = {static_cast<double>(i), 0.0, 0.0};
    set_lane(both[i].x, 0, platform[i].x), set_lane(both[i].x, 1, bar[i].x);
    set_lane(both[i].y, 0, platform[i].y), set_lane(both[i].y, 1, bar[i].y);
    set_lane(both[i].z, 0, platform[i].z), set_lane(both[i].z, 1, bar[i].z);
  }
  const Wrench<double> wanted{vector(), vector()};
  const Allocation<L> allocation(both);
  const auto parts = allocation.parts({{wanted.force.x, wanted.force.y, wanted.force.z},
                                       {wanted.moment.x, wanted.moment.y, wanted.moment.z}});
  for (int world = 0; world < 2; ++world) {
    const auto alone = shared_out(Allocation<double>(world == 0 ? platform : bar), wanted, 3);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3<L> f = allocation.force(parts, i);
      CHECK(same_bits(f.x[world], alone[i].x));
      CHECK(same_bits(f.y[world], alone[i].y));
      CHECK(same_bits(f.z[world], alone[i].z));
    }
  }
}

}  // namespace

int main() {
  platforms_are_met_exactly();
  bars_are_met_but_for_the_moment_about_their_line();
  points_take_a_force_alone();
  lanes_agree_with_worlds_of_their_own();
  return verdict();
}
