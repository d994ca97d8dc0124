// Worlds by the million: the planar rollout over SIMD lanes and threads.
//
// This file is compiled once for each instruction set, each time as an extension module of its own,
// so that no inline function of one can stand in for another's. The arithmetic is the same in all
// of them, and so are the bits of the results.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "multilift/multilift.hpp"

namespace multilift::bindings {

namespace {

namespace nb = nanobind;
using planar::Body;
using planar::Push;
using planar::State;
using planar::Timing;

using R = Lanes<MULTILIFT_LANES>;

template <class T>
using Array1 = nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <class T>
using Array2 = nb::ndarray<T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// What worlds of one batch share about a push; force, torque and times are each world's own.
struct PushShapes {
  Body body;
  PushShape shape;
  std::vector<double> sample_times, sample_values;
};

/// The problem and where its results go; every array is the caller's.
struct Job {
  // Row k: plant | assumed plant | gains | actuators | sensors | free coordinates (10) | goal (4) |
  // for each push: force (2), torque, start, duration, frequency.
  const double* rows;
  std::size_t columns;
  const std::uint64_t* seeds;
  std::size_t worlds;
  std::vector<PushShapes> pushes;
  Timing timing;
  bool ideal;
  double* metrics;
  double* audit;
  double* final_state;  // worlds x 10
  double* end_time;
  std::int8_t* status;
  std::int8_t* culprit;
  double* samples;  // worlds x sample_rows x sample_columns, or null
  std::size_t metric_count, audit_count, sample_rows, sample_columns;
};

template <class Law>
class Kernel {
 public:
  explicit Kernel(const Job& job) : job_(job) {}

  void run(std::size_t first) const {
    const std::size_t left = job_.worlds - first;
    const int count = static_cast<int>(left < MULTILIFT_LANES ? left : MULTILIFT_LANES);
    const Rows rows{job_.rows + first * job_.columns, job_.columns, count};
    std::size_t column = 0;
    const planar::Plant<R> plant(unpack<planar::Parameters<R>>(rows, column));
    const planar::Plant<R> assumed(unpack<planar::Parameters<R>>(rows, column));
    const auto gains = unpack<typename Law::Gains>(rows, column);
    const auto actuator_parameters = unpack<planar::ActuatorParameters<R>>(rows, column);
    const auto sensor_parameters = unpack<planar::SensorParameters<R>>(rows, column);
    const auto next = [&] { return rows.at<R>(column++); };
    State<R> start;
    start.bar = {next(), next()};
    for (R& x : start.theta) x = next();
    start.bar_velocity = {next(), next()};
    for (R& x : start.theta_dot) x = next();
    planar::PerAxis<R> goal;
    for (Vec2<R>& g : goal) g = {next(), next()};
    std::vector<Push<R>> pushes;
    for (const PushShapes& shapes : job_.pushes) {
      Push<R> push{shapes.body, {}, R(0.0), {}};
      push.force = {next(), next()};
      push.torque = next();
      const R begin = next(), duration = next(), frequency = next();
      push.profile = {shapes.shape,        begin, duration, frequency, shapes.sample_times,
                      shapes.sample_values};
      pushes.push_back(std::move(push));
    }

    Law law(gains, assumed, goal, job_.timing.control_period());
    std::array<std::size_t, MULTILIFT_LANES> recorded{};
    const auto record = [&](const planar::Sample<R>& sample, const mask_t<R>& whose) {
      if (job_.samples == nullptr) return;
      for (int k = 0; k < count; ++k) {
        const auto i = static_cast<std::size_t>(k);
        if (!lane(whose, k) || recorded[i] == job_.sample_rows) continue;
        double* out =
            job_.samples + ((first + i) * job_.sample_rows + recorded[i]++) * job_.sample_columns;
        visit_columns(sample, [&](const Field&, const R& x) { *out++ = lane(x, k); });
      }
    };
    if (job_.ideal) {
      planar::IdealActuators<R> actuators(assumed, plant);
      planar::IdealSensors<R> sensors;
      store(first, count,
            planar::rollout<true>(plant, start, goal, law, actuators, sensors, pushes, job_.timing,
                                  record));
    } else {
      std::array<std::uint64_t, MULTILIFT_LANES> seeds{};
      for (int k = 0; k < count; ++k)
        seeds[static_cast<std::size_t>(k)] = job_.seeds[first + static_cast<std::size_t>(k)];
      planar::TestbedActuators<R> actuators(actuator_parameters, assumed, plant, job_.timing.step);
      planar::TestbedSensors<R> sensors(sensor_parameters, job_.timing.control_steps,
                                        job_.timing.step, seeds, start, pose_of(plant, start));
      store(first, count,
            planar::rollout<true>(plant, start, goal, law, actuators, sensors, pushes, job_.timing,
                                  record));
    }
  }

 private:
  void store(std::size_t first, int count, const planar::Outcomes<R>& outcomes) const {
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const auto& outcome = outcomes[i];
      const std::size_t world = first + i;
      double* metric = job_.metrics + world * job_.metric_count;
      outcome.metrics.report([&](const Field&, double x) { *metric++ = x; });
      double* entry = job_.audit + world * job_.audit_count;
      outcome.audit.report([&](const Field&, double x) { *entry++ = x; });
      const auto& s = outcome.state;
      const std::array<double, 10> state{
          s.bar.y,          s.bar.z,          s.theta[0],     s.theta[1],     s.theta[2],
          s.bar_velocity.y, s.bar_velocity.z, s.theta_dot[0], s.theta_dot[1], s.theta_dot[2]};
      std::copy(state.begin(), state.end(), job_.final_state + world * 10);
      job_.end_time[world] = outcome.end_time;
      job_.status[world] = static_cast<std::int8_t>(outcome.status);
      job_.culprit[world] = static_cast<std::int8_t>(outcome.culprit);
    }
  }

