#pragma once

#include <set>
#include <string>
#include <vector>

#include "mien/session/report.h"

namespace mien::app {

/// Phones that are heard and bound to no sensor, such as a second one beside the first, in words for a
/// person, each once. A pure function of its calls.
class PhonesBeside {
 public:
  /// What is to be said now of a session that is so.
  [[nodiscard]] std::vector<std::string> tell(const session::Report& report);

 private:
  std::set<std::string> told_;  // Devices: as many as protocols have places.
};

}  // namespace mien::app
