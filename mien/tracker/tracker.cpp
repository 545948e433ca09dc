#include "mien/tracker/tracker.h"

#include <algorithm>
#include <array>

namespace mien::tracker {
namespace {

/// In the order of Step.
constexpr std::array<std::string_view, 4> kStepNames = {"", "neutral", "nod", "shake"};

}  // namespace

std::string_view step_name(Step step) {
  return kStepNames[static_cast<std::size_t>(step)];
}

Step step_named(std::string_view name) {
  const auto found = std::ranges::find(kStepNames, name);
  return found == kStepNames.end() ? Step::none : static_cast<Step>(found - kStepNames.begin());
}

}  // namespace mien::tracker
