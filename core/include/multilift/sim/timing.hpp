// The steps of a run.
#pragma once

namespace multilift {

struct Timing {
  double step{0.001};     // of the integrator, s
  long steps{0};          // how many
  long control_steps{1};  // integration steps in a control period
  long record_steps{1};   // integration steps between two records

  double control_period() const { return step * static_cast<double>(control_steps); }
};

}  // namespace multilift
