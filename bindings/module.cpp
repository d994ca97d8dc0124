// The extension module multilift._core: one registration per concept.
#include <nanobind/nanobind.h>

namespace multilift::bindings {
void bind_math(nanobind::module_& m);
void bind_plan(nanobind::module_& m);
void bind_planar_model(nanobind::module_& m);
void bind_planar_control(nanobind::module_& m);
void bind_planar_rollout(nanobind::module_& m);
void bind_spatial_rollout(nanobind::module_& m);
void bind_spatial_law(nanobind::module_& m);
void bind_spatial_world(nanobind::module_& m);
void bind_spatial_gradient(nanobind::module_& m);
void bind_planar_counting(nanobind::module_& m);
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
  m.def(
      "instruction_sets",
      [] {
        nanobind::list sets;
#if defined(__x86_64__)
        __builtin_cpu_init();
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
            __builtin_cpu_supports("avx512vl"))
          sets.append("avx512");
        if (__builtin_cpu_supports("avx2")) sets.append("avx2");
#endif
        sets.append("baseline");
        return sets;
      },
      "Names of the batch kernels that this processor can run, widest first.");
  multilift::bindings::bind_math(m);
  multilift::bindings::bind_plan(m);
  multilift::bindings::bind_planar_model(m);
  multilift::bindings::bind_planar_control(m);
  multilift::bindings::bind_planar_rollout(m);
  multilift::bindings::bind_spatial_rollout(m);
  multilift::bindings::bind_spatial_law(m);
  multilift::bindings::bind_spatial_world(m);
  multilift::bindings::bind_spatial_gradient(m);
  multilift::bindings::bind_planar_counting(m);
}
