#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// Devices of several modalities that one performer wears, each of which knows a rig of its own sensors
/// alone.
class WornTogether final : public WornDevices {
 public:
  struct Part {
    std::shared_ptr<const WornDevices> worn;
    std::vector<std::uint16_t> sensors;  ///< Of each sensor of its rig, the number in the whole rig.
  };
  /// `parts`: at least one; the whole rig's reference is among the sensors of the first.
  explicit WornTogether(std::vector<Part> parts) : parts_(std::move(parts)) {}

  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }

  /// All that any of them needs.
  [[nodiscard]] performer::PrologueNeeds prologue(const Stage& stage) const override;
  [[nodiscard]] Result<Sent> send(const Stage& stage, const Progress& progress) const override;
  /// Those that send by themselves.
  [[nodiscard]] Result<std::unique_ptr<NodeDevices>> on_network(const Stage& stage,
                                                                const PlayedMotion& motion,
                                                                NodeLanguage language) const override;

 private:
  std::vector<Part> parts_;
};

}  // namespace mien::virt
