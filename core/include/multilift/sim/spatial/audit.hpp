// The energy audit of a run: does the storage function change as the theory says?
//
// The powers of energy.hpp are integrated with the stages of the Runge-Kutta step itself, and
// impacts of cables enter as the jumps they make, so what remains between the storage function and
// their sum is integration error and nothing else.
#pragma once

#include "multilift/model/spatial/energy.hpp"
#include "multilift/sim/rk4.hpp"

namespace multilift::spatial {

/// A stepper's ledger (stepper.hpp). `V` is what the vehicles keep.
template <Real R, class V>
class Audit {
 public:
  using X = State<R, V>;

  Audit(const Plant<R>& plant, const StorageGains<R>& gains)
      : plant_(plant), gains_(gains), coupling_(plant, gains), d_hat_(plant.size()) {}

  /// The targets at the start, the middle and the end of the step to come.
  struct Targets {
    const Target<R>* start;
    const Target<R>* middle;
    const Target<R>* end;
  };

  void begin(const X& x, const Target<R>& target, const std::vector<Vec3<R>>& d_hat) {
    d_hat_ = d_hat;
    start_ = end_ = storage(x, target);
  }

  R storage(const X& x, const Target<R>& target) const {
    return storage_function(plant_, gains_, coupling_, x, target, d_hat_);
  }

  Powers<R> powers(const X& x, const Instant<R>& now, const Surroundings<R>& outside,
                   const Target<R>& target) const {
    return powers_of(plant_, gains_, coupling_, x, now, outside, target, d_hat_);
  }

  /// The estimate jumps at a control instant.
  void adapt(const std::vector<Vec3<R>>& d_hat) {
    work_.adaptation +=
        estimation_energy(plant_, gains_, d_hat) - estimation_energy(plant_, gains_, d_hat_);
    d_hat_ = d_hat;
  }

  void next_step(const Targets& targets) { targets_ = targets; }

  // What the stepper tells.
  void restart() { tentative_ = {}; }
  MULTILIFT_INLINE void add(const R& weight, Stage stage, const X& x, const Instant<R>& now,
                            const Surroundings<R>& outside) {
    tentative_.add(weight, powers(x, now, outside, target_at(stage)));
  }
  void book() { work_.add(R(1.0), tentative_); }
  void before_jump(const X& x) { before_ = storage(x, *targets_.start); }
  void after_jump(const X& x) { work_.impact += storage(x, *targets_.start) - before_; }

  /// Compares with the storage function found at an instant.
  void compare(const R& storage) {
    end_ = storage;
    error_ = (end_ - start_) - work_.total();
    largest_error_ = max(largest_error_, abs(error_));
  }

  /// Calls v(Field, x) for each entry, J.
  template <class Visitor>
  void visit(Visitor&& v) const {
    v(Field{"storage_start", "J", Range::any, "storage function at the start"}, start_);
    v(Field{"storage_end", "J", Range::any, "storage function at the end"}, end_);
    Powers<R>::visit(work_, v);
    v(Field{"integration_error", "J", Range::any,
            "change of the storage function less the entries above"},
      error_);
    v(Field{"largest_integration_error", "J", Range::any, "its greatest size during the run"},
      largest_error_);
  }

 private:
  const Target<R>& target_at(Stage stage) const {
    return stage == Stage::start    ? *targets_.start
           : stage == Stage::middle ? *targets_.middle
                                    : *targets_.end;
  }

  Plant<R> plant_;
  StorageGains<R> gains_;
  Coupling<R> coupling_;
  std::vector<Vec3<R>> d_hat_;
  Targets targets_{};
  Powers<R> work_, tentative_;
  R start_{0.0}, end_{0.0}, before_{0.0}, error_{0.0}, largest_error_{0.0};
};

}  // namespace multilift::spatial
