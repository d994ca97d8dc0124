// What a spatial control law is given at each control instant, and what it must offer.
#pragma once

#include <optional>

#include "multilift/control/spatial/target.hpp"
#include "multilift/model/spatial/state.hpp"

namespace multilift::spatial {

/// What is known of the bodies at a control instant.
template <Real R>
struct Measurement {
  double time{0.0};                                // of the control instant, s
  std::vector<Vec3<R>> vehicle, vehicle_velocity;  // W
  RigidBody<R> payload;
  Masks<R> saturated;  // vehicle i's last command hit a limit

  explicit Measurement(std::size_t n) : vehicle(n), vehicle_velocity(n), saturated(n) {}

  /// Pairs every sensed number with another measurement's.
  template <class F>
  void visit_scalars(const Measurement& other, F&& f) {
    for (std::size_t i = 0; i < vehicle.size(); ++i) {
      zip(f, vehicle[i], other.vehicle[i]);
      zip(f, vehicle_velocity[i], other.vehicle_velocity[i]);
    }
    zip(f, payload, other.payload);
  }
};

/// The gains of a law that its storage function is made of; all zero for a law that has none, which
/// turns the audit into that of the mechanical energy.
template <Real R>
struct StorageGains {
  R k_lambda{0.0};
  std::optional<R> lead;  // of the momentum-coupled law, whose k_lambda is 0 here
  std::vector<Vec3<R>> k_p, k_d, inverse_gamma;

  explicit StorageGains(std::size_t n) : k_p(n), k_d(n), inverse_gamma(n) {}
};

/// A control law: the forces that the vehicles' rotors shall exert, W, N, gravity included. One law
/// is one file with a `Gains` struct that describes itself, and one line in laws.hpp.
template <Real R>
class Law {
 public:
  virtual ~Law() = default;

  /// Fills `force`, one entry a vehicle.
  virtual void step(const Measurement<R>& measured, const Target<R>& target,
                    std::vector<Vec3<R>>& force) = 0;

  virtual StorageGains<R> storage_gains() const { return StorageGains<R>(drag_estimate_.size()); }

  /// The law's drag estimate, N s/m; zeros where it has none.
  const std::vector<Vec3<R>>& drag_estimate() const { return drag_estimate_; }

 protected:
  explicit Law(std::size_t n) : drag_estimate_(n) {}

  std::vector<Vec3<R>> drag_estimate_;
};

}  // namespace multilift::spatial
