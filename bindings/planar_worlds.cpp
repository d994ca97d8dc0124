// Many worlds that are stepped from outside: forces in, one control period, states out.
//
// Compiled once for each instruction set, like planar_batch.cpp.
#include <nanobind/stl/unique_ptr.h>

#include <atomic>
#include <memory>
#include <thread>

#include "planar_rows.hpp"

namespace multilift::bindings {

namespace {

using planar::join_seven;
using planar::Stepping;

using R = Lanes<MULTILIFT_LANES>;
constexpr auto width = static_cast<std::size_t>(MULTILIFT_LANES);

/// Where worlds show themselves; the arrays are the caller's and are kept alive.
struct View {
  Array2<double> q, q_dot;  // worlds x 7
  Array2<double> tension;   // worlds x 2
  Array1<double> t;
  Array1<std::int8_t> status;  // planar Status, or running
  Array1<std::int8_t> culprit;
};

constexpr std::int8_t running_code = -1;

class Worlds {
 public:
  Worlds(const std::string& law, Array2<const double> rows, const std::vector<PushTuple>& pushes,
         const Timing& timing, View view)
      : rows_(std::move(rows)),
        shapes_(shapes_from(pushes)),
        timing_(timing),
        view_(std::move(view)) {
    bool known = false;
    planar::for_each_law<double>([&]<class Law>() {
      if (law != Law::name) return;
      known = true;
      gain_count_ = count_scalars<typename Law::Gains>();
      check_columns<typename Law::Gains>(rows_.shape(1), shapes_.size());
    });
    if (!known) throw std::invalid_argument("no compiled law is called '" + law + "'");
    for (std::size_t first = 0; first < count(); first += width) {
      blocks_.push_back(at_start(first));
      show(first / width);
    }
  }

  /// Worlds of the mask begin again, from what the rows say now.
  void reset(const Array1<const bool>& mask) {
    if (mask.shape(0) != count()) throw std::invalid_argument("one truth value for each world");
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      mask_t<R> kept{};
      bool touched = false;
      for (int k = 0; k < MULTILIFT_LANES; ++k) {
        // Lanes without a world of their own do as the last world.
        const int twin = std::min(k, lanes_in(b) - 1);
        const bool begins = mask.data()[b * width + static_cast<std::size_t>(twin)];
        touched = touched || begins;
        set_lane(kept, k, !begins);
      }
      if (!touched) continue;
      Stepping<R> fresh = at_start(b * width);
      fresh.keep(blocks_[b], kept);
      blocks_[b] = std::move(fresh);
      show(b);
    }
  }

  void step(const Array2<const double>& forces, unsigned threads) {
    if (forces.shape(0) != count() || forces.shape(1) != 4)
      throw std::invalid_argument("forces: four for each world");
    const double* u = forces.data();
    nb::gil_scoped_release unlock;
    // A thread takes some tens of microseconds to start: each gets work for several times that.
    constexpr std::size_t worthwhile = 400;  // blocks times integration steps
    const std::size_t work = blocks_.size() * static_cast<std::size_t>(timing_.control_steps);
    const std::size_t helpers = std::min<std::size_t>(threads, work / worthwhile + 1) - 1;
    constexpr std::size_t chunk = 16;  // blocks
    std::atomic<std::size_t> next{0};
    const auto run = [&] {
      for (;;) {
        const std::size_t first = next.fetch_add(chunk);
        if (first >= blocks_.size()) return;
        for (std::size_t b = first; b < std::min(first + chunk, blocks_.size()); ++b) advance(b, u);
      }
    };
    std::vector<std::thread> pool;
    for (std::size_t k = 0; k < helpers; ++k) pool.emplace_back(run);
    run();
    for (std::thread& thread : pool) thread.join();
  }

 private:
  std::size_t count() const { return rows_.shape(0); }

  int lanes_in(std::size_t block) const {
    return static_cast<int>(std::min(width, count() - block * width));
  }

