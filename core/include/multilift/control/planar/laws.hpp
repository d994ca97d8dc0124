// Every compiled planar law. A new law is its own file and one entry here; scenarios, the command
// line, error messages and the reference page learn of it by themselves.
#pragma once

#include <tuple>

#include "multilift/control/planar/energy_coupled.hpp"
#include "multilift/control/planar/momentum_coupled.hpp"
#include "multilift/control/planar/pd.hpp"

namespace multilift::planar {

template <Real R>
struct Laws {
  using List = std::tuple<EnergyCoupled<R>, Pd<R>, MomentumCoupled<R>>;
};

/// Calls f.template operator()<Law>() for each compiled law.
template <Real R, class F>
void for_each_law(F&& f) {
  [&]<class... Law>(std::tuple<Law...>*) {
    (f.template operator()<Law>(), ...);
  }(static_cast<typename Laws<R>::List*>(nullptr));
}

}  // namespace multilift::planar
