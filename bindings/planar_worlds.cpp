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
  Array2<double> q, q_dot;                    // worlds x 7
  Array2<double> measured_q, measured_q_dot;  // worlds x 7; not written to where sensors are ideal
  Array2<bool> saturated;                     // worlds x 2
  Array2<double> tension;                     // worlds x 2
  Array1<double> t;
  Array1<std::int8_t> status;  // planar Status, or running
  Array1<std::int8_t> culprit;
};

/// What worlds begin from; the arrays are the caller's, who changes them before a reset.
struct Numbers {
  Array2<const double> rows;
  Array1<const std::uint64_t> seeds;
  std::vector<PushShapes> pushes;
  Timing timing;
  std::size_t gains;  // how many of a row's columns are the law's
};

constexpr std::int8_t running_code = -1;

/// Worlds whatever their actuators and sensors.
class Worlds {
 public:
  virtual ~Worlds() = default;
  virtual void reset(const Array1<const bool>& mask) = 0;
  virtual void step(const Array2<const double>& forces, unsigned threads) = 0;
};

template <class Actuators, class Sensors>
class WorldsOf final : public Worlds {
 public:
  WorldsOf(Numbers numbers, View view) : numbers_(std::move(numbers)), view_(std::move(view)) {
    for (std::size_t first = 0; first < count(); first += width) {
      blocks_.push_back(at_start(first));
      show(first / width);
    }
  }

  /// Worlds of the mask begin again, from what the rows say now.
  void reset(const Array1<const bool>& mask) override {
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
      Block fresh = at_start(b * width);
      fresh.keep(blocks_[b], kept);
      blocks_[b] = std::move(fresh);
      show(b);
    }
  }

  void step(const Array2<const double>& forces, unsigned threads) override {
    if (forces.shape(0) != count() || forces.shape(1) != 4)
      throw std::invalid_argument("forces: four for each world");
    const double* u = forces.data();
    nb::gil_scoped_release unlock;
    // A thread takes some tens of microseconds to start: each gets work for several times that.
    constexpr std::size_t worthwhile = 400;  // blocks times integration steps
    const std::size_t work =
        blocks_.size() * static_cast<std::size_t>(numbers_.timing.control_steps);
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
  using Block = Stepping<R, Actuators, Sensors>;

  std::size_t count() const { return numbers_.rows.shape(0); }

  int lanes_in(std::size_t block) const {
    return static_cast<int>(std::min(width, count() - block * width));
  }

  Block at_start(std::size_t first) const {
    const std::size_t columns = numbers_.rows.shape(1);
    const int worlds = lanes_in(first / width);
    const Rows rows{numbers_.rows.data() + first * columns, columns, worlds};
    std::size_t column = 0;
    const planar::Plant<R> plant(unpack<planar::Parameters<R>>(rows, column));
    const planar::Plant<R> assumed(unpack<planar::Parameters<R>>(rows, column));
    column += numbers_.gains;
    const auto actuators = unpack<planar::ActuatorParameters<R>>(rows, column);
    const auto sensors = unpack<planar::SensorParameters<R>>(rows, column);
    const auto next = [&] { return rows.at<R>(column++); };
    const planar::State<R> start = start_from(next);
    column += 4;  // the goal
    auto pushes = pushes_from(numbers_.pushes, next);
    if constexpr (Actuators::ideal) {
      return {plant, start, std::move(pushes), Actuators(assumed, plant), Sensors()};
    } else {
      const Timing& timing = numbers_.timing;
      std::array<std::uint64_t, width> seeds{};
      for (int k = 0; k < MULTILIFT_LANES; ++k)
        seeds[static_cast<std::size_t>(k)] =
            numbers_.seeds.data()[first + static_cast<std::size_t>(std::min(k, worlds - 1))];
      return {
          plant, start, std::move(pushes), Actuators(actuators, assumed, plant, timing.step),
          Sensors(sensors, timing.control_steps, timing.step, seeds, start, pose_of(plant, start))};
    }
  }

  void advance(std::size_t b, const double* forces) {
    Block& block = blocks_[b];
    if (!any(block.running())) return;
    const Rows rows{forces + b * width * 4, 4, lanes_in(b)};
    block.advance({Vec2<R>{rows.at<R>(0), rows.at<R>(1)}, Vec2<R>{rows.at<R>(2), rows.at<R>(3)}},
                  numbers_.timing);
    show(b);
  }

  void show(std::size_t b) {
    const Block& block = blocks_[b];
    const auto& pose = block.pose();
    const auto& told = block.measured();
    show_seven(b, view_.q, join_seven(pose.vehicle, block.state().theta));
    show_seven(b, view_.q_dot, join_seven(pose.vehicle_velocity, block.state().theta_dot));
    if constexpr (!Actuators::ideal) {
      show_seven(b, view_.measured_q, join_seven(told.vehicle, told.theta));
      show_seven(b, view_.measured_q_dot, join_seven(told.vehicle_velocity, told.theta_dot));
    }
    for (int k = 0; k < lanes_in(b); ++k) {
      const std::size_t world = b * width + static_cast<std::size_t>(k);
      for (std::size_t i = 0; i < 2; ++i) {
        view_.tension.data()[world * 2 + i] = lane(block.tension()[i], k);
        view_.saturated.data()[world * 2 + i] = lane(told.saturated[i], k);
      }
      view_.t.data()[world] = numbers_.timing.step * lane(block.steps(), k);
      const auto [status, culprit] = block.ending(k);
      const bool runs = lane(block.running(), k);
      view_.status.data()[world] = runs ? running_code : static_cast<std::int8_t>(status);
      view_.culprit.data()[world] = static_cast<std::int8_t>(culprit);
    }
  }

  void show_seven(std::size_t b, const Array2<double>& array, const planar::Seven<R>& x) const {
    for (int k = 0; k < lanes_in(b); ++k)
      for (std::size_t i = 0; i < 7; ++i)
        array.data()[(b * width + static_cast<std::size_t>(k)) * 7 + i] = lane(x[i], k);
  }

  Numbers numbers_;
  View view_;
  std::vector<Block> blocks_;
};

