// A law under way without a simulation: its state, the targets it flies to and the limits of what
// it may ask for, stepped by whoever measures. From the same numbers it gives the forces that it
// gives in a run (sim/spatial/rollout.hpp), bit for bit.
#pragma once

#include <memory>
#include <utility>

#include "multilift/control/spatial/force_limits.hpp"
#include "multilift/control/spatial/law.hpp"

namespace multilift::spatial {

template <Real R>
class FlyingLaw {
 public:
  FlyingLaw(std::unique_ptr<Law<R>> law, const Reference<R>& reference,
            const LimitParameters<R>& limits, std::size_t n)
      : law_(std::move(law)),
        reference_(reference),
        limits_(limits),
        target_(n),
        asked_(n),
        force_(n),
        cut_(n) {}

  /// One control period from what is `measured`, whose time says where the targets are. Its
  /// `saturated` are the vehicles whose own control was at a limit since; forces that were cut here
  /// are added.
  void step(Measurement<R> measured) {
    reference_.at(measured.time, target_);
    for (std::size_t i = 0; i < cut_.size(); ++i)
      measured.saturated[i].is = measured.saturated[i].is | cut_[i].is;
    law_->step(measured, target_, asked_);
    force_ = asked_;
    limits_.cut(force_, cut_);
  }

  /// From here on, the targets of another reference; what the law has learnt stays.
  void follow(const Reference<R>& reference) { reference_ = reference; }

  const Reference<R>& reference() const { return reference_; }
  const Target<R>& target() const { return target_; }
  const std::vector<Vec3<R>>& asked() const { return asked_; }  // by the law, W, N
  const std::vector<Vec3<R>>& force() const { return force_; }  // within the limits
  const Masks<R>& cut() const { return cut_; }                  // whose force the limits changed
  const std::vector<Vec3<R>>& drag_estimate() const { return law_->drag_estimate(); }

 private:
  std::unique_ptr<Law<R>> law_;
  Reference<R> reference_;
  ForceLimits<R> limits_;
  Target<R> target_;
  std::vector<Vec3<R>> asked_, force_;
  Masks<R> cut_;
};

}  // namespace multilift::spatial
