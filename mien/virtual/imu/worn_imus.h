#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/face.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/skin_site.h"
#include "mien/virtual/stage.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// IMUs glued to the skin.
class WornImus final : public WornDevices {
 public:
  /// `rig`: of nothing but these. `sites`: where its sensors are on the skin, in its order.
  WornImus(sensor::Rig rig, DeviceFaults faults, std::vector<SkinSite> sites)
      : rig_(std::move(rig)), faults_(std::move(faults)), sites_(std::move(sites)) {}

  [[nodiscard]] const std::vector<SkinSite>& sites() const { return sites_; }

  [[nodiscard]] performer::PrologueNeeds prologue(const Stage& stage) const override;
  [[nodiscard]] Result<Sent> send(const Stage& stage, const Progress& progress) const override;
  /// In the profile *device*.
  [[nodiscard]] bool streams(bool lab) const override { return !lab; }
  [[nodiscard]] Result<std::unique_ptr<SessionStream>> stream(const Stage& stage) const override;
  [[nodiscard]] Result<std::unique_ptr<NodeDevices>> on_network(const Stage& stage,
                                                                const PlayedMotion& motion,
                                                                NodeLanguage language) const override;

 private:
  sensor::Rig rig_;
  DeviceFaults faults_;
  std::vector<SkinSite> sites_;
};

/// Reads their faults (the profile *lab* has none) and draws placement and skin from `root`. Errors: those of
/// read_faults(), parse_faults() and skin_sites().
[[nodiscard]] Result<std::shared_ptr<const WornDevices>> wear_imus(const StageRequest& request,
                                                                   face::Face face, const Random& root,
                                                                   const Stage& stage);

}  // namespace mien::virt
