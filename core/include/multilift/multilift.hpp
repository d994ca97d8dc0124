// The whole core. Namespace multilift::planar is the twin lift of two vehicles and a bar in a
// vertical plane.
#pragma once

#include "multilift/control/planar/laws.hpp"
#include "multilift/model/planar/redundant.hpp"
#include "multilift/model/planar/rest.hpp"
#include "multilift/scalar/dual.hpp"
#include "multilift/scalar/lanes.hpp"
#include "multilift/sim/planar/actuators.hpp"
#include "multilift/sim/planar/rollout.hpp"
#include "multilift/sim/planar/sensors.hpp"
#include "multilift/sim/planar/stepping.hpp"
