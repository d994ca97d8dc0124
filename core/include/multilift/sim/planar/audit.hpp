// The energy audit of a run: does the storage function change as the theory says?
//
// The powers of energy.hpp are integrated with the stages of the Runge-Kutta step itself, so what
// remains between the storage function and their sum is integration error and nothing else.
#pragma once

#include "multilift/model/planar/common_motion.hpp"

namespace multilift::planar {

template <Real R>
class Audit {
 public:
  void begin(const R& storage) { start_ = end_ = storage; }

  /// Energy that entered between two instants, J.
  void add(const Powers<R>& work) { work_ = work_ + work; }

  /// A jump of the estimation energy at a control instant, J.
  void add_adaptation(const R& jump) { work_.adaptation += jump; }

  /// Compares with the storage function found at an instant.
  void compare(const R& storage) {
    end_ = storage;
    error_ = (end_ - start_) - work_.total();
    largest_error_ = max(largest_error_, abs(error_));
  }

  /// Calls v(Field, x) for each entry, J, x with its derivatives where R has them.
  template <class V>
  void visit(V&& v) const {
    v(Field{"storage_start", "J", Range::any, "storage function (49) at the start"}, start_);
    v(Field{"storage_end", "J", Range::any, "storage function (49) at the end"}, end_);
    Powers<R>::visit(work_, v);
    v(Field{"integration_error", "J", Range::any,
            "change of the storage function less the entries above"},
      error_);
    v(Field{"largest_integration_error", "J", Range::any, "its greatest size during the run"},
      largest_error_);
  }

  /// Calls v(Field, value) for each entry, J.
  template <class V>
  void report(V&& v) const {
    visit([&](const Field& field, const R& x) { v(field, value(x)); });
  }

  /// World k's audit on its own.
  Audit<lane_scalar_t<R>> world(int k) const {
    Audit<lane_scalar_t<R>> one;
    one.start_ = lane(start_, k);
    one.end_ = lane(end_, k);
    one.error_ = lane(error_, k);
    one.largest_error_ = lane(largest_error_, k);
    one.work_ = {lane(work_.dissipation, k), lane(work_.internal, k),   lane(work_.push, k),
                 lane(work_.actuation, k),   lane(work_.adaptation, k), lane(work_.reference, k)};
    return one;
  }

 private:
  template <Real>
  friend class Audit;

  R start_{0.0}, end_{0.0}, error_{0.0}, largest_error_{0.0};
  Powers<R> work_;
};

}  // namespace multilift::planar
