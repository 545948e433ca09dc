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

}  // namespace mien::tracker
