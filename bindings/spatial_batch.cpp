// Spatial worlds by the million: the spatial rollout over SIMD lanes and threads.
//
// Compiled once for each instruction set, as planar_batch.cpp is.
#include "run_blocks.hpp"
#include "spatial_problem.hpp"

namespace multilift::bindings {

namespace {

using R = Lanes<MULTILIFT_LANES>;
template <class T>
using Array1 = nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <class T>
using Array2 = nb::ndarray<T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// Where the results go; every array is the caller's.
struct Results {
  Array2<double> metrics, audit, final_state;
  Array1<double> end_time;
  Array1<std::int8_t> status, culprit;
  double* samples;  // worlds x sample_rows x sample_columns, or null
  std::size_t sample_rows, sample_columns;
};

/// The worlds from `first` on, as many as there are lanes.
template <class Vehicles, class Cables>
void run_block(const Frame& frame, const Array2<const double>& rows,
               const Array1<const std::uint64_t>& seeds, const Results& results,
               std::size_t first) {
  const std::size_t left = rows.shape(0) - first;
  const int count = static_cast<int>(left < MULTILIFT_LANES ? left : MULTILIFT_LANES);
  typename sp::MotionCapture<R>::Seeds own{};
  for (int k = 0; k < count; ++k)
    own[static_cast<std::size_t>(k)] = seeds(first + static_cast<std::size_t>(k));
  const std::size_t columns = rows.shape(1);
  auto problem = problem_from<R, Vehicles, Cables>(
      frame, {rows.data() + first * columns, columns, count}, own);
  std::array<std::size_t, MULTILIFT_LANES> recorded{};
  const auto record = [&](const auto& sample, const mask_t<R>& whose) {
    if (results.samples == nullptr) return;
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(k);
      if (!lane(whose, k) || recorded[i] == results.sample_rows) continue;
      double* out = results.samples +
                    ((first + i) * results.sample_rows + recorded[i]++) * results.sample_columns;
      sp::visit_columns(sample, [&](const std::string&, const char*, const std::string&,
                                    const R& x) { *out++ = lane(x, k); });
    }
  };
  const auto finish = [&](int k, Status status, double time, const auto& x, const auto& metrics,
                          const auto& audit) {
    if (k >= count) return;
    const std::size_t world = first + static_cast<std::size_t>(k);
    double* metric = results.metrics.data() + world * results.metrics.shape(1);
    metrics.report(k, [&](const Field&, double number) { *metric++ = number; });
    double* entry = results.audit.data() + world * results.audit.shape(1);
    audit.visit([&](const Field&, const R& number) { *entry++ = lane(number, k); });
    double* out = results.final_state.data() + world * results.final_state.shape(1);
    const auto put = [&](const R& number) { *out++ = lane(number, k); };
    auto payload = x.payload;
    sp::zip(put, payload.position);
    sp::zip(put, payload.attitude);
    sp::zip(put, payload.velocity);
    sp::zip(put, payload.rate);
    for (auto vehicle : x.vehicle) {
      sp::zip(put, vehicle.position);
      sp::zip(put, vehicle.velocity);
    }
    results.end_time.data()[world] = time;
    results.status.data()[world] = static_cast<std::int8_t>(status);
    results.culprit.data()[world] = -1;
  };
  run_problem(frame, problem, *problem.law, record, finish);
}

void run(const Frame& frame, const Array2<const double>& rows,
         const Array1<const std::uint64_t>& seeds, const Array2<double>& metrics,
         const Array2<double>& audit, const Array2<double>& final_state,
         const Array1<double>& end_time, const Array1<std::int8_t>& status,
         const Array1<std::int8_t>& culprit, const nb::object& samples, unsigned threads,
         const nb::object& progress) {
  Results results{metrics, audit, final_state, end_time, status, culprit, nullptr, 0, 0};
  if (!samples.is_none()) {
    const auto array =
        nb::cast<nb::ndarray<double, nb::ndim<3>, nb::c_contig, nb::device::cpu>>(samples);
    results.samples = array.data();
    results.sample_rows = array.shape(1);
    results.sample_columns = array.shape(2);
  }
  with_kinds<R>(frame, [&]<class Vehicles, class Cables>() {
    // Refused here, where an exception reaches Python, rather than in a thread.
    const Rows one{rows.data(), rows.shape(1), 1};
    if (!problem_from<R, Vehicles, Cables>(frame, one, {}).law)
      throw std::invalid_argument("no compiled law is called '" + frame.law + "'");
    run_blocks(rows.shape(0), threads, progress, [&](std::size_t first) {
      run_block<Vehicles, Cables>(frame, rows, seeds, results, first);
    });
  });
}

}  // namespace

void bind_spatial_batch(nb::module_& m) {
  bind_frame(m);
  m.def("run_spatial", &run, nb::arg("frame"), nb::arg("rows"), nb::arg("seeds"),
        nb::arg("metrics"), nb::arg("audit"), nb::arg("final_state"), nb::arg("end_time"),
        nb::arg("status"), nb::arg("culprit"), nb::arg("samples").none(), nb::arg("threads"),
        nb::arg("progress").none(),
        "Runs every row's spatial world and fills the arrays. Releases the GIL.");
}

}  // namespace multilift::bindings
