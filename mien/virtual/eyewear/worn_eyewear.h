#pragma once

#include <memory>
#include <utility>

#include "mien/core/random.h"
#include "mien/face/face.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/stage.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// Smart eyewear, and who wears it.
class WornEyewear final : public WornDevices {
 public:
  /// `rig`: of nothing but this eyewear's sensors.
  WornEyewear(sensor::Rig rig, EyewearFaults faults, EyewearWearer wearer)
      : rig_(std::move(rig)), faults_(std::move(faults)), wearer_(std::move(wearer)) {}

  [[nodiscard]] const EyewearFaults& faults() const { return faults_; }
  [[nodiscard]] const EyewearWearer& wearer() const { return wearer_; }

  [[nodiscard]] performer::PrologueNeeds prologue(const Stage& stage) const override;
  /// Errors: WornDevices::send()'s, those of EyewearBoards. Cost: about a second of one core for ten of
  /// performance.
  [[nodiscard]] Result<Sent> send(const Stage& stage, const Progress& progress) const override;
  [[nodiscard]] Result<std::unique_ptr<NodeDevices>> on_network(const Stage& stage,
                                                                const PlayedMotion& motion,
                                                                NodeLanguage language) const override;

 private:
  sensor::Rig rig_;
  EyewearFaults faults_;
  EyewearWearer wearer_;
};

/// Reads its faults and draws its seat from `root`. Errors: bad_usage (the profile *lab*, skin unlike the
/// face's), those of read_faults(), parse_eyewear_faults() and seat_eyewear().
[[nodiscard]] Result<std::shared_ptr<const WornDevices>> wear_eyewear(const StageRequest& request,
                                                                      face::Face face, const Random& root,
                                                                      const Stage& stage);

}  // namespace mien::virt
