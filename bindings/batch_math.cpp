// The core's functions as the lanes of this instruction set compute them.
//
// Compiled once for each instruction set, like planar_batch.cpp.
#include "math_arrays.hpp"

namespace multilift::bindings {

void bind_batch_math(nb::module_& m) { bind_math_arrays<Lanes<MULTILIFT_LANES>>(m); }

}  // namespace multilift::bindings
