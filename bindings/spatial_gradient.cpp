// Exact derivatives of a spatial run: the same rollout over dual numbers, some directions at a
// time.
#include "cursor.hpp"
#include "multilift/scalar/dual.hpp"
#include "spatial_problem.hpp"

namespace multilift::bindings {

namespace {

/// Directions in one rollout: as many as fill a vector register everywhere.
constexpr int directions = 2;
using D = Dual<directions>;
using Tangents = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// A world's numbers, each with its derivatives along one group of directions.
struct SeededRow {
  const double* values;
  const Tangents& tangents;
  std::size_t first, stride;

  template <Real R>
  R at(std::size_t column) const {
    R x(values[column]);
    for (std::size_t k = 0; k < directions && first + k < tangents.shape(0); ++k)
      x.d[k] = tangents.data()[(first + k) * stride + column];
    return x;
  }
};

struct Answer {
  Status status{};
  double end_time{0.0};
  std::vector<D> numbers;  // final state, metrics, audit
};

Answer run_along(const Frame& frame, const SeededRow& row, std::uint64_t seed) {
  Answer answer;
  with_kinds<D>(frame, [&]<class Vehicles, class Cables>() {
    auto problem = problem_from<D, Vehicles, Cables>(frame, row, {seed});
    if (!problem.law) throw std::invalid_argument("no compiled law is called '" + frame.law + "'");
    run_problem(
        frame, problem, *problem.law, [](const auto&, bool) {},
        [&](int k, Status status, double time, const auto& x, const auto& metrics,
            const auto& audit) {
          answer.status = status;
          answer.end_time = time;
          const auto put = [&](const D& number) { answer.numbers.push_back(number); };
          auto payload = x.payload;
          sp::zip(put, payload);
          for (auto vehicle : x.vehicle) {
            sp::zip(put, vehicle.position);
            sp::zip(put, vehicle.velocity);
          }
          metrics.report(k, [&](const Field&, const D& number) { put(number); });
          audit.visit([&](const Field&, const D& number) { put(number); });
        });
  });
  return answer;
}

nb::dict gradient(const Frame& frame, const FlatIn& row, std::uint64_t seed,
                  const Tangents& tangents) {
  const std::size_t keys = tangents.shape(0), columns = row.shape(0);
  if (tangents.shape(1) != columns)
    throw std::invalid_argument("tangents have another number of columns than the row");
  Answer answer;
  std::vector<double> primal, derivative;
  {
    nb::gil_scoped_release unlock;
    for (std::size_t first = 0; first < keys || first == 0; first += directions) {
      answer = run_along(frame, {row.data(), tangents, first, columns}, seed);
      primal.resize(answer.numbers.size());
      derivative.resize(primal.size() * keys);
      for (std::size_t i = 0; i < primal.size(); ++i) {
        primal[i] = answer.numbers[i].x;
        for (std::size_t k = 0; k < directions && first + k < keys; ++k)
          derivative[i * keys + first + k] = answer.numbers[i].d[k];
      }
    }
  }
  nb::dict d;
  d["status"] = multilift::name_of(answer.status);
  d["culprit"] = -1;
  d["end_time"] = answer.end_time;
  d["values"] = primal;
  d["derivatives"] = derivative;
  return d;
}

}  // namespace

void bind_spatial_gradient(nb::module_& m) {
  m.def("spatial_gradient", &gradient, nb::arg("frame"), nb::arg("row"), nb::arg("seed"),
        nb::arg("tangents"),
        "A run's final state, metrics and audit, and row by row their derivatives along each row "
        "of tangents. Releases the GIL.");
}

}  // namespace multilift::bindings
