// A flight that was measured, told as a run is: with the columns, metrics and audit of one.
//
// Nothing is integrated: bodies and rotors are given, row by row, and between rows everything
// changes linearly. Tensions are what the equations of motion ask of the cables that are long
// enough to be taut, without what draws a simulated cable back to its length: that would take a
// millimetre of noise for newtons. What the storage function does beside the audit's entries is
// what the model does not know of, and errors of the measurement.
#pragma once

#include <utility>

#include "multilift/sim/spatial/audit.hpp"
#include "multilift/sim/spatial/columns.hpp"

namespace multilift::spatial {

/// A measured cable that is this much too short is slack, m.
inline constexpr double measured_slack = 0.02;

template <Real R>
class Recorded {
 public:
  using V = Craft<R>;
  using X = State<R, V>;
  using D = Dynamics<R, Quadrotors<R>, RigidCables<R>>;

  Recorded(const Plant<R>& plant, const Quadrotors<R>& vehicles, const Formation<R>& formation,
           const Reference<R>& reference, const StorageGains<R>& gains)
      : plant_(plant),
        dynamics_(plant, vehicles, {}),
        reference_(reference),
        input_(plant.size()),
        outside_(plant.size()),
        row_(plant.size()),
        before_(plant.size()),
        audit_(plant, gains),
        metrics_(rest_directions(formation)),
        whole_(plant.size(), {R(0.0) < R(1.0)}) {
    outside_.pushes = false;
  }

  /// The next row, later than the last; `planned` is the reference's time then, `commanded` the
  /// law's force, W, N.
  template <class Record>
  void add(double time, double planned, const X& x, const std::vector<Vec3<R>>& commanded,
           const std::vector<Vec3<R>>& d_hat, Record&& record) {
    std::swap(row_, before_);
    row_.time = time;
    row_.x = x;
    row_.commanded = commanded;
    row_.d_hat = d_hat;
    reference_.at(planned, row_.target);
    evaluate();
    if (empty_) {
      audit_.begin(x, row_.target, d_hat);
    } else {
      const double h = time - before_.time;
      metrics_.update(sample(before_), h);
      audit_.next_step({&before_.target, &before_.target, &row_.target});
      audit_.restart();
      audit_.add(R(0.5 * h), Stage::start, before_.x, before_.now, outside_);
      audit_.add(R(0.5 * h), Stage::end, row_.x, row_.now, outside_);
      audit_.book();
      audit_.adapt(before_.d_hat);
    }
    empty_ = false;
    row_.storage = audit_.storage(x, row_.target);
    audit_.compare(row_.storage);
    metrics_.keep_clearance(clearance_of(plant_, row_.x, row_.now, whole_));
    record(sample(row_));
  }

  /// After the last row; a flight that did not last as long as planned has not settled.
  void finish(bool complete) {
    metrics_.update(sample(row_), 0.0);
    if (!complete) metrics_.cut_short(0);
  }

  const Metrics<R>& metrics() const { return metrics_; }
  const Audit<R, V>& audit() const { return audit_; }

 private:
  struct Row {
    double time{0.0};
    X x;
    Instant<R> now;
    Target<R> target;
    Masks<R> taut;
    std::vector<Vec3<R>> commanded, d_hat;
    R storage{0.0};

    explicit Row(std::size_t n) : x(n), now(n), target(n), taut(n) {}
  };

  Sample<R, V> sample(const Row& r) const {
    return {r.time, plant_, r.x, r.now, r.target, r.taut, r.commanded, r.d_hat, r.storage};
  }

  void evaluate() {
    Instant<R>& now = row_.now;
    dynamics_.evaluate(row_.x, input_, outside_, row_.taut, now);
    const std::vector<Cable<R>> measured = now.cable;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      row_.taut[i].is = plant_.cable_length[i] - R(measured_slack) < measured[i].length;
      now.cable[i].length = plant_.cable_length[i];
      now.cable[i].stretch_rate = R(0.0);
    }
    dynamics_.evaluate_tensions(row_.x, row_.taut, now);
    for (std::size_t turn = 0; turn < measured.size(); ++turn) {
      if (!drop_most_pushing(now.motion.tension, row_.taut, R(0.0) < R(1.0))) break;
      dynamics_.evaluate_tensions(row_.x, row_.taut, now);
    }
    now.cable = measured;
  }

  Plant<R> plant_;
  D dynamics_;
  Reference<R> reference_;
  std::vector<typename Quadrotors<R>::Input> input_;
  Surroundings<R> outside_;
  Row row_, before_;
  Audit<R, V> audit_;
  Metrics<R> metrics_;
  Masks<R> whole_;
  bool empty_{true};
};

}  // namespace multilift::spatial
