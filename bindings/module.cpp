// The extension module multilift._core: one registration per concept.
#include <nanobind/nanobind.h>

namespace multilift::bindings {
void bind_math(nanobind::module_& m);
void bind_planar_model(nanobind::module_& m);
void bind_planar_control(nanobind::module_& m);
void bind_planar_rollout(nanobind::module_& m);
}  // namespace multilift::bindings

NB_MODULE(_core, m) {
  m.doc() = "Compiled core of multilift. Use the multilift package; this module may change.";
  m.def(
      "build_info",
      [] {
        nanobind::dict build;
        build["compiler"] = MULTILIFT_COMPILER;
        build["commit"] = MULTILIFT_COMMIT;
        return build;
      },
      "Compiler, and the commit of the sources where they were a checkout.");
  multilift::bindings::bind_math(m);
  multilift::bindings::bind_planar_model(m);
  multilift::bindings::bind_planar_control(m);
  multilift::bindings::bind_planar_rollout(m);
}
