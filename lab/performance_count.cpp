#include "lab/performance_count.h"

#include <fmt/format.h>

#include <string_view>

namespace mien::lab {

Progress PerformanceCount::progress() {
  return [this](double, std::string_view) {
    const std::size_t done = done_;
    if (!progress_(static_cast<double>(done) / static_cast<double>(whole_),
                   fmt::format("{} of {} performances", done, whole_)))
      stopped_ = true;
    return !stopped();
  };
}

Result<void> PerformanceCount::go_on() const {
  if (stopped()) return fail(ErrorCode::cancelled, "stopped before all performances were done");
  return {};
}

}  // namespace mien::lab
