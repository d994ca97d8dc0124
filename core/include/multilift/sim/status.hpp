// How a rollout ended. The hot path returns one of these; exceptions belong to the layers above.
#pragma once

namespace multilift {

enum class Status {
  finished,     // ran its full duration
  diverged,     // a number of the state stopped being finite or left all bounds
  slack,        // a cable would carry negative tension: the taut-cable model ends here
  swing_limit,  // an angle reached +-pi/2: the model's assumption 3 ends here
  collision,    // two vehicles, or a vehicle and another's cable, came too close
};

inline const char* name_of(Status status) {
  switch (status) {
    case Status::finished:
      return "finished";
    case Status::diverged:
      return "diverged";
    case Status::slack:
      return "slack";
    case Status::swing_limit:
      return "swing_limit";
    case Status::collision:
      return "collision";
  }
  return "unknown";
}

}  // namespace multilift
