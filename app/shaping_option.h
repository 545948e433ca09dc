#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/command.h"
#include "mien/core/error.h"
#include "mien/shaping/settings.h"

namespace mien::app {

/// The settings of shaping that a command which solves takes is given.
struct ShapingOption {
  std::string path;  ///< Empty: none.

  void add_to(Command command);
  /// None where no file is named. Errors: not_found, and parse_settings'.
  [[nodiscard]] Result<std::optional<shaping::ShaperSettings>> read() const;
};

/// `settings` with one more step left out each, in the order of the chain; last with none of them.
struct Ablated {
  std::string without;  ///< The step's name; "every step".
  shaping::ShaperSettings settings;
};
[[nodiscard]] std::vector<Ablated> ablations(const shaping::ShaperSettings& settings);

}  // namespace mien::app
