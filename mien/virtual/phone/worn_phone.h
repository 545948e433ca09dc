#pragma once

#include <memory>

#include "mien/core/random.h"
#include "mien/face/face.h"
#include "mien/virtual/phone/phone_faults.h"
#include "mien/virtual/phone/phone_simulator.h"
#include "mien/virtual/stage.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// A phone that looks at the performer's face beside what is worn, and tells it in Live Link Face's packets.
class WornPhone final : public WornDevices {
 public:
  explicit WornPhone(const PhoneFaults& faults) : faults_(faults) {}

  /// Nothing: it is not calibrated, and performances are the same with it and without.
  [[nodiscard]] performer::PrologueNeeds prologue(const Stage& stage) const override;
  [[nodiscard]] Result<Sent> send(const Stage& stage, const Progress& progress) const override;
  /// Whatever the boards' language is: to whom it sends is told apart by its id (phone::kLiveLinkDevice).
  [[nodiscard]] Result<std::unique_ptr<NodeDevices>> on_network(const Stage& stage,
                                                                const PlayedMotion& motion,
                                                                NodeLanguage language) const override;

 private:
  PhoneFaults faults_;
};

/// Reads its faults: usual_phone()'s where there is no such table; the profile *lab* has none. Errors:
/// unsupported (more than one), bad_usage (it is not bound as the first phone of Live Link Face that a
/// session hears), those of read_faults() and parse_phone_faults().
[[nodiscard]] Result<std::shared_ptr<const WornDevices>> wear_phone(const StageRequest& request,
                                                                    face::Face face, const Random& root,
                                                                    const Stage& stage);

}  // namespace mien::virt