std::unique_ptr<Worlds> make_worlds(const std::string& law, Array2<const double> rows,
                                    Array1<const std::uint64_t> seeds,
                                    const std::vector<PushTuple>& pushes, double step, long steps,
                                    long control_steps, bool ideal, Array2<double> q,
                                    Array2<double> q_dot, Array2<double> measured_q,
                                    Array2<double> measured_q_dot, Array2<bool> saturated,
                                    Array2<double> tension, Array1<double> t,
                                    Array1<std::int8_t> status, Array1<std::int8_t> culprit) {
  Numbers numbers{std::move(rows), std::move(seeds), shapes_from(pushes),
                  Timing{step, steps, control_steps, 1}, 0};
  bool known = false;
  planar::for_each_law<double>([&]<class Law>() {
    if (law != Law::name) return;
    known = true;
    numbers.gains = count_scalars<typename Law::Gains>();
    check_columns<typename Law::Gains>(numbers.rows.shape(1), numbers.pushes.size());
  });
  if (!known) throw std::invalid_argument("no compiled law is called '" + law + "'");
  View view{
      std::move(q),         std::move(q_dot),   std::move(measured_q), std::move(measured_q_dot),
      std::move(saturated), std::move(tension), std::move(t),          std::move(status),
      std::move(culprit)};
  if (ideal)
    return std::make_unique<WorldsOf<planar::IdealActuators<R>, planar::IdealSensors<R>>>(
        std::move(numbers), std::move(view));
  return std::make_unique<WorldsOf<planar::TestbedActuators<R>, planar::TestbedSensors<R>>>(
      std::move(numbers), std::move(view));
}

}  // namespace

void bind_planar_worlds(nb::module_& m) {
  nb::class_<Worlds>(m, "Worlds", "Worlds stepped from outside. Use multilift.Worlds.")
      .def(nb::new_(&make_worlds), nb::arg("law"), nb::arg("rows").noconvert(),
           nb::arg("seeds").noconvert(), nb::arg("pushes"), nb::arg("step"), nb::arg("steps"),
           nb::arg("control_steps"), nb::arg("ideal"), nb::arg("q").noconvert(),
           nb::arg("q_dot").noconvert(), nb::arg("measured_q").noconvert(),
           nb::arg("measured_q_dot").noconvert(), nb::arg("saturated").noconvert(),
           nb::arg("tension").noconvert(), nb::arg("t").noconvert(), nb::arg("status").noconvert(),
           nb::arg("culprit").noconvert(),
           "Keeps the arrays and writes to all but `rows` and `seeds`; to the measured ones only "
           "where actuators or sensors are not ideal.")
      .def("reset", &Worlds::reset, nb::arg("mask"),
           "Worlds of the mask begin again, from what the rows say now.")
      .def("step", &Worlds::step, nb::arg("forces"), nb::arg("threads"),
           "Holds each world's u1..u4, N, for one control period. Releases the GIL.");
}

}  // namespace multilift::bindings
