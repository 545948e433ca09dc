#pragma once

#include <optional>
#include <vector>

#include "app/command.h"
#include "app/phone_option.h"
#include "mien/core/error.h"
#include "mien/measure/evaluation_json.h"
#include "mien/take/take.h"

namespace mien::app {

/// What takes are measured against.
class TruthOption {
 public:
  struct Truth {
    std::vector<take::TruthFrame> frames;
    std::optional<measure::ToldTruth> told;  ///< None: the take's own.
  };

  void add_to(const Command& command);
  /// Whether a phone's is asked for.
  [[nodiscard]] bool told() const { return phone_.given(); }
  /// Errors: bad_usage (a phone's file for several takes).
  [[nodiscard]] Result<void> check(std::size_t takes) const;
  /// Says on stderr what align says. Errors: solve::own_truth's; of a phone's: check_aligns', take_features',
  /// PhoneOption::open's and phone_truth's.
  [[nodiscard]] Result<Truth> read(const take::Take& take) const;

 private:
  PhoneOption phone_;
};

}  // namespace mien::app
