// Every compiled spatial law. A new law is its own file and one entry here; scenarios, the command
// line, error messages and the reference page learn of it by themselves.
#pragma once

#include <memory>
#include <string>
#include <tuple>

#include "multilift/control/spatial/energy_coupled.hpp"
#include "multilift/control/spatial/geometric.hpp"
#include "multilift/control/spatial/lqr.hpp"
#include "multilift/control/spatial/momentum_coupled.hpp"
#include "multilift/control/spatial/pd.hpp"

namespace multilift::spatial {

template <Real R>
struct Laws {
  using List = std::tuple<EnergyCoupled<R>, Pd<R>, Geometric<R>, Lqr<R>, MomentumCoupled<R>>;
};

/// Calls f.template operator()<Law>() for each compiled law.
template <Real R, class F>
void for_each_law(F&& f) {
  [&]<class... L>(std::tuple<L...>*) {
    (f.template operator()<L>(), ...);
  }(static_cast<typename Laws<R>::List*>(nullptr));
}

/// A law by its name, or nothing if there is none of that name. `gains_of<Gains>()` supplies its
/// gains.
template <Real R, class GainsOf>
std::unique_ptr<Law<R>> make_law(const std::string& name, const Parameters<R>& assumed,
                                 double period, GainsOf&& gains_of) {
  std::unique_ptr<Law<R>> law;
  for_each_law<R>([&]<class L>() {
    if (name == L::name)
      law = std::make_unique<L>(gains_of.template operator()<typename L::Gains>(), assumed, period);
  });
  return law;
}

}  // namespace multilift::spatial
