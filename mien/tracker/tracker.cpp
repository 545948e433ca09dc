#include "mien/tracker/tracker.h"

namespace mien::tracker {

std::string_view step_name(Step step) {
  switch (step) {
    case Step::none:
      return "";
    case Step::neutral:
      return "neutral";
    case Step::nod:
      return "nod";
    case Step::shake:
      return "shake";
  }
  return "";
}

Step step_named(std::string_view name) {
  for (const Step step : {Step::neutral, Step::nod, Step::shake})
    if (step_name(step) == name) return step;
  return Step::none;
}

}  // namespace mien::tracker
