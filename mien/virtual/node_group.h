#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/performer/encore.h"
#include "mien/virtual/node.h"
#include "mien/virtual/stage.h"
#include "mien/virtual/worn_devices.h"

namespace mien::sensor {
struct SealKey;
}

namespace mien::virt {

class SealedNode;

/// All nodes of a performer, one an IMU of the rig or a board of its eyewear, one a microphone and one a
/// phone, and their simulation, which runs a little ahead of the performance. The devices are those of
/// play(): the same stage gives the same samples.
class NodeGroup {
 public:
  /// `again`: the motion is played again and again. Errors: bad_usage (the profile *lab*; a language that the
  /// devices do not have), those of WornDevices::on_network().
  [[nodiscard]] static Result<std::unique_ptr<NodeGroup>> create(Stage stage, NodeLanguage language,
                                                                 bool again);
  NodeGroup(const NodeGroup&) = delete;
  NodeGroup& operator=(const NodeGroup&) = delete;
  ~NodeGroup();

  /// All nodes are paired by this key: what they say leaves sealed. Once, before they say anything. Nodes
  /// of SlimeVR's language, and phones, cannot be. `power_ons`: as SealedNode has it.
  void seal(const sensor::SealKey& key, std::uint32_t power_ons);

  [[nodiscard]] std::size_t size() const { return nodes_.size(); }
  [[nodiscard]] Node& operator[](std::size_t node) { return *nodes_[node]; }
  /// Which playing of the motion is on at this moment of the performance (s), from 1; and how far it is,
  /// from 0 to 1. The first begins with the prologue.
  struct Round {
    std::size_t number = 1;
    double share = 0;
  };
  [[nodiscard]] Round round_at(double time_s) const;

  void begin(HostTime start);
  /// Simulates a sixtieth of a second more (0.2 ms of work for twelve IMUs, a millisecond for eyewear).
  /// Errors: what the nodes find.
  [[nodiscard]] Result<void> simulate();
  /// True time up to which everything is simulated, s from the performance's time 0; infinite when all is:
  /// what the nodes say from then on is not known yet.
  [[nodiscard]] double simulated_s() const;
  /// All is simulated and said.
  [[nodiscard]] bool finished() const;

 private:
  NodeGroup(Stage stage, bool again);

  Stage stage_;
  std::optional<performer::Encore> encore_;
  face::MotionCurve curve_;
  std::unique_ptr<NodeDevices> devices_;
  std::vector<std::unique_ptr<SealedNode>> sealed_;  // One around each of the devices', or none.
  std::vector<Node*> nodes_;                         // Those, or else the devices' own.
};

}  // namespace mien::virt
