#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// Devices of two modalities that one performer wears, each of which knows a rig of its own sensors alone:
/// those that feel the performance, among them the whole rig's reference, and microphones, which need no
/// prologue.
class WornTogether final : public WornDevices {
 public:
  struct Part {
    std::shared_ptr<const WornDevices> worn;
    std::vector<std::uint16_t> sensors;  ///< Of each sensor of its rig, the number in the whole rig.
  };
  WornTogether(Part feeling, std::shared_ptr<const WornDevices> hearing)
      : feeling_(std::move(feeling)), hearing_(std::move(hearing)) {}

  [[nodiscard]] performer::PrologueNeeds prologue(const Stage& stage) const override;
  [[nodiscard]] Result<Sent> send(const Stage& stage, const Progress& progress) const override;
  [[nodiscard]] std::vector<take::CalibrationVersion> calibrations(
      const Stage& stage, const VirtualSession& session) const override;
  [[nodiscard]] Result<std::unique_ptr<NodeDevices>> on_network(const Stage& stage,
                                                                const PlayedMotion& motion,
                                                                NodeLanguage language) const override;

 private:
  Part feeling_;
  std::shared_ptr<const WornDevices> hearing_;
};

}  // namespace mien::virt
