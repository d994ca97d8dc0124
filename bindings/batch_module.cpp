// The extension module of one instruction set: one registration per concept.
#include <nanobind/nanobind.h>

namespace multilift::bindings {
void bind_batch_math(nanobind::module_& m);
void bind_batch_peak(nanobind::module_& m);
void bind_planar_batch(nanobind::module_& m);
void bind_planar_worlds(nanobind::module_& m);
void bind_planar_gradient(nanobind::module_& m);
void bind_spatial_batch(nanobind::module_& m);
}  // namespace multilift::bindings

NB_MODULE(MULTILIFT_BATCH_MODULE, m) {
  m.doc() = "Compiled kernels of multilift for one instruction set. Use multilift.batch.";
  m.attr("lanes") = MULTILIFT_LANES;
  multilift::bindings::bind_batch_math(m);
  multilift::bindings::bind_batch_peak(m);
  multilift::bindings::bind_planar_batch(m);
  multilift::bindings::bind_planar_worlds(m);
  multilift::bindings::bind_planar_gradient(m);
  multilift::bindings::bind_spatial_batch(m);
}
