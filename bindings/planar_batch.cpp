// Worlds by the million: the planar rollout over SIMD lanes and threads.
//
// This file is compiled once for each instruction set, each time as an extension module of its own,
// so that no inline function of one can stand in for another's. The arithmetic is the same in all
// of them, and so are the bits of the results.
#include "planar_path.hpp"
#include "planar_rows.hpp"
#include "run_blocks.hpp"

namespace multilift::bindings {

namespace {

using planar::Push;
using planar::State;

using R = Lanes<MULTILIFT_LANES>;

/// The problem and where its results go; every array is the caller's.
struct Job {
  const double* rows;
  std::size_t columns;
  const std::uint64_t* seeds;
  std::size_t worlds;
  std::vector<PushShapes> pushes;
  Timing timing;
  bool ideal;
  planar::Path path;  // of the bar relative to its goal; none: the goal rests from the start
  planar::View view;
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
    const State<R> start = start_from(next);
    planar::PerAxis<R> goal;
    for (Vec2<R>& g : goal) g = {next(), next()};
    const std::vector<Push<R>> pushes = pushes_from(job_.pushes, next);

    Law law(gains, assumed, goal, job_.timing.control_period());
    const auto reference = reference_along(job_.path, assumed, goal, job_.view);
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
                                  record, pointer_to(reference)));
    } else {
      std::array<std::uint64_t, MULTILIFT_LANES> seeds{};
      for (int k = 0; k < count; ++k)
        seeds[static_cast<std::size_t>(k)] = job_.seeds[first + static_cast<std::size_t>(k)];
      planar::TestbedActuators<R> actuators(actuator_parameters, assumed, plant, job_.timing.step);
      planar::TestbedSensors<R> sensors(sensor_parameters, job_.timing.control_steps,
                                        job_.timing.step, seeds, start, pose_of(plant, start));
      store(first, count,
            planar::rollout<true>(plant, start, goal, law, actuators, sensors, pushes, job_.timing,
                                  record, pointer_to(reference)));
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
      const std::array<double, 10> state = outcome.state.flat();
      std::copy(state.begin(), state.end(), job_.final_state + world * 10);
      job_.end_time[world] = outcome.end_time;
      job_.status[world] = static_cast<std::int8_t>(outcome.status);
      job_.culprit[world] = static_cast<std::int8_t>(outcome.culprit);
    }
  }

  const Job& job_;
};

void run(const std::string& law, const Array2<const double>& rows,
         const Array1<const std::uint64_t>& seeds, const std::vector<PushTuple>& pushes,
         double step, long steps, long control_steps, long record_steps, bool ideal,
         const Array2<double>& metrics, const Array2<double>& audit,
         const Array2<double>& final_state, const Array1<double>& end_time,
         const Array1<std::int8_t>& status, const Array1<std::int8_t>& culprit,
         const nb::object& samples, unsigned threads, const nb::object& progress,
         const std::vector<PlanarPiece>& pieces, double path_end,
         const std::array<double, 3>& view) {
  Job job{rows.data(),
          rows.shape(1),
          seeds.data(),
          rows.shape(0),
          shapes_from(pushes),
          {step, steps, control_steps, record_steps},
          ideal,
          planar_path(pieces, path_end),
          planar_view(view),
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
    check_columns<typename Law::Gains>(job.columns, job.pushes.size());
    const Kernel<Law> kernel(job);
    run_blocks(job.worlds, threads, progress, [&](std::size_t first) { kernel.run(first); });
  });
  if (!known) throw std::invalid_argument("no compiled law is called '" + law + "'");
}

}  // namespace

void bind_planar_batch(nb::module_& m) {
  m.def("run", &run, nb::arg("law"), nb::arg("rows"), nb::arg("seeds"), nb::arg("pushes"),
        nb::arg("step"), nb::arg("steps"), nb::arg("control_steps"), nb::arg("record_steps"),
        nb::arg("ideal"), nb::arg("metrics"), nb::arg("audit"), nb::arg("final_state"),
        nb::arg("end_time"), nb::arg("status"), nb::arg("culprit"), nb::arg("samples").none(),
        nb::arg("threads"), nb::arg("progress").none(), nb::arg("pieces"), nb::arg("path_end"),
        nb::arg("view"), "Runs every row's world and fills the arrays. Releases the GIL.");
}

}  // namespace multilift::bindings