  const Job& job_;
};

/// Hands blocks of lanes to threads; meanwhile the calling thread reports progress and listens for
/// Ctrl-C about ten times a second.
template <class RunBlock>
void run_blocks(std::size_t worlds, unsigned threads, const nb::object& progress,
                const RunBlock& run_block) {
  std::atomic<std::size_t> next{0}, done{0};
  std::atomic<bool> cancelled{false};
  std::atomic<unsigned> running{threads};
  std::mutex mutex;
  std::condition_variable finished;
  const auto work = [&] {
    for (;;) {
      const std::size_t first = next.fetch_add(MULTILIFT_LANES);
      if (first >= worlds || cancelled) break;
      run_block(first);
      done += std::min<std::size_t>(MULTILIFT_LANES, worlds - first);
    }
    const std::lock_guard lock(mutex);
    if (--running == 0) finished.notify_all();
  };
  std::vector<std::thread> pool;
  const auto stop = [&] {
    cancelled = true;
    nb::gil_scoped_release unlock;
    for (std::thread& thread : pool) thread.join();
    pool.clear();
  };
  for (unsigned k = 0; k < threads; ++k) pool.emplace_back(work);
  try {
    for (bool over = false; !over;) {
      {
        nb::gil_scoped_release unlock;
        std::unique_lock lock(mutex);
        over =
            finished.wait_for(lock, std::chrono::milliseconds(100), [&] { return running == 0; });
      }
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      if (!progress.is_none()) progress(done.load());
    }
  } catch (...) {
    stop();
    throw;
  }
  stop();
}

Body body_from(const std::string& name) {
  if (name == "vehicle_1") return Body::vehicle_1;
  if (name == "vehicle_2") return Body::vehicle_2;
  return Body::bar;
}

PushShape shape_from(const std::string& name) {
  if (name == "half_sine") return PushShape::half_sine;
  if (name == "sine") return PushShape::sine;
  if (name == "samples") return PushShape::samples;
  return PushShape::pulse;
}

using PushTuple = std::tuple<std::string, std::string, std::vector<double>, std::vector<double>>;

void run(const std::string& law, const Array2<const double>& rows,
         const Array1<const std::uint64_t>& seeds, const std::vector<PushTuple>& pushes,
         double step, long steps, long control_steps, long record_steps, bool ideal,
         const Array2<double>& metrics, const Array2<double>& audit,
         const Array2<double>& final_state, const Array1<double>& end_time,
         const Array1<std::int8_t>& status, const Array1<std::int8_t>& culprit,
         const nb::object& samples, unsigned threads, const nb::object& progress) {
  Job job{rows.data(),
          rows.shape(1),
          seeds.data(),
          rows.shape(0),
          {},
          {step, steps, control_steps, record_steps},
          ideal,
          metrics.data(),
          audit.data(),
          final_state.data(),
          end_time.data(),
          status.data(),
          culprit.data(),
          nullptr,
          metrics.shape(1),
          audit.shape(1),
          0,
          0};
  for (const auto& [body, shape, times, values] : pushes)
    job.pushes.push_back({body_from(body), shape_from(shape), times, values});
  if (!samples.is_none()) {
    const auto array =
        nb::cast<nb::ndarray<double, nb::ndim<3>, nb::c_contig, nb::device::cpu>>(samples);
    job.samples = array.data();
    job.sample_rows = array.shape(1);
    job.sample_columns = array.shape(2);
  }
  bool known = false;
  planar::for_each_law<R>([&]<class Law>() {
    if (law != Law::name) return;
    known = true;
    const std::size_t expected =
        2 * count_scalars<planar::Parameters<R>>() + count_scalars<typename Law::Gains>() +
        count_scalars<planar::ActuatorParameters<R>>() +
        count_scalars<planar::SensorParameters<R>>() + 14 + 6 * job.pushes.size();
    if (job.columns != expected)
      throw std::invalid_argument("a world takes " + std::to_string(expected) + " numbers, got " +
                                  std::to_string(job.columns));
    const Kernel<Law> kernel(job);
    run_blocks(job.worlds, threads, progress, [&](std::size_t first) { kernel.run(first); });
  });
  if (!known) throw std::invalid_argument("no compiled law is called '" + law + "'");
}

}  // namespace

NB_MODULE(MULTILIFT_BATCH_MODULE, m) {
  m.doc() = "Compiled batch kernel of multilift for one instruction set. Use multilift.batch.";
  m.attr("lanes") = MULTILIFT_LANES;
  m.def("run", &run, nb::arg("law"), nb::arg("rows"), nb::arg("seeds"), nb::arg("pushes"),
        nb::arg("step"), nb::arg("steps"), nb::arg("control_steps"), nb::arg("record_steps"),
        nb::arg("ideal"), nb::arg("metrics"), nb::arg("audit"), nb::arg("final_state"),
        nb::arg("end_time"), nb::arg("status"), nb::arg("culprit"), nb::arg("samples").none(),
        nb::arg("threads"), nb::arg("progress").none(),
        "Runs every row's world and fills the arrays. Releases the GIL.");
}

}  // namespace multilift::bindings