  Stepping<R> at_start(std::size_t first) const {
    const Rows rows{rows_.data() + first * rows_.shape(1), rows_.shape(1), lanes_in(first / width)};
    std::size_t column = 0;
    const planar::Plant<R> plant(unpack<planar::Parameters<R>>(rows, column));
    const planar::Plant<R> assumed(unpack<planar::Parameters<R>>(rows, column));
    column += gain_count_ + count_scalars<planar::ActuatorParameters<R>>() +
              count_scalars<planar::SensorParameters<R>>();
    const auto next = [&] { return rows.at<R>(column++); };
    const planar::State<R> start = start_from(next);
    column += 4;  // the goal
    return {plant, assumed, start, pushes_from(shapes_, next)};
  }

  void advance(std::size_t b, const double* forces) {
    Stepping<R>& block = blocks_[b];
    if (!any(block.running())) return;
    const Rows rows{forces + b * width * 4, 4, lanes_in(b)};
    block.advance({Vec2<R>{rows.at<R>(0), rows.at<R>(1)}, Vec2<R>{rows.at<R>(2), rows.at<R>(3)}},
                  timing_);
    show(b);
  }

  void show(std::size_t b) {
    const Stepping<R>& block = blocks_[b];
    const auto& pose = block.pose();
    const auto q = join_seven(pose.vehicle, block.state().theta);
    const auto q_dot = join_seven(pose.vehicle_velocity, block.state().theta_dot);
    for (int k = 0; k < lanes_in(b); ++k) {
      const std::size_t world = b * width + static_cast<std::size_t>(k);
      for (std::size_t i = 0; i < 7; ++i) {
        view_.q.data()[world * 7 + i] = lane(q[i], k);
        view_.q_dot.data()[world * 7 + i] = lane(q_dot[i], k);
      }
      for (std::size_t i = 0; i < 2; ++i)
        view_.tension.data()[world * 2 + i] = lane(block.tension()[i], k);
      view_.t.data()[world] = timing_.step * lane(block.steps(), k);
      const auto [status, culprit] = block.ending(k);
      const bool runs = lane(block.running(), k);
      view_.status.data()[world] = runs ? running_code : static_cast<std::int8_t>(status);
      view_.culprit.data()[world] = static_cast<std::int8_t>(culprit);
    }
  }

  Array2<const double> rows_;
  std::vector<PushShapes> shapes_;
  Timing timing_;
  View view_;
  std::size_t gain_count_{0};
  std::vector<Stepping<R>> blocks_;
};

std::unique_ptr<Worlds> make_worlds(const std::string& law, Array2<const double> rows,
                                    const std::vector<PushTuple>& pushes, double step, long steps,
                                    long control_steps, Array2<double> q, Array2<double> q_dot,
                                    Array2<double> tension, Array1<double> t,
                                    Array1<std::int8_t> status, Array1<std::int8_t> culprit) {
  return std::make_unique<Worlds>(law, std::move(rows), pushes,
                                  Timing{step, steps, control_steps, 1},
                                  View{std::move(q), std::move(q_dot), std::move(tension),
                                       std::move(t), std::move(status), std::move(culprit)});
}

}  // namespace

void bind_planar_worlds(nb::module_& m) {
  nb::class_<Worlds>(m, "Worlds", "Worlds stepped from outside. Use multilift.Worlds.")
      .def(nb::new_(&make_worlds), nb::arg("law"), nb::arg("rows").noconvert(), nb::arg("pushes"),
           nb::arg("step"), nb::arg("steps"), nb::arg("control_steps"), nb::arg("q").noconvert(),
           nb::arg("q_dot").noconvert(), nb::arg("tension").noconvert(), nb::arg("t").noconvert(),
           nb::arg("status").noconvert(), nb::arg("culprit").noconvert(),
           "Keeps the arrays and writes to all but `rows`.")
      .def("reset", &Worlds::reset, nb::arg("mask"),
           "Worlds of the mask begin again, from what the rows say now.")
      .def("step", &Worlds::step, nb::arg("forces"), nb::arg("threads"),
           "Holds each world's u1..u4, N, for one control period. Releases the GIL.");
}

}  // namespace multilift::bindings
