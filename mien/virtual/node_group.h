#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/virtual/encore.h"
#include "mien/virtual/imu_simulator.h"
#include "mien/virtual/node.h"
#include "mien/virtual/skin_trajectory.h"
#include "mien/virtual/stage.h"

namespace mien::virt {

/// What nodes speak on the network.
enum class NodeLanguage {
  mien,     ///< Our own packets.
  slimevr,  ///< A SlimeVR tracker's.
};

/// All nodes of a performer, one a sensor of the rig, and their simulation, which runs a little ahead of the
/// performance. The devices are those of play_devices(): the same stage gives the same samples.
class NodeGroup {
 public:
  /// `again`: the motion is played again and again. The stage is not the profile *lab*'s.
  NodeGroup(Stage stage, NodeLanguage language, bool again);
  NodeGroup(const NodeGroup&) = delete;
  NodeGroup& operator=(const NodeGroup&) = delete;

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
  /// Simulates a sixtieth of a second more (0.2 ms of work for twelve sensors). Errors: what the nodes find.
  [[nodiscard]] Result<void> simulate();
  /// True time up to which everything is simulated, s from the performance's time 0; infinite when all is:
  /// what the nodes say from then on is not known yet.
  [[nodiscard]] double simulated_s() const;
  /// All is simulated and said.
  [[nodiscard]] bool finished() const;

 private:
  Stage stage_;
  std::optional<Encore> encore_;
  face::MotionCurve curve_;
  SkinTracer tracer_;
  std::vector<ImuSimulator> simulators_;
  std::vector<std::unique_ptr<Node>> nodes_;
};

}  // namespace mien::virt
